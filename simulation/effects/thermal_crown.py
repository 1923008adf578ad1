"""Thermal crown: the middle of the plate is warmer than its edges, in proportion to the heating."""

from collections.abc import Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

REFERENCE_TEMPERATURE = 60.0  # degrees Celsius, where gx and gy are the full differences


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; edges that see cooler walls differ by a kelvin from the middle."""
    return EffectCard(
        name="thermal_crown",
        summary="the middle of the plate is hotter than its edges, in proportion to the heating",
        parameters=(
            Parameter("gx", "K", -4.0, 4.0, 1.0, shown="K"),
            Parameter("gy", "K", -4.0, 4.0, 1.0, shown="K"),
        ),
        needs=("temperatures near the room's and far from it, modes of several half-waves along both axes"),
        separated_by=(
            "thermocouples in the middle and at the edges; a thickness_crown is there at room temperature, too"
        ),
        title="middle hotter than the edges",
        phrase="a middle that is hotter than the edges by {gx} along x and {gy} along y",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Add s (gx (1/3 - xi**2) + gy (1/3 - zeta**2)) to the local temperature, s = (T - room)/(60 - room).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``gx`` and ``gy``, K from the edges to the middle in an oven at 60 °C.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    room = circumstances.room_temperature
    heating = (state.mean_temperature - room) / (REFERENCE_TEMPERATURE - room)
    crown = values["gx"] * (1.0 / 3.0 - state.xi**2) + values["gy"] * (1.0 / 3.0 - state.zeta**2)
    return state.with_(temperature=state.temperature + heating * crown)


def available(experiment: Experiment) -> bool:
    """Whether the room is cooler than the temperature at which the differences are stated."""
    return experiment.oven.room_temperature < REFERENCE_TEMPERATURE


EFFECT = Effect(card, apply, available, f"an oven.room_temperature below {REFERENCE_TEMPERATURE:g} °C")
