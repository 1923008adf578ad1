"""The modelling delay of a method's FIR taps."""

import numpy as np

from analysis.focusing.design import TapDesign
from analysis.focusing.fir import suited_delay
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import PanelModel
from analysis.focusing.responses import constants_at
from analysis.focusing.temperatures import reference_temperature
from analysis.material import MaterialLaws


def tap_design(method: Method, model: PanelModel, panel: Panel, laws: MaterialLaws) -> TapDesign:
    """Prepare the tap design of a method, with the declared delay or a suitable one.

    A suitable delay is half the taps for STIF; for the others it is the one with most energy within the taps at
    the reference temperature.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    """
    settings = panel.filters
    if method == "stif" or settings.delay is not None:
        return TapDesign.of(panel, settings.middle)
    (constants,) = constants_at(laws, np.array([reference_temperature(panel, laws)]))
    amplitude = model.amplitudes(*constants, settings.frequency)
    forms = model.space.forms([amplitude], panel.target.displacement)
    wanted = designer(method, model, panel, settings.frequency)(constants, lambda: amplitude, forms)
    return TapDesign.of(panel, suited_delay(wanted[None], settings))
