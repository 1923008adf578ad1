"""Signals at the low sample rate that a band needs."""

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import cheby2, sosfilt

from analysis.arrays import Real


@dataclass
class Decimator:
    """Keeps every `factor`-th sample of channels, block by block, with what would be folded back filtered out.

    Drive and response have to go through the same filter: it then changes nothing of what joins them.

    Attributes
    ----------
    channels : int
    sample_rate : float
        Before, Hz.
    highest : float
        Of the band, Hz: up to there nothing is lost or folded back.
    """

    channels: int
    sample_rate: float
    highest: float
    _state: Real = field(init=False, repr=False)
    _seen: int = field(init=False, default=0, repr=False)

    def __post_init__(self) -> None:
        self._state = np.zeros((len(self._sections), self.channels, 2))

    @property
    def factor(self) -> int:
        """Samples of which one is kept: the new rate is 2.56 times the band, or a little more."""
        return max(1, int(self.sample_rate / (2.56 * self.highest)))

    @property
    def rate(self) -> float:
        """Sample rate after, Hz."""
        return self.sample_rate / self.factor

    @property
    def _sections(self) -> Real:
        if self.factor == 1:
            return np.array([[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]])
        # 80 dB down where what is folded back would reach the band.
        edge = 2.0 * (self.rate - self.highest) / self.sample_rate
        sections: Real = cheby2(12, 80.0, edge, output="sos")
        return sections

    def take(self, samples: Real) -> Real:
        """Filter a block (channels, n) and return the samples kept of it."""
        filtered, self._state = sosfilt(self._sections, samples, axis=-1, zi=self._state)
        first = -self._seen % self.factor
        self._seen += samples.shape[1]
        kept: Real = filtered[:, first :: self.factor]
        return kept
