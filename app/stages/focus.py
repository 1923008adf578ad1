"""Focus stage: filters of a panel over temperature, from laws or from measured transfers, computed and saved."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.focusing.design import tap_design
from analysis.focusing.measured import MeasuredPanel, compare_measured, focus_measured
from analysis.focusing.methods import Method, MethodComparison, compare, designer
from analysis.focusing.over_temperature import Focusing, focus
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import constants_at, covered, design_forms, responses, spaced
from analysis.focusing.pareto import ParetoCurve, pareto
from analysis.focusing.performance import Aim, aim, joined
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.recordings.campaign import CampaignExtent
from app.files.campaigns.inputs import extent_settings
from app.files.provenance import provenance
from app.files.results.panel_files import save_focusing
from app.stages.panel.inputs import workers
from app.summaries.numbers import span
from app.summaries.table import as_text
from app.twins.panel_twin import PanelTwin, panel_twin

FILTERS = "filters.h5"
USUAL_SPACING = 5.0
"""Default spacing of the filters' temperatures, K."""


@dataclass(frozen=True)
class FocusedPanel:
    """Result of the focus stage.

    Attributes
    ----------
    panel : Panel
    focusing : Focusing
        Filters at every temperature, with their performance.
    comparison : MethodComparison
        All methods with complex filters, on a plate of the illustration's constants, not of the laws.
    measured : bool
        Whether the filters come from measured transfers; otherwise from laws and a twin.
    uncorrected : Aim or None
        Performance of filters designed with the laws of a twin without its effects; None if not requested.
    notes : tuple of str
        Where the laws come from, and what of the measured plate the panel has.
    pareto : ParetoCurve or None
        Contrast against evenness of the sound, at the reference temperature; None for the aim at the field, and
        for measured transfers.
    """

    panel: Panel
    focusing: Focusing
    comparison: MethodComparison
    measured: bool
    uncorrected: Aim | None = None
    notes: tuple[str, ...] = ()
    pareto: ParetoCurve | None = None

    def __repr__(self) -> str:
        """Return method, taps, temperatures and contrast in one line, and the notes."""
        found = self.focusing
        own, kept, t = found.direct.contrast.mean(axis=1), found.fixed.contrast.mean(axis=1), found.temperature
        _, actuators, taps = found.bank.taps.shape
        line = (
            f"FocusedPanel: {found.method}, {actuators} filters of {taps} taps, {span(t, 'g')} °C: "
            f"contrast {span(own, '.2f')} with their own filters, down to {kept.min():.2f} with "
            f"those of {found.reference_temperature:g} °C"
        )
        return as_text(line, self.notes)


def uncorrected_aim(
    model: PanelTwin,
    panel: Panel,
    laws: MaterialLaws,
    uncorrected: MaterialLaws | None,
    temperature: NDArray[np.float64],
    method: Method,
) -> Aim | None:
    """Assess, on a panel with the true laws, FIR filters designed for the uncorrected laws.

    Parameters
    ----------
    laws : MaterialLaws
        True laws of the panel.
    uncorrected : MaterialLaws or None
        Laws for which the filters are designed.
    temperature : (T,) ndarray
        Degrees Celsius.
    method : str
        Design method.

    Returns
    -------
    Aim or None
        None where there are no uncorrected laws.
    """
    if uncorrected is None:
        return None
    settings, lines = panel.filters, panel.filters.frequency
    band = settings.in_band(lines)
    rule, design = designer(method, model, panel, lines), tap_design(method, model, panel, laws)
    sound = SoundAim.designing(panel, model.space.grid, method)
    asked = model.space.asked(panel.target.displacement)
    real = responses(model, laws, temperature, lines)
    believed = constants_at(uncorrected, temperature)
    reached = []
    for here, constants, (_, amplitude) in zip(temperature, believed, real, strict=True):
        guessed = model.forms(*constants, lines, panel.target.displacement)
        guessed = design_forms(model, panel, uncorrected, float(here), guessed, sound)
        taps = design.taps(guessed, rule(constants, partial(model.amplitudes, *constants, lines), guessed))
        filters = design.bank(taps[None], np.zeros(1)).response(lines[band])[0]
        forms = model.space.forms([amplitude[:, band]], panel.target.displacement)
        reached.append(aim(model.space, forms, amplitude[:, band], filters, asked))
    return joined(reached)


def compute(
    panel: Panel,
    laws: MaterialLaws,
    report: Progress,
    *,
    temperature: Real | None = None,
    method: Method = "stif",
    uncorrected: MaterialLaws | None = None,
    notes: Sequence[str] = (),
) -> FocusedPanel:
    """Design filters of a panel whose plate obeys laws.

    Parameters
    ----------
    laws : MaterialLaws
        As measured; thermal expansion of the panel's plate is added here.
    report : callable
        Called with a stage's name and the share of it done.
    temperature : (T,) ndarray, optional
        Degrees Celsius; by default every 5 K of the common range of laws and panel.
    method : str
        How filters are designed.
    uncorrected : MaterialLaws, optional
        Laws of a twin that lacks an effect; the performance of filters designed with them is computed, too.
    notes : sequence of str
        Of the laws' origin, kept in the result.

    Raises
    ------
    ValueError
        Where laws and panel have no common temperature.
    """
    laws = panel.plate.grown(laws)
    if temperature is None:
        temperature = spaced(*covered(laws, panel.filters.operating_range), USUAL_SPACING)
    model = panel_twin(panel, laws, report)
    focusing = focus(model, panel, laws, temperature, method, report, workers())
    believed = None if uncorrected is None else panel.plate.grown(uncorrected)
    lost = uncorrected_aim(model, panel, laws, believed, temperature, method)
    plate = panel.illustration
    comparison = compare(model, panel, (plate.youngs_modulus, plate.poisson_ratio, plate.loss_factor))
    curve = None
    if panel.filters.aim != "field":
        reference = focusing.reference_temperature
        (constants,) = constants_at(laws, np.array([reference]))
        curve = pareto(model, panel, constants, reference, report)
    return FocusedPanel(panel, focusing, comparison, False, lost, tuple(notes), curve)


def compute_measured(measured: MeasuredPanel, report: Progress, *, method: Method = "stif") -> FocusedPanel:
    """Design filters of a panel from its measured transfers.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    method : str
        How filters are designed.

    Raises
    ------
    ValueError
        For a method that needs the modes of a twin.
    """
    focusing = focus_measured(measured, method, report, workers())
    return FocusedPanel(measured.panel, focusing, compare_measured(measured), measured=True)


def save(run: Path, found: FocusedPanel, inputs: Mapping[str, str], extent: CampaignExtent | None = None) -> Path:
    """Write filters.h5.

    Parameters
    ----------
    run : Path
        Run folder.
    inputs : mapping
        SHA-256 of every input file of the filters, by its name.
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
    focusing, target = found.focusing, run / FILTERS
    settings: dict[str, Any] = {
        "method": focusing.method,
        "temperatures": focusing.temperature.tolist(),
        "panel": found.panel.model_dump(mode="json"),
        "measured": found.measured,
        **extent_settings(extent),
    }
    made_from = provenance(inputs, settings)
    save_focusing(target, found.panel, focusing, found.comparison, made_from, found.uncorrected, found.pareto)
    return target
