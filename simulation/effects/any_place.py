"""Any place on a plate, as shapes of an effect: where it may be, and from where a search for it starts."""

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import Parameter
from analysis.experiment import Experiment, Plate
from analysis.geometry.relations import TOUCH

SITES = 48
"""Number of places, about, from which a search starts: 30 mm apart on the plate of the example."""


CLOSER_SITES = 4 * SITES
"""Number of places, about, from which a large change is searched: half as far apart."""


def coordinates(experiment: Experiment) -> tuple[Parameter, Parameter]:
    """Return ``x`` and ``y``, m: uniformly likely within the box around the plate, its edges included.

    A spring at an edge, kept half a thickness inside, left 13 % more than noise on 4 mm of polypropylene.
    """
    plate, starts = experiment.plate, sites(experiment, SITES)
    low, high = plate.bounds
    middle = 0.5 * np.add(low, high)
    x, y = starts[np.hypot(*(starts - middle).T).argmin()]
    return _coordinate("x", low[0], high[0], x), _coordinate("y", low[1], high[1], y)


def sites(experiment: Experiment, count: int) -> Real:
    """Places (K, 2), m, all over the plate, about `count` of them, each in the middle of a square."""
    plate = experiment.plate
    low, high = np.array(plate.bounds)
    apart = float(np.sqrt(plate.area / count))
    counts = np.maximum(np.round((high - low) / apart), 2).astype(int)
    x, y = (low[k] + (np.arange(n) + 0.5) * (high - low)[k] / n for k, n in enumerate(counts))
    grid = np.array([(a, b) for b in y for a in x])
    return grid[_within(plate, grid)]


def _within(plate: Plate, grid: Real) -> NDArray[np.bool_]:
    away = np.min([loop.distance(grid) for loop in (plate.loop, *plate.hole_loops)], axis=0)
    return np.asarray(plate.contains(grid) & (away > 0.5 * plate.thickness + TOUCH))


def _coordinate(name: str, low: float, high: float, typical: float) -> Parameter:
    spread = (high - low) / np.sqrt(12.0)
    return Parameter(name, "m", float(low), float(high), float(spread), shape=True, typical=float(typical))
