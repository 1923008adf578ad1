"""Sums over the poles of a modal form, at all lines of a band."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Complex, Real

FAR_POLES, NODES = 4.0, 16
"""For poles beyond FAR_POLES times the highest squared frequency, the interpolation error is 14**-NODES."""


@dataclass(frozen=True)
class PoleSums:
    """Terms 1/(pole - s) of r poles at s, the F squared angular frequencies.

    The sum over poles far above the lines is so smooth that a polynomial through a few points is exact to
    rounding; most poles of a reduced model are far.

    Attributes
    ----------
    far : (r,) bool ndarray
    near : (r - f, F) complex ndarray
        Terms of the other poles.
    beyond : (f, NODES) complex ndarray
        Terms of the far ones, at Chebyshev points.
    interpolation : (NODES, F) ndarray
        From these points to the lines.
    """

    far: NDArray[np.bool_]
    near: Complex
    beyond: Complex
    interpolation: Real

    @classmethod
    def of(cls, poles: Complex, frequency: ArrayLike) -> Self:
        """Prepare the sums of `poles` (r,), rad2/s2, at frequencies (F,), Hz."""
        s = (2 * np.pi * np.atleast_1d(np.asarray(frequency, float))) ** 2
        far = np.abs(poles) > FAR_POLES * s.max()
        if s.size < 4 * NODES:
            far = np.zeros(len(poles), dtype=bool)
        points, interpolation = _interpolation(s) if far.any() else (np.zeros(0), np.zeros((0, s.size)))
        return cls(far, 1.0 / (poles[~far, None] - s), 1.0 / (poles[far, None] - points), interpolation)

    def simple(self, weights: Complex) -> Complex:
        """Sum weights/(pole - s) over the poles, (..., r) -> (..., F)."""
        return self._summed(weights, self.near, self.beyond)

    def squared(self, weights: Complex) -> Complex:
        """Sum weights/(pole - s)**2 over the poles, (..., r) -> (..., F)."""
        return self._summed(weights, *self._squares)

    @cached_property
    def _squares(self) -> tuple[Complex, Complex]:
        return self.near**2, self.beyond**2

    def _summed(self, weights: Complex, near: Complex, beyond: Complex) -> Complex:
        total = weights[..., ~self.far] @ near
        if len(beyond):
            total += (weights[..., self.far] @ beyond) @ self.interpolation
        return np.asarray(total)


def _interpolation(s: Real) -> tuple[Real, Real]:
    """Chebyshev points (NODES,) between the ends of s (F,), and the matrix (NODES, F) from them to s."""
    low, high = s.min(), s.max()
    points = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    to_coefficients = chebvander(points, NODES - 1).T * (2.0 / NODES)
    to_coefficients[0] *= 0.5
    place = (2.0 * s - low - high) / (high - low)
    return 0.5 * (low + high + (high - low) * points), (chebvander(place, NODES - 1) @ to_coefficients).T
