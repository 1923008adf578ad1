"""Readings one after the other: a Kalman filter of temperature and rate, which bridges refused readings."""

from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Real
from analysis.thermometry.listening import ThermometerReading


@dataclass
class Track:
    """Temperature and its rate, the rate wandering at random (integrated white noise).

    Attributes
    ----------
    wander : float
        Standard deviation of what the rate gains in a second, K/s.
    first_rate : float
        Standard deviation of the rate at the beginning, K/s.
    gate : float
        Standard deviations beyond which a reading is passed over; three such readings on end begin the track anew.
    """

    wander: float = 0.002
    first_rate: float = 0.05
    gate: float = 5.0
    _state: Real = field(init=False, default_factory=lambda: np.full(2, np.nan), repr=False)
    _covariance: Real = field(init=False, default_factory=lambda: np.zeros((2, 2)), repr=False)
    _strange: int = field(init=False, default=0, repr=False)

    @property
    def temperature(self) -> float:
        """Degrees Celsius; NaN before the first reading."""
        return float(self._state[0])

    @property
    def sigma(self) -> float:
        """One standard deviation, K; infinite before the first reading."""
        return float(np.sqrt(self._covariance[0, 0])) if self._known else np.inf

    @property
    def _known(self) -> bool:
        return bool(np.isfinite(self._state[0]))

    def step(self, reading: ThermometerReading, seconds: float) -> None:
        """Predict `seconds` ahead and update with the reading there; a refused reading is not used."""
        if self._known:
            move = np.array([[1.0, seconds], [0.0, 1.0]])
            s = seconds
            noise = self.wander**2 * np.array([[s**3 / 3.0, s**2 / 2.0], [s**2 / 2.0, s]])
            self._state = move @ self._state
            self._covariance = move @ self._covariance @ move.T + noise
        if reading.refused:
            return
        variance = reading.sigma**2
        beyond = reading.temperature - self.temperature
        if self._known and beyond**2 > self.gate**2 * (self._covariance[0, 0] + variance):
            self._strange += 1
            if self._strange < 3:
                return
        if not self._known or self._strange:
            if not self._known or self._strange >= 3:
                self._state = np.array([reading.temperature, 0.0])
                self._covariance = np.diag([variance, self.first_rate**2])
                self._strange = 0
                return
            self._strange = 0
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + variance)
        self._state = self._state + gain * beyond
        self._covariance = self._covariance - np.outer(gain, self._covariance[0])
