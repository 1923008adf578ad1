"""Thermal lag: the plate's temperature lags behind the oven's."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate.

    Heat capacity over convection on both faces: c h rho/(2 alpha) is 300 s for 3 mm of polymer in moving air
    (alpha = 10 W/m2K), four times that for a thick plate in still air.
    """
    return EffectCard(
        name="thermal_lag",
        summary="the plate is colder than the oven on the way up and warmer on the way down",
        parameters=(Parameter("tau", "s", 0.0, 900.0, 300.0),),
        needs="an up and a down ramp over the same temperatures: on one ramp the material laws absorb a lag",
        separated_by="a thermocouple on the plate, or a hold at constant temperature after each ramp",
        title="plate that lags behind the oven",
        phrase="the plate's temperature follows that of the oven after {tau}",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Plate temperature = oven temperature - tau dT_oven/dt, everywhere.

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``tau``, s.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(temperature=state.temperature - values["tau"] * circumstances.point.rate)


EFFECT = Effect(card, apply)
