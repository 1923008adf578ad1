"""Exact natural frequencies of Mindlin plates: rectangles on hard simple supports, discs and annuli.

Rectangles, two opposite edges or all of which are supported. A wave that varies as sin(m pi x / a) meets the hard
support on x = 0 and x = a (w = theta_y = M_xx = 0). Where all edges are so, sines along y as well leave a 3 x 3
eigenvalue problem per pair (m, n): bending, and two branches of thickness shear (Navier). Other edges y = 0, b
give 6 homogeneous equations per m (Levy). R. D. Mindlin, A. Schacknow, H. Deresiewicz, J. Appl. Mech. 23 (1956)
430-436; Sh. Hosseini-Hashemi, M. Arsanjani, Int. J. Solids Struct. 42 (2005) 819-853.

Discs and annuli. With n nodal diameters, w and phi vary as cos(n t), H as sin(n t) (below); in r the
potentials are Bessel functions of order n. Three conditions on every edge give 3 (disc) or 6 (annulus) homogeneous
equations; the frequencies are the roots of their determinant. T. Irie, G. Yamada, S. Aomura, J. Appl. Mech. 47
(1980) 652-655; T. Irie, G. Yamada, K. Takagi, J. Appl. Mech. 49 (1982) 633-638.

All quantities are dimensionless: lengths over a, time over a**2 sqrt(rho h / D), so that D = rho h = a = 1 and the
frequency is Omega = w a**2 sqrt(rho h / D). Free waves then obey, with grad w + theta the transverse shear strain,

    s div(grad w + theta) + Omega**2 w = 0
    div M - s (grad w + theta) + r Omega**2 theta = 0

with the shear stiffness s and the rotary inertia r of `PlateWaves`. Setting theta = grad phi + rot H splits them
into two potentials of w (phi proportional to w) and one of H. R. D. Mindlin, J. Appl. Mech. 18 (1951) 31-38.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq, minimize_scalar
from scipy.special import ive, jv, kve, yv

from analysis.arrays import Real
from simulation.shell.rigidity import SHEAR_FACTOR
from tests.simulation.verification.case import CONDITIONS, RIGID_FREQUENCY, Support

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


@dataclass(frozen=True)
class HardRectangle:
    """A rectangle on hard simple supports all round, in units of its side a along x.

    Attributes
    ----------
    thickness, width : float
        h / a and b / a.
    poisson_ratio : float
    """

    thickness: float
    poisson_ratio: float
    width: float

    def __post_init__(self) -> None:
        if not self.width > 0.0:
            raise ValueError(f"width is {self.width:g} of the length; must be above 0")
        PlateWaves(self.thickness, self.poisson_ratio)  # refuses what is no plate

    def frequencies(self, half_waves: tuple[int, int]) -> Real:
        """Bending and two thickness-shear frequencies w a**2 sqrt(rho h / D) of one pair (m, n), ascending, (3,).

        With w = W sin sin, theta_x = X cos sin, theta_y = Y sin cos; m and n from 1.
        """
        if min(half_waves) < 1:
            raise ValueError(f"half waves are {half_waves}; allowed from 1 along both sides")
        waves, nu = PlateWaves(self.thickness, self.poisson_ratio), self.poisson_ratio
        s, r = waves.shear, waves.rotary
        p, q = np.pi * half_waves[0], np.pi * half_waves[1] / self.width
        stiffness = np.array(
            [
                [s * (p**2 + q**2), s * p, s * q],
                [s * p, p**2 + (1 - nu) / 2 * q**2 + s, (1 + nu) / 2 * p * q],
                [s * q, (1 + nu) / 2 * p * q, q**2 + (1 - nu) / 2 * p**2 + s],
            ]
        )
        scale = 1.0 / np.sqrt(np.array([1.0, r, r]))
        return np.asarray(np.sqrt(np.linalg.eigvalsh(scale[:, None] * stiffness * scale)))

    def lowest(self, count: int) -> Real:
        """Lowest `count` bending frequencies w a**2 sqrt(rho h / D), ascending, (count,)."""
        numbers = range(1, count + 1)
        return np.sort([self.frequencies((m, n))[0] for m, n in product(numbers, numbers)])[:count]


@dataclass(frozen=True)
class LevyPlate:
    """A rectangle of length a on hard simple supports at x = 0 and x = a, in units of a.

    Attributes
    ----------
    thickness : float
        h / a.
    poisson_ratio : float
    width : float
        b / a.
    lower, upper : Support
        Of the edges y = 0 and y = b.
    """

    thickness: float
    poisson_ratio: float
    width: float
    lower: Support
    upper: Support

    def __post_init__(self) -> None:
        if not self.width > 0.0:
            raise ValueError(f"width is {self.width:g} of the length; must be above 0")
        for edge in (self.lower, self.upper):
            if edge not in CONDITIONS:
                raise ValueError(f"support is {edge!r}; allowed: {', '.join(CONDITIONS)}")
        PlateWaves(self.thickness, self.poisson_ratio)  # refuses what is no plate

    def frequencies(self, half_waves: int, highest: float) -> Real:
        """Natural frequencies w a**2 sqrt(rho h / D) with `half_waves` along x, up to `highest`, ascending."""
        if half_waves < 1:
            raise ValueError(f"number of half waves is {half_waves}; allowed from 1")
        cut_off = PlateWaves(self.thickness, self.poisson_ratio).cut_off
        return roots(
            lambda frequency: self.determinant(half_waves, frequency), RIGID_FREQUENCY, highest, breaks=[cut_off]
        )

    def all_frequencies(self, highest: float) -> Real:
        """Every bending frequency up to `highest`, ascending; they grow with the number of half waves."""
        found, m = [], 1
        while (values := self.frequencies(m, highest)).size:
            found.append(values)
            m += 1
        return np.sort(np.concatenate(found)) if found else np.array([])

    def lowest(self, count: int) -> Real:
        """Lowest `count` frequencies w a**2 sqrt(rho h / D), ascending, (count,)."""
        highest = 40.0
        while (found := self.all_frequencies(highest)).size < count:
            highest *= 2.0
        return found[:count]

    def determinant(self, half_waves: int, frequency: ArrayLike) -> Real:
        """Characteristic determinant at frequencies (F,), every wave scaled to length one, (F,)."""
        at = np.atleast_1d(np.asarray(frequency, float))
        rows = [
            quantity
            for y, edge in ((-0.5 * self.width, self.lower), (0.5 * self.width, self.upper))
            for quantity in self._rows(half_waves, at, y, edge)
        ]
        matrix = np.moveaxis(np.array(rows), 2, 0)  # (F, conditions, waves)
        return np.asarray(np.linalg.det(matrix / np.linalg.norm(matrix, axis=1, keepdims=True)))

    def _rows(self, half_waves: int, frequency: Real, y: float, edge: Support) -> list[Real]:
        """Quantities of every wave at a height over the plate's middle, each (waves, F)."""
        waves, nu, p = PlateWaves(self.thickness, self.poisson_ratio), self.poisson_ratio, np.pi * half_waves
        bending, twist = waves.bending(frequency)
        potential = waves.potential(frequency, bending)
        columns = []
        for odd in (False, True):
            for m, c in zip(bending, potential, strict=True):
                f, df, ddf = self._across(p**2 - m, y, odd=odd)
                columns.append((m * f, frequency**2 * df, c * p * f, c * df, -c * p**2 * f, c * ddf, c * p * df))
            g, dg, ddg = self._across(p**2 - twist, y, odd=odd)
            columns.append((np.zeros_like(g), waves.shear * p * g, dg, p * g, -p * dg, p * dg, ddg))
        w, q, along, across, d_along_x, d_across, d_along = (
            np.array(values) for values in zip(*columns, strict=True)
        )
        quantity = {
            "deflection": w,
            "shear force": q,
            "rotation across": across,
            "rotation along": along,
            "bending moment": d_across + nu * d_along_x,
            "twisting moment": 0.5 * (1.0 - nu) * (d_along + p * across),
        }
        return [quantity[name] for name in CONDITIONS[edge]]

    def _across(self, square: Real, y: float, *, odd: bool) -> tuple[Real, Real, Real]:
        """Even or odd f of f'' = square f, with f' and f'', (F,) each; hyperbolic ones scaled by exp(-k b / 2)."""
        k = np.maximum(np.sqrt(np.abs(square)), 1e-12)
        half = 0.5 * self.width
        up, down = np.exp(k * (y - half)), np.exp(-k * (y + half))
        even_layer, odd_layer = 0.5 * (up + down), 0.5 * (up - down) / k
        even_wave, odd_wave = np.cos(k * y), np.sin(k * y) / k
        grows = square > 0.0
        even, uneven = np.where(grows, even_layer, even_wave), np.where(grows, odd_layer, odd_wave)
        if odd:
            return uneven, even, square * uneven
        return even, square * uneven, square * even


@dataclass(frozen=True)
class ExactDisc:
    """A disc, or an annulus, in units of its outer radius a.

    Attributes
    ----------
    thickness : float
        h / a.
    poisson_ratio : float
    outer : Support
    hole : float
        Inner radius b / a; 0 for a disc.
    inner : Support
        Of the hole's edge.
    """

    thickness: float
    poisson_ratio: float
    outer: Support
    hole: float = 0.0
    inner: Support = "free"

    def __post_init__(self) -> None:
        if not 0.0 <= self.hole < 1.0:
            raise ValueError(f"hole is {self.hole:g} of the outer radius; allowed from 0 to below 1")
        for edge in (self.outer, self.inner):
            if edge not in CONDITIONS:
                raise ValueError(f"support is {edge!r}; allowed: {', '.join(CONDITIONS)}")
        PlateWaves(self.thickness, self.poisson_ratio)  # refuses what is no plate

    @property
    def waves(self) -> PlateWaves:
        """Waves of the unbounded plate."""
        return PlateWaves(self.thickness, self.poisson_ratio)

    def frequencies(self, diameters: int, highest: float) -> Real:
        """Natural frequencies w a**2 sqrt(rho h / D) with `diameters` nodal diameters, up to `highest`, ascending.

        Rigid motions and roots at the cut-off itself are left out; with n = 0 thickness twist (the rotation
        along the circle alone) is among them.
        """
        if diameters < 0:
            raise ValueError(f"number of nodal diameters is {diameters}; allowed from 0")
        return roots(
            lambda frequency: self.determinant(diameters, frequency),
            RIGID_FREQUENCY,
            highest,
            breaks=[self.waves.cut_off],
        )

    def all_frequencies(self, highest: float) -> tuple[Real, NDArray[np.int_]]:
        """Every frequency up to `highest`, ascending, and its number of nodal diameters; twice where above 0."""
        values: list[float] = []
        diameters: list[int] = []
        empty = n = 0
        while empty < 2 or n < 5:  # the lowest frequency grows with n, but not among the first few
            found = self.frequencies(n, highest)
            empty = 0 if found.size else empty + 1
            for value in found:
                copies = 1 if n == 0 else 2
                values += [float(value)] * copies
                diameters += [n] * copies
            n += 1
        order = np.argsort(values, kind="stable")
        return np.array(values)[order], np.array(diameters, int)[order]

    def lowest(self, count: int) -> Real:
        """Lowest `count` frequencies w a**2 sqrt(rho h / D), ascending, those with n > 0 twice each, (count,)."""
        highest = 15.0
        while (found := self.all_frequencies(highest)[0]).size < count:
            highest *= 2.0
        return found[:count]

    def determinant(self, diameters: int, frequency: ArrayLike) -> Real:
        """Characteristic determinant at frequencies (F,), every wave scaled to length one, (F,)."""
        at = np.atleast_1d(np.asarray(frequency, float))
        edges: list[tuple[float, Support]] = [(1.0, self.outer)]
        if self.hole:
            edges.append((self.hole, self.inner))
        rows = [row for radius, edge in edges for row in self._rows(diameters, at, radius, CONDITIONS[edge])]
        matrix = np.moveaxis(np.array(rows), 2, 0)  # (F, conditions, waves)
        matrix = matrix / np.linalg.norm(matrix, axis=1, keepdims=True)
        return np.asarray(np.linalg.det(matrix))

    def _rows(self, n: int, frequency: Real, radius: float, wanted: Sequence[str]) -> list[Real]:
        """Quantities of every wave at a radius, each (waves, F)."""
        waves, nu = self.waves, self.poisson_ratio
        bending, twist = waves.bending(frequency)
        potential = waves.potential(frequency, bending)
        kinds = (False, True) if self.hole else (False,)
        columns = []
        for singular in kinds:
            for m, c in zip(bending, potential, strict=True):
                f, df, ddf = self._radial(n, m, radius, singular=singular)
                slope, along = c * df, -n * c * f / radius
                d_slope, d_along = c * ddf, -n * c * (df / radius - f / radius**2)
                columns.append((m * f, frequency**2 * df, slope, along, d_slope, d_along))
            g, dg, ddg = self._radial(n, twist, radius, singular=singular)
            slope, d_slope = n * g / radius, n * (dg / radius - g / radius**2)
            columns.append((np.zeros_like(g), waves.shear * slope, slope, -dg, d_slope, -ddg))
        w, q, across, along, d_across, d_along = (np.array(values) for values in zip(*columns, strict=True))
        quantity = {
            "deflection": w,
            "shear force": q,
            "rotation across": across,
            "rotation along": along,
            "bending moment": d_across + nu * (across + n * along) / radius,
            "twisting moment": 0.5 * (1.0 - nu) * (d_along - (n * across + along) / radius),
        }
        return [quantity[name] for name in wanted]

    def _radial(self, n: int, m: Real, radius: float, *, singular: bool) -> tuple[Real, Real, Real]:
        """f, f' and f'' of f'' + f'/r - n**2 f/r**2 = -m f, (F,) each.

        Modified functions are scaled to their size at the edge from which they fall off.
        """
        k = np.sqrt(np.abs(m))
        x = np.maximum(k * radius, 1e-300)
        if singular:
            fall = np.exp(-k * (radius - self.hole))
            wave, d_wave = yv(n, x), 0.5 * (yv(n - 1, x) - yv(n + 1, x))
            layer, d_layer = fall * kve(n, x), -0.5 * fall * (kve(n - 1, x) + kve(n + 1, x))
        else:
            fall = np.exp(-k * (1.0 - radius))
            wave, d_wave = jv(n, x), 0.5 * (jv(n - 1, x) - jv(n + 1, x))
            layer, d_layer = fall * ive(n, x), 0.5 * fall * (ive(n - 1, x) + ive(n + 1, x))
        f = np.where(m > 0.0, wave, layer)
        df = k * np.where(m > 0.0, d_wave, d_layer)
        return f, df, -df / radius + (n**2 / radius**2 - m) * f


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
