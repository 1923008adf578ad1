"""The drive as declared: a sweep, or all frequencies at once.

When a sine sweep passes its frequencies is computed here.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Literal, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator

from analysis.arrays import Complex, Real
from analysis.declaration.strict import Declared

Level = Annotated[float, Field(gt=0.0, le=100.0)]


MOST_CYCLES = 200_000.0
"""Of the highest of many sines within a drive: a sum of them takes a second and half a gigabyte."""


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


class SweepSettings(Declared):
    """What one repeat plays: something that lasts for the duration, then silence, in which the plate rings down.

    A ``logarithmic`` or ``linear`` sweep is one sine whose frequency runs once through the band. It has its full
    level over the whole band: it is faded in below the band and out above it. ``burst-random`` is noise of an even
    spectrum, ``multi-sine`` the same sines with phases that keep the peak low; both are faded in time only, and
    `levels` are their peaks. Whatever is played, the record holds it and all that answers it: nothing leaks.
    """

    kind: Annotated[DriveKind, Field(description="how the frequency climbs, or that all are played at once")]
    band: Annotated[tuple[float, float], Field(description="Hz, driven at full level")]
    duration: Annotated[float, Field(gt=0.0, le=3600.0, description="s of sound, both fades included")]
    taper: Annotated[float, Field(gt=0.0, le=60.0, description="s of each fade, a raised cosine")]
    tail: Annotated[float, Field(gt=0.0, le=600.0, description="s of silence, for the plate to ring down")]
    repeats: Annotated[int, Field(ge=1, le=1000, description="of the sweep at each set-point")]
    levels: Annotated[tuple[Level, ...], Field(min_length=1, description="V, amplitudes of the drive")]

    @property
    def record(self) -> float:
        """Length of one repeat, s."""
        return self.duration + self.tail

    @property
    def timing(self) -> SweepTiming | None:
        """When it passes its frequencies; None where it plays them all at once."""
        return sweep_timing(self.kind, self.band, self.taper, self.duration, self.record)

    @property
    def is_sweep(self) -> bool:
        """Whether it passes its frequencies one after the other."""
        return self.timing is not None

    @property
    def frequency_range(self) -> tuple[float, float]:
        """Frequencies at which the drive begins and ends, fades included, Hz."""
        low, high = self.band
        if not self.is_sweep:
            return low, high
        inner = self.duration - 2.0 * self.taper
        if self.kind == "linear":
            beyond = (high - low) * self.taper / inner
            return low - beyond, high + beyond
        factor = math.exp(math.log(high / low) * self.taper / inner)
        return low / factor, high * factor

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        low, high = self.band
        if not 0.0 < low < high:
            raise ValueError(f"band {list(self.band)} Hz: the lower edge must be above 0 and below the upper edge")
        if self.taper > 0.25 * self.duration:
            raise ValueError(
                f"taper {self.taper:g} s is more than a quarter of duration ({self.duration:g} s): "
                f"at most {0.25 * self.duration:g} s leaves time for the band"
            )
        if not self.is_sweep and self.duration * high > MOST_CYCLES:
            raise ValueError(
                f"{self.kind} of {self.duration:g} s up to {high:g} Hz is a sum of too many sines; at most "
                f"{MOST_CYCLES / high:.4g} s up to there: shorten duration, repeat more often, or sweep"
            )
        if self.frequency_range[0] <= 0.0:
            raise ValueError(
                f"taper {self.taper:g} s: a linear sweep would begin at {self.frequency_range[0]:.4g} Hz; "
                "shorten the taper, lengthen the sweep, or sweep logarithmically"
            )
        if len(set(self.levels)) != len(self.levels):
            raise ValueError(f"levels {list(self.levels)} V name a level twice")
        return self
