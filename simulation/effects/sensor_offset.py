"""Sensor offset: the first sensor patch was glued beside its mark."""

from collections.abc import Mapping
from typing import Any

from analysis.experiment import Experiment
from analysis.gap.effect_card import EffectCard, Parameter
from simulation.effects.effect import Effect
from simulation.plate_state import Circumstances, PlateState

FARTHEST = 0.0025  # m, a patch of some 20 mm that lies farther off is seen by eye


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; hands place a patch within a millimetre, and never beyond the plate's edge."""
    plate = experiment.plate
    return EffectCard(
        name="sensor_offset",
        summary="the first sensor patch sits beside its declared place",
        parameters=(
            Parameter("dx", "m", *_range(experiment, 0, plate.length_x), 0.001),
            Parameter("dy", "m", *_range(experiment, 1, plate.length_y), 0.001),
        ),
        needs="the first sensor, over many modes; better beside other sensors, which it leaves alone",
        separated_by="measure the patch's edges from the plate's with a calliper",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Put the first sensor patch at its declared centre + (dx, dy)."""
    return state.with_(offset_x=state.offset_x + values["dx"], offset_y=state.offset_y + values["dy"])


def available(experiment: Experiment) -> bool:
    """Whether there is a sensor patch and room to move it both ways."""
    plate = experiment.plate
    if not experiment.sensors:
        return False
    ranges = (_range(experiment, 0, plate.length_x), _range(experiment, 1, plate.length_y))
    return all(low < high for low, high in ranges)


def _range(experiment: Experiment, axis: int, length: float) -> tuple[float, float]:
    low, high = experiment.sensors[0].span(axis)
    return max(-FARTHEST, -low), min(FARTHEST, length - high)


EFFECT = Effect(card, apply, available)
