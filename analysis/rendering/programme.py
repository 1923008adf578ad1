"""Temperature over the time of a piece of sound."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Real


@dataclass(frozen=True)
class TemperatureProgramme:
    """Temperatures at some moments, straight in between, held before the first and after the last.

    Attributes
    ----------
    time : (n,) ndarray
        Ascending, s.
    temperature : (n,) ndarray
        Degrees Celsius.
    """

    time: Real
    temperature: Real

    def __post_init__(self) -> None:
        if not len(self.time) or self.temperature.shape != self.time.shape:
            raise ValueError(f"{self.time.shape} moments for {self.temperature.shape} temperatures")
        if not (np.isfinite(self.time).all() and np.isfinite(self.temperature).all()):
            raise ValueError("moments and temperatures must be finite numbers")
        if not (np.diff(self.time) > 0.0).all():
            raise ValueError("moments must ascend")

    @classmethod
    def spread(cls, temperature: Real, duration: float) -> Self:
        """Spread `temperature` (n,) evenly over `duration`, s, from its beginning to its end."""
        if len(temperature) == 1:
            return cls(np.zeros(1), temperature)
        return cls(np.linspace(0.0, duration, len(temperature)), temperature)

    def at(self, time: ArrayLike) -> Real:
        """Temperature at `time`, s."""
        held: Real = np.asarray(np.interp(np.asarray(time, dtype=float), self.time, self.temperature))
        return held
