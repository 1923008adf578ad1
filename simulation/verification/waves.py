"""Waves of an unbounded Mindlin plate at one frequency, superposed to exact solutions; roots of determinants.

All quantities are dimensionless: lengths over a, time over a**2 sqrt(rho h / D), so that D = rho h = a = 1 and the
frequency is Omega = w a**2 sqrt(rho h / D). Free waves then obey, with grad w + theta the transverse shear strain,

    s div(grad w + theta) + Omega**2 w = 0
    div M - s (grad w + theta) + r Omega**2 theta = 0

with the shear stiffness s and the rotary inertia r of `PlateWaves`. Setting theta = grad phi + rot H splits them
into two potentials of w (phi proportional to w) and one of H. R. D. Mindlin, J. Appl. Mech. 18 (1951) 31-38.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from analysis.arrays import Real
from simulation.shell.rigidity import SHEAR_FACTOR

Determinant = Callable[[Real], Real]
"""Signed values at frequencies (F,), continuous except at the `breaks` of the search."""
BESIDE_A_BREAK = 1e-7
"""Relative distance from a break without search: there waves coincide and every determinant vanishes."""


@dataclass(frozen=True)
class PlateWaves:
    """A Mindlin plate in units of its length a.

    Attributes
    ----------
    thickness : float
        h / a.
    poisson_ratio : float
    """

    thickness: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        if not 0.0 < self.thickness <= 1.0:
            raise ValueError(f"thickness is {self.thickness:g} of the plate's length; allowed above 0, up to 1")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio is {self.poisson_ratio:g}; allowed between -1 and 0.5")

    @property
    def shear(self) -> float:
        """Shear stiffness s = k G h a**2 / D."""
        return 6.0 * SHEAR_FACTOR * (1.0 - self.poisson_ratio) / self.thickness**2

    @property
    def rotary(self) -> float:
        """Rotary inertia r = (h / a)**2 / 12."""
        return self.thickness**2 / 12.0

    @property
    def cut_off(self) -> float:
        """Frequency Omega above which the two evanescent waves propagate too."""
        return float(np.sqrt(self.shear / self.rotary))

    def bending(self, frequency: Real) -> tuple[Real, Real]:
        """Squared wave numbers of the two potentials of w, (2, F), and theirs of H, (F,).

        Each is m in Laplacian(f) = -m f: positive where the wave travels, as the first is at every frequency.
        """
        square = np.asarray(frequency, float) ** 2
        half_sum = 0.5 * square * (1.0 / self.shear + self.rotary)
        product = square * (self.rotary * square / self.shear - 1.0)
        root = np.sqrt(half_sum**2 - product)
        first = half_sum + root
        twist = -2.0 / (1.0 - self.poisson_ratio) * (self.shear - self.rotary * square)
        return np.stack([first, product / first]), twist

    def potential(self, frequency: Real, bending: Real) -> Real:
        """Return phi of a wave whose deflection is m f: (Omega**2 / s - m) f, (2, F)."""
        return np.asarray(np.asarray(frequency, float) ** 2 / self.shear - bending)


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
