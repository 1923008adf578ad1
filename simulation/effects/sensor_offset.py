"""Sensor offset: the first sensor patch is not at its declared place."""

from collections.abc import Callable, Mapping
from typing import Any

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from analysis.geometry.relations import TOUCH, leaves, overlap
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

LARGEST_OFFSET = 0.0025  # m; for a patch of some 20 mm a larger offset would be visible
BRACES = str.maketrans({"{": "{{", "}": "}}"})
"""A name may hold braces, which a phrase takes for a parameter."""
OFFSET_ACCURACY = 1e-7  # m, accuracy of the largest offset that fits


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; hands place a patch within a millimetre, and never beyond the plate's edge."""
    return EffectCard(
        name="sensor_offset",
        summary="the first sensor patch sits beside its declared place",
        parameters=(
            Parameter("dx", "m", *_range(experiment, 0), 0.001, shown="mm"),
            Parameter("dy", "m", *_range(experiment, 1), 0.001, shown="mm"),
        ),
        needs="the first sensor, over many modes; better beside other sensors, which it leaves alone",
        separated_by="measure the patch's edges from the plate's with a calliper",
        replaces=f"patch_place {experiment.sensors[0].id}" if experiment.sensors else "",
        title="misplaced sensor",
        phrase=f"{_first(experiment)} is off its declared place: {{dx}} along x, {{dy}} along y",
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Move the first sensor patch to its declared centre + (dx, dy).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``dx`` and ``dy``, m.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    return state.with_(offset_x=state.offset_x + values["dx"], offset_y=state.offset_y + values["dy"])


def available(experiment: Experiment) -> bool:
    """Whether there is a sensor patch with space to move it in both directions."""
    return bool(experiment.sensors) and all(low < high for low, high in (_range(experiment, k) for k in (0, 1)))


def _first(experiment: Experiment) -> str:
    return f"sensor {experiment.sensors[0].id}".translate(BRACES) if experiment.sensors else "the first sensor"


def _range(experiment: Experiment, axis: int) -> tuple[float, float]:
    """Range of the offset along an axis that leaves the patch on the plate, m; the widest without a patch."""
    if not experiment.sensors:
        return -LARGEST_OFFSET, LARGEST_OFFSET
    plate, border = experiment.plate, experiment.sensors[0].loop

    def fits(distance: float) -> bool:
        there = border.moved(0.0, (distance, 0.0) if axis == 0 else (0.0, distance))
        return leaves(there, plate.loop) is None and all(overlap(there, hole) is None for hole in plate.hole_loops)

    return -_farthest(lambda distance: fits(-distance)), _farthest(fits)


def _farthest(fits: Callable[[float], bool]) -> float:
    """Return the largest distance that fits, up to `LARGEST_OFFSET`, m."""
    if fits(LARGEST_OFFSET):
        return LARGEST_OFFSET
    low, high = 0.0, LARGEST_OFFSET
    while high - low > OFFSET_ACCURACY:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return max(low - TOUCH, 0.0)


EFFECT = Effect(card, apply, available, "a sensor patch with space around it")
