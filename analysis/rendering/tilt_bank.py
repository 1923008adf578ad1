"""What a tilt of the panel's temperature adds to its filters, as weighted sums of fixed banks.

With g the tilt along x and y, `analysis.weather.family.TiltFamily` adds

    sum_a g_a s_a(T) + g_a²/2 b_a(T),

s_a and b_a being cubic splines over the temperature. So the taps are sums of the splines' values at the knots, the
banks, by weights c_k(T) that `analysis.rendering.following` has for filters without a tilt, too.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.rendering.following import CubicWeights, cardinal
from analysis.weather.family import Across, TiltFamily

TERMS = 4
"""Of a tilt: along x and y, and half the square of each."""


@dataclass(frozen=True)
class TiltBank:
    """Filters of N actuators and M taps, added where the panel is tilted.

    Attributes
    ----------
    weights : CubicWeights
        K weights of the temperature in the middle, °C.
    banks : (N, 4, K, M) ndarray
        By the tilt along x, V per unit of audio signal and K, along y, and by half the square of each, per K².
    across : float
        Largest tilt, K; beyond, that of the largest holds.
    """

    weights: CubicWeights
    banks: Real
    across: float

    def __post_init__(self) -> None:
        check_shapes(self, banks="N 4 K M")
        check_finite(self, "banks", "across")
        if self.banks.shape[2] != self.weights.count:
            raise ValueError(f"TiltBank.banks has {self.banks.shape[2]} banks for {self.weights.count} weights")

    @classmethod
    def of(cls, family: TiltFamily) -> Self:
        """Take apart the filters of a family."""
        weights = CubicWeights(family.temperature, cardinal(family.temperature, "cubic"))
        terms = np.concatenate([family.slope, family.bend], axis=1)
        return cls(weights, np.ascontiguousarray(terms.transpose(2, 1, 0, 3)), family.across)

    def powers(self, across: Across) -> Real:
        """Factors (4,) of the banks for a tilt along x and y, K."""
        held = np.clip(across, -self.across, self.across)
        return np.concatenate([held, 0.5 * held**2])

    def weighted(self, temperature: float, across: Across) -> Real:
        """Factors (4, K) of the banks at a temperature in the middle, °C, and a tilt, K."""
        found: Real = self.powers(across)[:, None] * self.weights.at(np.array([temperature]))[0]
        return found

    def taps(self, temperature: float, across: Across) -> Real:
        """Taps (N, M) to be added at a temperature in the middle, °C, and a tilt, K."""
        return np.asarray(np.einsum("pk,npkm->nm", self.weighted(temperature, across), self.banks))

    def loudest(self, temperature: Real, taps: Real) -> tuple[float, float]:
        """Bounds of filters with any tilt that is allowed.

        Parameters
        ----------
        temperature : (T,) ndarray, °C
        taps : (T, N, M) ndarray
            Without a tilt.

        Returns
        -------
        (float, float)
            Of a tap, and of the sum of the taps of one actuator, without their signs. Every tap is a parabola in
            each tilt; its parts at their largest bound it.
        """
        weights = self.weights.at(temperature)[:, 0]
        terms = np.einsum("tk,npkm->tpnm", weights, self.banks)
        reach = self.across
        whole = np.abs(taps) + (np.abs(terms[:, :2]) * reach + np.abs(terms[:, 2:]) * (0.5 * reach**2)).sum(axis=1)
        return float(whole.max()), float(whole.sum(axis=2).max())
