"""Filters at any temperature as a mean plus a few principal filters with temperature-dependent coefficients."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.focusing.fir import FirBank

LEFT_OVER = 1e-6
"""Largest share of the training filters' energy outside the principal filters: 0.1 % of amplitude."""


@dataclass(frozen=True)
class LowRankBank:
    """taps(T) = mean + Σ_k coefficient_k(T) · filters_k.

    Attributes
    ----------
    temperature : (n,) ndarray
        Training temperatures, ascending, degrees Celsius.
    coefficient : (n, K) ndarray
        Coefficients of the principal filters there; a cubic not-a-knot spline in between.
    filters : (K, N, M) ndarray
        Orthonormal over actuators and taps, the one of most energy first.
    mean : (N, M) ndarray
        V per unit of audio signal.
    """

    temperature: Real
    coefficient: Real
    filters: Real
    mean: Real

    def __post_init__(self) -> None:
        check_shapes(self, temperature="n", coefficient="n K", filters="K N M", mean="N M")
        check_finite(self, "coefficient", "filters", "mean")
        check_ascending(self, "temperature")

    @classmethod
    def of(cls, bank: FirBank, left_over: float = LEFT_OVER) -> Self:
        """Take as many principal filters as leave at most `left_over` of the training filters' energy."""
        count, actuators, taps = bank.taps.shape
        mean = bank.taps.mean(axis=0)
        left, values, right = np.linalg.svd((bank.taps - mean).reshape(count, -1), full_matrices=False)
        missed = np.append(np.cumsum((values**2)[::-1])[::-1], 0.0)
        rank = max(1, int(np.argmax(missed <= left_over * float((bank.taps**2).sum()))))
        filters = right[:rank].reshape(rank, actuators, taps)
        return cls(bank.temperature, left[:, :rank] * values[:rank], filters, mean)

    def taps(self, temperature: ArrayLike) -> Real:
        """Return filters (T, N, M) at `temperature` (T,), °C; outside the range, those of its end."""
        from scipy.interpolate import CubicSpline

        at = np.clip(
            np.atleast_1d(np.asarray(temperature, dtype=float)), self.temperature[0], self.temperature[-1]
        )
        share = CubicSpline(self.temperature, self.coefficient, axis=0)(at)
        found: Real = self.mean + np.tensordot(share, self.filters, axes=1)
        return found
