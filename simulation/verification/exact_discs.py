"""Exact natural frequencies of circular and annular Mindlin plates, by number of nodal diameters.

With n nodal diameters, w and phi vary as cos(n t), H as sin(n t) (see `waves`); in r the potentials are Bessel
functions of order n. Three conditions on every edge give 3 (disc) or 6 (annulus) homogeneous equations; the
frequencies are the roots of their determinant. T. Irie, G. Yamada, S. Aomura, J. Appl. Mech. 47 (1980) 652-655;
T. Irie, G. Yamada, K. Takagi, J. Appl. Mech. 49 (1982) 633-638.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ive, jv, kve, yv

from analysis.arrays import Real
from simulation.verification.case import CONDITIONS, RIGID_FREQUENCY, Support
from simulation.verification.root_search import roots
from simulation.verification.waves import PlateWaves


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
