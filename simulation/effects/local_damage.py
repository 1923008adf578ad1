"""Local damage: a round spot of the plate has lost stiffness."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment, Plate
from analysis.geometry.relations import TOUCH
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, Disc, PlateState

RADIUS = 0.012  # m
FORM = 0.3
"""A square of 30 mm in solid aluminium or plastic leaves 5 % of what the best round spot explains, 22 % of the
signal: two masses of some hundredths of a gram, or a crowned thickness, were named for it."""


def card(experiment: Experiment) -> EffectCard:
    """Describe the candidate; the search starts from discs side by side over the plate."""
    plate = experiment.plate
    sites, (low, high) = _sites(plate), plate.bounds
    middle = 0.5 * np.add(low, high)
    # if there is a hole in the middle, the spot is elsewhere
    centred = _whole(plate, middle[None])[0] or not len(sites)
    x, y = middle if centred else sites[np.hypot(*(sites - middle).T).argmin()]
    return EffectCard(
        name="local_damage",
        summary="a spot of 24 mm across has lost stiffness",
        parameters=(
            Parameter("loss", "1", 0.0, 0.5, 0.2, shown="%"),
            _coordinate("x", low[0], high[0], float(x)),
            _coordinate("y", low[1], high[1], float(y)),
        ),
        needs="modes whose half-waves are not much longer than the spot, better with several sensors",
        separated_by="a tap test or an ultrasonic scan at the place found",
        sites=tuple({"x": float(x), "y": float(y)} for x, y in sites),
        title="spot that has lost stiffness",
        phrase="a spot 24 mm across has lost {loss} of its stiffness, at x {x}, y {y}",
        form=FORM,
    )


def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
    """Plate modulus times 1 - loss within 12 mm of (x, y).

    Parameters
    ----------
    circumstances : Circumstances
        Of the sweep.
    values : mapping
        ``x`` and ``y``, m, and ``loss``, the share of the modulus lost.

    Returns
    -------
    PlateState
        `state` with the effect.
    """
    disc = Disc(x=values["x"], y=values["y"], radius=RADIUS, loss=values["loss"])
    return state.with_(discs=(*state.discs, disc))


def available(experiment: Experiment) -> bool:
    """Whether there is a place for the spot on the plate."""
    plate = experiment.plate
    return min(plate.length_x, plate.length_y) > 2.0 * RADIUS and len(_sites(plate)) > 0


def _coordinate(name: str, low: float, high: float, typical: float) -> Parameter:
    """Return a coordinate of the disc's centre, uniformly likely within the box around the plate."""
    spread = (high - low) / np.sqrt(12.0)
    return Parameter(
        name, "m", low + RADIUS, high - RADIUS, float(spread), shape=True, typical=typical, shown="mm"
    )


def _sites(plate: Plate) -> Real:
    """Centres (K, 2) of discs that lie wholly on the plate, about a diameter apart, row by row, m."""
    x, y = (_places(low, high) for low, high in zip(*plate.bounds, strict=True))
    grid = np.array([(a, b) for b in y for a in x])
    return grid[_whole(plate, grid)]


def _places(low: float, high: float) -> Real:
    count = 1 + round((high - low - 2.0 * RADIUS) / (2.0 * RADIUS))
    if count <= 1:
        return np.array([0.5 * (low + high)])
    return np.linspace(low + RADIUS, high - RADIUS, count)


def _whole(plate: Plate, centres: Real) -> NDArray[np.bool_]:
    """Which discs about the points (K, 2) lie wholly on the plate."""
    away = np.min([loop.distance(centres) for loop in (plate.loop, *plate.hole_loops)], axis=0)
    return np.asarray(plate.contains(centres) & (away > RADIUS - TOUCH))


EFFECT = Effect(card, apply, available, "a plate with space for the spot")
