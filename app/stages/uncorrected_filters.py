"""Performance of filters designed with the laws of a twin that lacks an effect."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.focusing.aim import Aim, aim, joined
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Panel
from analysis.focusing.responses import constants_at, design_forms, responses
from analysis.focusing.sound_aim import SoundAim
from analysis.focusing.tap_delay import tap_design
from analysis.material import MaterialLaws
from app.twins.panel_twin import PanelTwin


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
