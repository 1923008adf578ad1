"""Sweeps whose stiffness does not fit their temperature: the plate itself is a thermometer.

The modulus of a plate is a smooth function of temperature. A sweep with a wrong temperature has the modulus of its
true one, and its neighbours tell which that is: T as a function of ln E, interpolated between them.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real

NEIGHBOURS = 4
"""Sweeps from which the temperature of one is interpolated, by a parabola."""
LEAST = 5
"""Sweeps of one leg that are needed: one to be judged, and its neighbours."""
WRONG, WRONG_AT_END = 1.0, 2.5
"""K that a temperature may be off its neighbours' before it is told, between them and at the ends of a leg."""
OF_SPACING = 0.35
"""Or this share of the distance of sweeps: by as much a glass transition bends a parabola through four points."""
OF_SCATTER = 6.0
"""Or so many times the median of all of the leg: estimates that scatter do not tell one from the others."""
REST_FITS = 0.5
"""Share of all deviations that may remain without the wrong sweep: of many that scatter none is wrong."""
HYSTERESIS = 1.0
"""Difference of up and down at equal modulus from which on it is told, K: half of it is in each label."""


def misplaced(temperature: Real, log_modulus: Real) -> dict[int, float]:
    """Return the temperature that the modulus of some sweeps of one leg stands for, by their place.

    Parameters
    ----------
    temperature : (T,) ndarray
        Labels, degrees Celsius.
    log_modulus : (T,) ndarray
        ln E.

    Returns
    -------
    dict of int to float
        Degrees Celsius; empty where all fit, or fewer than `LEAST` are given.
    """
    left, found = list(range(len(temperature))), dict[int, float]()
    while len(left) >= LEAST:
        before = np.abs(_interpolated(temperature[left], log_modulus[left]) - temperature[left])
        if before.max() <= WRONG:
            break
        # One wrong sweep spoils what is interpolated for its neighbours: without it the rest fits best.
        rest = [np.delete(left, one) for one in range(len(left))]
        off = [np.abs(_interpolated(temperature[of], log_modulus[of]) - temperature[of]) for of in rest]
        worst = int(np.argmin([one.sum() for one in off]))
        likely = _at_neighbours(temperature, log_modulus, rest[worst], left[worst])
        allowed = _allowed(temperature[left], worst, float(np.median(off[worst])))
        if abs(likely - temperature[left[worst]]) <= allowed or off[worst].sum() > REST_FITS * before.sum():
            break
        found[left[worst]] = likely
        del left[worst]
    return found


def hysteresis(up: tuple[Real, Real], down: tuple[Real, Real]) -> float | None:
    """Return by how much labels on the way up exceed those on the way down at equal modulus, K.

    Parameters
    ----------
    up, down : ((T,) ndarray, (T,) ndarray)
        Labels, degrees Celsius, and ln E.

    Returns
    -------
    float or None
        Median over the moduli of both legs; None where they share fewer than three, or it is small.
    """
    order = np.argsort(down[1])
    modulus, label = down[1][order], down[0][order]
    if modulus.size < LEAST:
        return None
    inside = (up[1] >= modulus[0]) & (up[1] <= modulus[-1])
    if inside.sum() < 3:
        return None
    found = float(np.median(up[0][inside] - np.interp(up[1][inside], modulus, label)))
    return found if abs(found) > HYSTERESIS else None


def _interpolated(temperature: Real, log_modulus: Real) -> Real:
    """Temperature of each sweep by the moduli of its neighbours."""
    every = range(len(temperature))
    return np.array([_at_neighbours(temperature, log_modulus, np.delete(every, one), one) for one in every])


def _at_neighbours(temperature: Real, log_modulus: Real, others: NDArray[np.int_], one: int) -> float:
    near = others[np.argsort(np.abs(temperature[others] - temperature[one]), kind="stable")[:NEIGHBOURS]]
    return _parabola(log_modulus[near], temperature[near], float(log_modulus[one]))


def _parabola(x: Real, y: Real, at: float) -> float:
    """Value at a point of the parabola through points, by least squares."""
    middle, width = float(x.mean()), float(np.ptp(x)) or 1.0
    return float(np.polyval(np.polyfit((x - middle) / width, y, 2), (at - middle) / width))


def _allowed(temperature: Real, one: int, scatter: float) -> float:
    spacing = float(np.median(np.diff(np.sort(temperature))))
    allowed = max(WRONG, OF_SPACING * spacing, OF_SCATTER * scatter)
    at_end = temperature[one] in (temperature.min(), temperature.max())
    return max(allowed, WRONG_AT_END, spacing) if at_end else allowed
