"""Compensate stage: networks and other methods that predict a panel's filters over temperature, compared."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from analysis.campaign_extent import CampaignExtent
from analysis.compensation.measured import compensate_measured
from analysis.compensation.outcome import Compensation
from analysis.compensation.settings import Training, suited_nodes
from analysis.compensation.study import compensate
from analysis.compensation.tilted import tilted_contrast
from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.methods import Method
from analysis.focusing.panel import Panel
from analysis.focusing.temperatures import covered
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.files.campaign_inputs import extent_settings
from app.files.compensation_file import save_compensation
from app.files.provenance import provenance
from app.stages.panel_inputs import workers
from app.summaries.display import as_text
from app.twins.panel_twin import panel_twin

COMPENSATION = "compensation.h5"
GOOD_LOSS = 0.02
"""Largest loss of contrast of networks against directly computed filters, at any line and temperature."""


@dataclass(frozen=True)
class CompensatedPanel:
    """Result of the compensate stage.

    Attributes
    ----------
    panel : Panel
    compensation : Compensation
        Networks and other methods, with the performance of each.
    spacing : float or None
        Spacing of training temperatures, K; None where they were placed, or measured.
    device : str
        Device on which the networks were trained.
    measured : bool
        Whether the filters come from measured transfers; otherwise from laws and a twin.
    notes : tuple of str
        Where the laws come from, and what of the measured plate the panel has.
    """

    panel: Panel
    compensation: Compensation
    spacing: float | None
    device: str
    measured: bool = False
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Training temperatures, loss of contrast and recommended method in one line, and the notes."""
        found = self.compensation
        t, loss = found.temperature, found.largest_loss
        line = (
            f"CompensatedPanel: {len(found.training_temperature)} training temperatures, {t[0]:g} to {t[-1]:g} "
            f"°C: the networks lose at most {loss[0]:.2g} of contrast; recommended: {found.recommended}"
        )
        return as_text(line, self.notes)


def compute(
    panel: Panel,
    laws: MaterialLaws,
    report: Progress,
    *,
    training: Training | None = None,
    spacing: float = 5.0,
    method: Method = "stif",
    device: str = "cpu",
    place: int | None = None,
    across: Sequence[float] = (),
    notes: Sequence[str] = (),
) -> CompensatedPanel:
    """Build the panel's twin, train one network per actuator, and compare all methods.

    Parameters
    ----------
    laws : MaterialLaws
        As measured; thermal expansion of the panel's plate is added here.
    report : callable
        Called with a stage's name and the share of it done.
    training : Training, optional
        By default the standard settings, with fewer hidden nodes for few placed temperatures.
    spacing : float
        Spacing of training temperatures, K.
    method : str
        Design method of the filters that the networks predict.
    device : str
        Where they are trained: ``cpu``, or a device of torch, ``cuda``, ``cuda:1``.
    place : int, optional
        Number of training temperatures, placed by need instead of every `spacing`.
    across : sequence of float
        Differences of temperature between two opposite sides of the panel, K, for which contrast is computed.
    notes : sequence of str
        Of the laws' origin, kept in the result.

    Raises
    ------
    EvidenceCollapseError
        Where a network is refused.
    ValueError
        Where the common range of laws and panel is empty, has fewer than four training temperatures, or is
        narrower than a difference `across`.
    """
    laws = panel.plate.grown(laws)
    low, high = covered(laws, panel.filters.operating_range)
    model = panel_twin(panel, laws, report)
    found = compensate(
        model,
        panel,
        laws,
        spacing,
        training or (Training() if place is None else Training(nodes=suited_nodes(place))),
        _clock(device),
        device=device,
        report=report,
        method=method,
        workers=workers(),
        place=place,
    )
    if across:
        from app.twins.warm_twin import warm_twin  # slow import: mesher and assembly

        twin = warm_twin(panel, laws, report)
        tilted = tilted_contrast(
            twin, panel, found.filters, found.trained.networks.taps, across, (low, high), report
        )
        found = replace(found, tilted=tilted)
    return CompensatedPanel(panel, found, spacing if place is None else None, device, notes=tuple(notes))


def compute_measured(
    measured: MeasuredPanel,
    report: Progress,
    *,
    training: Training | None = None,
    method: Method = "stif",
    device: str = "cpu",
) -> CompensatedPanel:
    """Train one network per actuator on filters of measured transfers, and compare all methods without a twin.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    training : Training, optional
        By default the standard settings, with fewer hidden nodes for few temperatures.
    method : str
        Design method of the filters that the networks predict.
    device : str
        Where they are trained: ``cpu``, or a device of torch, ``cuda``, ``cuda:1``.

    Raises
    ------
    EvidenceCollapseError
        Where a network is refused.
    ValueError
        For transfers at fewer than five temperatures.
    """
    training = training or Training(nodes=suited_nodes(len(measured.transfers.temperature), measured=True))
    found = compensate_measured(measured, training, _clock(device), device, report, method, workers())
    return CompensatedPanel(measured.panel, found, None, device, measured=True)


def _clock(device: str) -> Callable[[], float]:
    """Clock for timing methods: the thread's processor time on the processor, wall time on other devices."""
    return time.thread_time if device == "cpu" else time.perf_counter


def save(
    run: Path, found: CompensatedPanel, inputs: Mapping[str, str], extent: CampaignExtent | None = None
) -> Path:
    """Write compensation.h5.

    Parameters
    ----------
    run : Path
        Run folder.
    inputs : mapping
        SHA-256 of every input file of the networks, by its name.
    extent : CampaignExtent, optional
        Of the campaign that the laws are from, where that was not complete.

    Returns
    -------
    Path
        File written.

    Raises
    ------
    OSError
        Where it cannot be written.
    """
    target, outcome = run / COMPENSATION, found.compensation
    settings = {
        "spacing": found.spacing,
        "place": None if outcome.placed is None else len(outcome.placed.temperature),
        "across": [] if outcome.tilted is None else outcome.tilted.difference.tolist(),
        "method": outcome.focusing,
        "device": found.device,
        "panel": found.panel.model_dump(mode="json"),
        "measured": found.measured,
        **extent_settings(extent),
    }
    save_compensation(target, found.panel, outcome, provenance(inputs, settings, outcome.trained.settings.seed))
    return target
