"""Thermal gradient: one side of the plate is warmer than the other, in proportion to the heating."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_TEMPERATURE = 60.0  # degrees Celsius, where gx and gy are the full differences


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; laboratory ovens differ by one or two kelvins between two places."""
    return EffectCard(
        name="thermal_gradient",
        summary="one side of the plate is hotter than the other, in proportion to the heating",
        parameters=(Parameter("gx", "K", -7.0, 7.0, 2.0), Parameter("gy", "K", -7.0, 7.0, 2.0)),
        needs="temperatures near the room's and far from it",
        separated_by="thermocouples at the plate's four corners during one ramp",
        title="uneven heating",
        phrase="in an oven at 60 °C the right side is {gx} warmer than the left, the upper {gy} than the lower",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add s (gx xi + gy zeta)/2 to the local temperature, s = (T - room)/(60 - room).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``gx`` and ``gy``, K over the plate's bounding box in an oven at 60 °C.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    room = circumstances.room_temperature
    heating = (state.mean_temperature - room) / (REFERENCE_TEMPERATURE - room)
    tilt = 0.5 * (values["gx"] * state.xi + values["gy"] * state.zeta)
    return state.with_(temperature=state.temperature + heating * tilt)


def available(experiment: Experiment) -> bool:
    """Whether the room is cooler than the temperature at which the gradient is stated."""
    return experiment.oven.room_temperature < REFERENCE_TEMPERATURE


EFFECT = Effect(card, apply, available, f"an oven.room_temperature below {REFERENCE_TEMPERATURE:g} °C")
