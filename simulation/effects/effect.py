"""A physical effect: its card, and the change that it makes to the state of a plate.

Any place on a plate, as shapes of an effect: where it may be, and from where a search for it starts.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment, Plate
from analysis.geometry.relations import TOUCH
from simulation.state.plate_state import Circumstances, PlateState

Apply = Callable[[PlateState, Circumstances, Mapping[str, Any]], PlateState]


def always(experiment: Experiment) -> bool:
    """Return True: the effect is possible in any campaign."""
    return True


def isotropic(experiment: Experiment) -> bool:
    """Whether the sheet is not declared by direction: then its moduli and losses are fitted in any case."""
    material = experiment.plate.material
    return material is None or material.departure is None


@dataclass(frozen=True)
class Effect:
    """One entry of the library.

    Attributes
    ----------
    card : callable
        Experiment -> EffectCard: ranges and sites may depend on the plate.
    apply : callable
        (state, circumstances, values by parameter) -> state. Values may be complex, see
        `simulation.state.plate_state`.
    available : callable
        Experiment -> bool: whether the declaration is sufficient (a point mass needs its point).
    wants : str
        Object of "declare": what the declaration lacks where the effect is not possible, for messages.
    nothing_missing : bool
        Whether nothing is missing where it is not possible: it is about instruments that a rig lacks, or about
        what is fitted in any case.
    needs_strain_energy : bool
        Whether `apply` looks at `Circumstances.strain_energy`: it is found so that the plate that `apply` makes of
        it has it. Each line of a spectrum may follow the energy of that line; nothing else may follow any.
    """

    card: Callable[[Experiment], EffectCard]
    apply: Apply
    available: Callable[[Experiment], bool] = always
    wants: str = ""
    nothing_missing: bool = False
    needs_strain_energy: bool = False


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
