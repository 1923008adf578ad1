"""One network per actuator: temperature in, the taps of its filter out (paper section 5.2)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Real = NDArray[np.float64]


@dataclass(frozen=True)
class NetworkBank:
    """Trained networks of N actuators: tanh hidden layer of H nodes, M linear outputs.

    Attributes
    ----------
    temperature_range : (float, float)
        Trained range, degrees Celsius; mapped to -1..1 at the input.
    slope, bias : (N, H) ndarray
        Of the hidden nodes.
    output : (N, H+1, M) ndarray
        Weights into the taps and, last, their biases, scales undone: V per unit of audio signal.
    """

    temperature_range: tuple[float, float]
    slope: Real
    bias: Real
    output: Real

    def __post_init__(self) -> None:
        low, high = self.temperature_range
        if not low < high:
            raise ValueError(f"temperature range {low:g} to {high:g} °C must ascend")
        count, nodes = self.slope.shape
        if self.bias.shape != (count, nodes) or self.output.shape[:2] != (count, nodes + 1):
            raise ValueError(
                f"slope {self.slope.shape}, bias {self.bias.shape} and output {self.output.shape} must be "
                "(N, H), (N, H) and (N, H+1, M)"
            )

    def taps(self, temperature: ArrayLike) -> Real:
        """Return filters (T, N, M) at `temperature` (T,), degrees Celsius; outside the range, those of its end."""
        low, high = self.temperature_range
        inside = np.clip(np.atleast_1d(np.asarray(temperature, dtype=float)), low, high)
        x = scaled(inside, self.temperature_range)
        hidden = np.tanh(x[:, None, None] * self.slope + self.bias)
        taps: Real = np.einsum("tnh,nhm->tnm", hidden, self.output[:, :-1]) + self.output[:, -1]
        return taps

    def outside(self, temperature: ArrayLike) -> NDArray[np.bool_]:
        """Which of `temperature` (T,) lie outside the trained range: their filters are clamped, not predicted."""
        t = np.atleast_1d(np.asarray(temperature, dtype=float))
        low, high = self.temperature_range
        return ~((t >= low - 1e-9) & (t <= high + 1e-9))


def scaled(temperature: Real, temperature_range: tuple[float, float]) -> Real:
    """Temperatures on -1..1 over the trained range."""
    low, high = temperature_range
    return (2.0 * temperature - low - high) / (high - low)
