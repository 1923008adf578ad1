"""When a sine sweep passes its frequencies."""

from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from analysis.arrays import Complex, Real

DriveKind = Literal["logarithmic", "linear", "burst-random", "multi-sine"]
"""How a plate is driven: by a sine that passes its frequencies one after the other, or by all of them at once."""

Frequencies = TypeVar("Frequencies", Real, Complex)


@dataclass(frozen=True)
class SweepTiming:
    """A sine whose frequency goes once through a band, and the silence after it.

    Attributes
    ----------
    kind : str
        How the frequency increases with time: ``logarithmic`` or ``linear``.
    band : (float, float)
        Hz.
    taper : float
        When the sweep passes the band's lower edge, s from its beginning; the fade-in lasts until then.
    duration : float
        When the sweep ends, s; it passes the upper edge one taper before.
    record : float
        With the silence, s.
    """

    kind: Literal["logarithmic", "linear"]
    band: tuple[float, float]
    taper: float
    duration: float
    record: float

    def passed_at(self, frequency: Frequencies) -> Frequencies:
        """When the sweep passes frequencies (F,), Hz, real or continued to complex ones; s from its beginning."""
        low, high = self.band
        inner = self.duration - 2.0 * self.taper
        if self.kind == "linear":
            return np.asarray(self.taper + inner * (frequency - low) / (high - low))
        return np.asarray(self.taper + inner * np.log(frequency / low) / np.log(high / low))

    def after_middle(self, frequency: Frequencies) -> Frequencies:
        """When the sweep passes frequencies (F,), Hz; s from the middle of the record.

        It is so for the mean over all repeats, too, in which the middle is that of all records.
        """
        return self.passed_at(frequency) - 0.5 * self.record


def sweep_timing(
    kind: DriveKind, band: tuple[float, float], taper: float, duration: float, record: float
) -> SweepTiming | None:
    """Return when a drive passes its frequencies, see `SweepTiming`; None for one that plays all at once."""
    if kind == "logarithmic" or kind == "linear":
        return SweepTiming(kind, band, taper, duration, record)
    return None
