"""Filters at any temperature: one network per actuator (paper section 5.2), a mean and principal filters.

The relative error of reconstructed filters is that of the paper's eq. (13).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.focusing.fir import FirBank


@dataclass(frozen=True)
class InputMap:
    """Input of networks at a temperature, from -1 to 1 over the trained range.

    Attributes
    ----------
    temperature : (k,) ndarray
        Ascending, degrees Celsius; its ends are the trained range.
    value : (k,) ndarray
        The input there, interpolated linearly: two points for the temperature itself, a finer table for log √D(T),
        with which the modes' log frequencies change linearly.
    """

    temperature: Real
    value: Real

    def __post_init__(self) -> None:
        low, high = self.temperature_range
        if not (np.diff(self.temperature) > 0.0).all():
            raise ValueError(f"temperature range {low:g} to {high:g} °C must ascend")
        if self.value.shape != self.temperature.shape or not np.isfinite(self.value).all():
            raise ValueError(f"{self.value.shape} inputs for {self.temperature.shape} temperatures")

    @classmethod
    def of(cls, temperature: Real, coordinate: Real) -> "InputMap":
        """Stretch a `coordinate` (k,) of `temperature` (k,) to -1..1."""
        low, high = float(coordinate.min()), float(coordinate.max())
        return cls(temperature, (2.0 * coordinate - low - high) / (high - low))

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Trained range, degrees Celsius."""
        return float(self.temperature[0]), float(self.temperature[-1])

    def at(self, temperature: ArrayLike) -> Real:
        """Input (T,) at `temperature` (T,); outside the range, that of its end."""
        value: Real = np.interp(np.atleast_1d(np.asarray(temperature, dtype=float)), self.temperature, self.value)
        return value


@dataclass(frozen=True)
class NetworkBank:
    """Trained networks of N actuators: tanh hidden layer of H nodes, M linear outputs.

    Attributes
    ----------
    input : InputMap
        From temperature to the input of the hidden nodes.
    slope, bias : (N, H) ndarray
        Of the hidden nodes.
    output : (N, H+1, M) ndarray
        Output weights and, last, biases of the taps, without scaling: V per unit of audio signal.
    """

    input: InputMap
    slope: Real
    bias: Real
    output: Real

    def __post_init__(self) -> None:
        count, nodes = self.slope.shape
        if self.bias.shape != (count, nodes) or self.output.shape[:2] != (count, nodes + 1):
            raise ValueError(
                f"slope {self.slope.shape}, bias {self.bias.shape} and output {self.output.shape} must be "
                "(N, H), (N, H) and (N, H+1, M)"
            )

    def taps(self, temperature: ArrayLike) -> Real:
        """Return filters (T, N, M) at `temperature` (T,), degrees Celsius; outside the range, those of its end."""
        x = self.input.at(temperature)
        hidden = np.tanh(x[:, None, None] * self.slope + self.bias)
        taps: Real = np.einsum("tnh,nhm->tnm", hidden, self.output[:, :-1]) + self.output[:, -1]
        return taps

    def outside(self, temperature: ArrayLike) -> NDArray[np.bool_]:
        """Which of `temperature` (T,) lie outside the trained range: their filters are clamped, not predicted."""
        t = np.atleast_1d(np.asarray(temperature, dtype=float))
        low, high = self.input.temperature_range
        return ~((t >= low - 1e-9) & (t <= high + 1e-9))


def relative_error(reconstructed: NDArray[np.float64], true: NDArray[np.float64]) -> NDArray[np.float64]:
    """100 ∫(r - r_true)² / ∫ r_true² over the last axis, in %.

    A ratio of energies: 0.01 % is an error of a hundredth of the filter's amplitude, not of a ten-thousandth. Both
    arrays have shape (..., M); returns (...).
    """
    if reconstructed.shape != true.shape:
        raise ValueError(f"reconstructed {reconstructed.shape} and true {true.shape} filters differ in shape")
    energy = np.sum(true**2, axis=-1)
    if not np.all(energy > 0.0):
        raise ValueError("a true filter is silent: its relative error is undefined")
    ratio: NDArray[np.float64] = 100.0 * np.sum((reconstructed - true) ** 2, axis=-1) / energy
    return ratio


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
