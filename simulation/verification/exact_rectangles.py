"""Exact natural frequencies of rectangular Mindlin plates on hard simple supports, at two opposite edges or all.

A wave that varies as sin(m pi x / a) meets the hard support on x = 0 and x = a (w = theta_y = M_xx = 0). Where all
edges are so, sines along y as well leave a 3 x 3 eigenvalue problem per pair (m, n): bending, and two branches of
thickness shear (Navier). Other edges y = 0, b give 6 homogeneous equations per m (Levy). R. D. Mindlin,
A. Schacknow, H. Deresiewicz, J. Appl. Mech. 23 (1956) 430-436; Sh. Hosseini-Hashemi, M. Arsanjani, Int. J. Solids
Struct. 42 (2005) 819-853.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Real
from simulation.verification.case import CONDITIONS, RIGID_FREQUENCY, Support
from simulation.verification.root_search import roots
from simulation.verification.waves import PlateWaves


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
