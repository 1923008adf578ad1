"""Compensate stage: networks and their rivals, trained on a panel's filters and judged, computed and saved."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from analysis.compensation.outcome import Compensation
from analysis.compensation.settings import Training
from analysis.compensation.study import compensate
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.files.compensation_file import save_compensation
from app.files.provenance import provenance
from app.stages.panel_inputs import workers
from app.twins.panel_twin import panel_twin

COMPENSATION = "compensation.h5"


@dataclass(frozen=True)
class CompensatedPanel:
    """Result of the compensate stage.

    Attributes
    ----------
    panel : Panel
    compensation : Compensation
        Networks, their rivals, and how well each does.
    spacing : float
        Between training temperatures, K.
    device : str
        Where torch trained.
    """

    panel: Panel
    compensation: Compensation
    spacing: float
    device: str

    def __repr__(self) -> str:
        """Training temperatures, contrast lost and the method recommended in one line."""
        found = self.compensation
        t, loss = found.temperature, found.largest_loss
        return (
            f"<CompensatedPanel: {len(found.training_temperature)} training temperatures, {t[0]:g} to {t[-1]:g} "
            f"°C: the networks lose at most {loss[0]:.2g} of contrast; recommended: {found.recommended}>"
        )


def compute(
    panel: Panel,
    laws: MaterialLaws,
    report: Progress,
    *,
    training: Training | None = None,
    spacing: float = 5.0,
    method: Method = "stif",
    device: str = "cpu",
) -> CompensatedPanel:
    """Build the panel's twin, train one network per actuator, and judge every method.

    Parameters
    ----------
    panel : Panel
    laws : MaterialLaws
        As measured; thermal expansion of the panel's plate is added here.
    report : callable
        Called with a stage's name and the share of it done.
    training : Training, optional
        Standard settings where it is left out.
    spacing : float
        Between training temperatures, K.
    method : str
        How the filters are designed that the networks have to follow.
    device : str
        Where torch trains: ``cpu``, ``cuda``, ``cuda:1``.

    Returns
    -------
    CompensatedPanel

    Raises
    ------
    EvidenceCollapseError
        Where a network is refused.
    ValueError
        Where laws and panel share no temperatures, or fewer than four training temperatures.
    """
    laws = panel.plate.grown(laws)
    found = compensate(
        panel_twin(panel, laws, report),
        panel,
        laws,
        spacing,
        training or Training(),
        time.perf_counter,
        device=device,
        report=report,
        method=method,
        workers=workers(),
    )
    return CompensatedPanel(panel, found, spacing, device)


def save(run: Path, found: CompensatedPanel, inputs: Mapping[str, str]) -> Path:
    """Write compensation.h5.

    Parameters
    ----------
    run : Path
        Run folder.
    found : CompensatedPanel
    inputs : mapping
        SHA-256 of every file that the networks follow from, by its name.

    Returns
    -------
    Path
        File written.

    Raises
    ------
    OSError
        Where it cannot be written.
    """
    target, trained = run / COMPENSATION, found.compensation.trained
    settings = {
        "spacing": found.spacing,
        "method": found.compensation.focusing,
        "device": found.device,
        "panel": found.panel.model_dump(mode="json"),
    }
    save_compensation(target, found.panel, found.compensation, provenance(inputs, settings, trained.settings.seed))
    return target
