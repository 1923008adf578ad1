"""Filters in a weather, judged: temperatures of a panel over time, and what filters lose in them."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes

ONE, ONE_ROBUST, SEVERAL, SEVERAL_ROBUST, TILTED, OWN, OWN_TILTED = WAYS = (
    "one thermometer",
    "one, robust filters",
    "all thermometers",
    "all, robust filters",
    "all, filters of the tilt",
    "own response",
    "own, filters of the tilt",
)


@dataclass(frozen=True)
class WeatherFields:
    """Temperatures of a panel at t moments.

    Attributes
    ----------
    time : (t,) ndarray, s
    temperature : (t, Q) ndarray, °C
        At the points of the model.
    readings : (t, K) ndarray, °C
    places : (K, 2) ndarray
        Of the thermometers, -1 to 1 over the box around the plate.
    names : tuple of str
        Of the thermometers.
    """

    time: Real
    temperature: Real
    readings: Real
    places: Real
    names: tuple[str, ...]

    def __post_init__(self) -> None:
        check_shapes(self, time="t", temperature="t Q", readings="t K", places="K 2", names="K")
        check_finite(self, "temperature", "readings")
        check_ascending(self, "time")


@dataclass(frozen=True)
class WeatherJudgement:
    """Filters in a weather, by W ways of knowing the field; against filters designed for the field itself.

    Attributes
    ----------
    ways : tuple of str
        Of `WAYS`.
    names : tuple of str
        Of the thermometers; the first is the one of the ways with one.
    places : (K, 2) ndarray
        Of the thermometers, -1 to 1 over the box around the plate.
    time : (t,) ndarray, s
    extent : (t, 3) ndarray
        Coldest, mean and warmest place of the plate, °C.
    readings : (t, K) ndarray, °C
    believed : (W, t, 3) ndarray
        Temperature in the middle, °C, and tilts along x and y, K, for which the filters are made.
    contrast : (W, t, F) ndarray
    known : (t, F) ndarray
        Contrast of filters designed for the field.
    level : (W, t, B) ndarray
        Third-octave levels less those of the filters designed for the field, dB: of the target, or at the loud
        listener where the difference is largest, if sound is aimed at.
    price : (2,) ndarray
        Contrast that the robust filters lose on a panel without a tilt: of the mean over the band, and at the
        worst line, at the worst temperature.
    across : float
        Tilt of the family of fields, K.
    """

    ways: tuple[str, ...]
    names: tuple[str, ...]
    places: Real
    time: Real
    extent: Real
    readings: Real
    believed: Real
    contrast: Real
    known: Real
    level: Real
    price: Real
    across: float

    def __post_init__(self) -> None:
        check_shapes(self, time="t", extent="t 3", readings="t K", names="K", known="t F", price="2")
        check_shapes(self, names="K", places="K 2")
        check_shapes(self, ways="W", time="t", believed="W t 3", contrast="W t F", level="W t B")
        check_finite(self, "contrast", "known", "level")

    @property
    def lost(self) -> Real:
        """Contrast lost (W, t, 2): of the mean over the band, and at the worst line."""
        less = self.known - self.contrast
        return np.stack([less.mean(axis=-1), less.max(axis=-1)], axis=-1)

    @property
    def largest(self) -> Real:
        """Largest loss (W, 2) over time, see `lost`."""
        return np.asarray(self.lost.max(axis=1))

    @property
    def level_error(self) -> Real:
        """Largest difference of a third-octave level (W,), dB."""
        return np.asarray(np.abs(self.level).max(axis=(1, 2)))

    @property
    def widest(self) -> float:
        """Largest difference of temperature across the plate, K."""
        return float((self.extent[:, 2] - self.extent[:, 0]).max())
