"""All roots of a characteristic determinant over a range of frequencies."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from analysis.arrays import Real

Determinant = Callable[[Real], Real]
"""Signed values at frequencies (F,), continuous except at the `breaks` of the search."""

BESIDE_A_BREAK = 1e-7
"""Relative distance from a break without search: there waves coincide and every determinant vanishes."""


def roots(
    determinant: Determinant, lowest: float, highest: float, *, breaks: Sequence[float] = (), step: float = 0.02
) -> Real:
    """Find every simple root between two frequencies.

    The range is sampled evenly in the square root of frequency, in which the roots of a plate are about evenly
    spaced. A change of sign is a root. Where the magnitude has a minimum without a change of sign, the minimum is
    refined, to find two roots between neighbouring samples.

    Parameters
    ----------
    determinant : callable
        From frequencies (n,) to values (n,).
    lowest, highest : float
        Above zero, so that rigid motions are left out.
    breaks : sequence of float
        Frequencies at which the determinant vanishes or changes sign without being a root.
    step : float
        Between samples, in the square root of frequency.

    Returns
    -------
    (n,) ndarray
        Ascending, in the unit of `lowest`.

    Raises
    ------
    ValueError
        Unless 0 < `lowest` < `highest`.
    """
    if not 0.0 < lowest < highest:
        raise ValueError(f"roots are looked for from {lowest:g} to {highest:g}; allowed 0 < lowest < highest")
    ends = [lowest, *(b for b in sorted(breaks) if lowest < b < highest), highest]
    found: list[float] = []
    for start, stop in pairwise(ends):
        first = start * (1.0 + BESIDE_A_BREAK) if start != lowest else start
        last = stop * (1.0 - BESIDE_A_BREAK) if stop != highest else stop
        count = max(16, int(np.ceil((np.sqrt(last) - np.sqrt(first)) / step)))
        found += _between(determinant, np.linspace(np.sqrt(first), np.sqrt(last), count) ** 2)
    return np.array(sorted(found))


def _between(determinant: Determinant, grid: Real) -> list[float]:
    def one(frequency: float) -> float:
        return float(determinant(np.array([frequency]))[0])

    def refined(low: float, high: float) -> float:
        return float(brentq(one, low, high, xtol=1e-13 * high, rtol=1e-14))

    value = determinant(grid)
    size = np.abs(value)
    found = [float(at) for at in grid[value == 0.0]]
    found += [refined(grid[k], grid[k + 1]) for k in np.flatnonzero(value[:-1] * value[1:] < 0.0)]
    same = (value[:-2] * value[1:-1] > 0.0) & (value[1:-1] * value[2:] > 0.0)
    for k in np.flatnonzero(same & (size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])):
        sign = float(np.sign(value[k]))
        bounds = (float(grid[k]), float(grid[k + 2]))
        low = minimize_scalar(
            lambda f, sign=sign: sign * one(f),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-12 * bounds[1]},
        )
        if low.fun < 0.0:
            found += [refined(bounds[0], low.x), refined(low.x, bounds[1])]
    return found
