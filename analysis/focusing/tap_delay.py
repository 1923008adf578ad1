"""The modelling delay with which a method's filters become taps."""

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
    """How a method's filters become taps, with the delay declared or else the one that suits the method.

    That is half the taps for STIF, and for the others where the taps hold most of their energy, judged at the
    reference temperature.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    model : PanelModel
    panel : Panel
    laws : MaterialLaws

    Returns
    -------
    TapDesign
    """
    settings = panel.filters
    if method == "stif" or settings.delay is not None:
        return TapDesign.of(panel, settings.middle)
    (constants,) = constants_at(laws, np.array([reference_temperature(panel, laws)]))
    amplitude = model.amplitudes(*constants, settings.frequency)
    forms = model.space.forms([amplitude], panel.target.displacement)
    wanted = designer(method, model, panel, settings.frequency)(constants, lambda: amplitude, forms)
    return TapDesign.of(panel, suited_delay(wanted[None], settings))
