"""The drive: a sweep, or all frequencies at once, as declared, as the voltage to be played, and as recorded.

When a sine sweep passes its frequencies is computed here, and delay, deviation and clocks of a recorded drive.
Two crystals differ by a constant share, some ten millionths, and a sweep of a minute is then some hundred samples
shorter or longer than it was asked for. That harms no result: drive and responses are recorded by the same clock.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from analysis.arrays import Complex, Real
from analysis.declaration.strict import Declared

SEED = 20
"""Of the phases of burst random: the same burst in every repeat and after every interruption, so that the spread
of repeats is that of the noise."""
SAMPLES_OF_PERIOD = 32
"""Samples in a period of the highest sine, among which the peak of their sum is sought: it is found to 0.12 %."""
PEAK_FACTOR = 1.002
"""By which the peak is taken to be higher, for what lies between those samples: a level is never exceeded."""
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


def drive_signal(sweep: SweepSettings, level: float, sample_rate: float) -> NDArray[np.float64]:
    """Sample one repeat of the drive.

    With f1 and f2 the band's edges, D the duration, c the taper and s = t - c, the phase is

        2 pi f1 L (exp(s/L) - exp(-c/L)),  L = (D - 2c)/ln(f2/f1)     logarithmic
        2 pi (f1 t + k (s**2 - c**2)/2),   k = (f2 - f1)/(D - 2c)     linear

    (A. Farina, 108th AES Convention, 2000, for the former), so that the frequency passes f1 at t = c
    and f2 at t = D - c. The level is constant between, and a raised cosine in both tapers.

    Burst random and multi-sine are sums of N sines of equal amplitude at the multiples of 1/D in the band, with
    the fade of a sweep at both ends; their phases are drawn evenly, or pi n (n - 1)/N (M. R. Schroeder, IEEE
    Transactions on Information Theory 16, 1970), whose sum has a peak of 1.7 times its rms in place of 4.6.

    Parameters
    ----------
    level : float
        Amplitude of a sweep, peak of many sines, V.
    sample_rate : float
        As read back, Hz.

    Returns
    -------
    (M,) ndarray, V
        Begins and ends with 0; silent for the tail.

    Raises
    ------
    ValueError
        If the sweep ends beyond half of the sample rate.
    """
    if sweep.frequency_range[1] >= 0.5 * sample_rate:
        raise ValueError(
            f"the sweep ends at {sweep.frequency_range[1]:.5g} Hz, fade included; below half of the sample rate "
            f"({0.5 * sample_rate:.5g} Hz) allowed"
        )
    time = np.arange(round(sweep.record * sample_rate)) / sample_rate
    if not sweep.is_sweep:
        played = level / _peak(sweep) * _fade(sweep, time) * _sum_of_sines(sweep, time.size, sample_rate)
        many: NDArray[np.float64] = np.where(time < sweep.duration, played, 0.0)
        return many
    angle = 2.0 * np.pi * _cycles(sweep, time)
    sounding = time < sweep.duration
    signal: NDArray[np.float64] = np.where(sounding, level * _fade(sweep, time) * np.sin(angle), 0.0)
    return signal


def _sum_of_sines(sweep: SweepSettings, samples: int, sample_rate: float) -> NDArray[np.float64]:
    """Return the sines' sum, each of amplitude 1, at any sample rate, by a chirp z-transform."""
    from scipy.signal import czt

    low, high = (edge * sweep.duration for edge in sweep.band)
    lines = np.arange(int(np.ceil(low - 1e-9)), int(np.floor(high + 1e-9)) + 1)
    if sweep.kind == "multi-sine":
        number = np.arange(1.0, lines.size + 1.0)
        phase = np.pi * number * (number - 1.0) / lines.size
    else:
        phase = np.random.default_rng(SEED).uniform(0.0, 2.0 * np.pi, lines.size)
    step = 2.0 * np.pi / (sweep.duration * sample_rate)
    summed = czt(np.exp(1j * phase), samples, np.exp(1j * step))
    first = np.exp(1j * (step * lines[0] * np.arange(samples)))
    return np.asarray((first * summed).imag)


@lru_cache(maxsize=8)
def _peak(sweep: SweepSettings) -> float:
    """Return the largest magnitude of the faded sum, whatever rate it is sampled at."""
    rate = SAMPLES_OF_PERIOD * sweep.band[1]
    time = np.arange(round(sweep.duration * rate)) / rate
    return PEAK_FACTOR * float(np.abs(_fade(sweep, time) * _sum_of_sines(sweep, time.size, rate)).max())


def _cycles(sweep: SweepSettings, time: NDArray[np.float64]) -> NDArray[np.float64]:
    low, high = sweep.band
    inner = sweep.duration - 2.0 * sweep.taper
    since = np.minimum(time, sweep.duration) - sweep.taper
    if sweep.kind == "linear":
        slope = (high - low) / inner
        return np.asarray(low * (since + sweep.taper) + 0.5 * slope * (since**2 - sweep.taper**2))
    scale = inner / np.log(high / low)
    return np.asarray(low * scale * (np.exp(since / scale) - np.exp(-sweep.taper / scale)))


def _fade(sweep: SweepSettings, time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the level, 0 to 1."""
    to_an_end = np.clip(np.minimum(time, sweep.duration - time) / sweep.taper, 0.0, 1.0)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * to_an_end))


def compare_drive(
    recorded: NDArray[np.floating],
    played: NDArray[np.float64],
    sample_rate: float,
    frequencies: tuple[float, float],
) -> tuple[float, float, float]:
    """Compare a drive as recorded with the drive as played, over its own frequencies.

    A card delays by a constant number of samples, not a whole one. A sample lost or doubled in the
    middle splits the record into two parts of different delay, which no single delay can align.

    Parameters
    ----------
    recorded : (M,) ndarray, V
    played : (M,) ndarray, V
    sample_rate : float
        Hz.
    frequencies : (float, float)
        First and last frequency of the drive, Hz.

    Returns
    -------
    gain : float
        Recorded over played, of the part that is alike.
    delay : float
        Samples.
    correlation : float
        1 for a pure delay, 0 for nothing in common.
    """
    from scipy.fft import next_fast_len, rfft, rfftfreq

    size = next_fast_len(played.size, real=True)
    grid = rfftfreq(size, 1.0 / sample_rate)
    inside = (grid >= frequencies[0]) & (grid <= frequencies[1])
    u, r = rfft(played, size), rfft(np.asarray(recorded, dtype=np.float64), size)
    cross = np.where(inside, r * u.conj(), 0.0)
    whole = whole_delay(cross, size)
    omega = 2.0 * np.pi * grid / sample_rate
    aligned = cross * np.exp(1j * omega * whole)
    weight = np.abs(aligned)
    if not weight.sum() > 0.0:
        return 0.0, 0.0, 0.0
    rest = -float((weight * omega * np.angle(aligned)).sum() / (weight * omega**2).sum())
    common = float((aligned * np.exp(1j * omega * rest)).real.sum())
    power = float((np.abs(u[inside]) ** 2).sum())
    return common / power, whole + rest, common / float(np.sqrt(power * (np.abs(r[inside]) ** 2).sum()))


def whole_delay(cross: NDArray[np.complex128], size: int) -> int:
    """Return the delay in a cross spectrum (size // 2 + 1,) to a few samples.

    It is read from the envelope of the correlation: the correlation itself has a peak in every period of a narrow
    band.
    """
    from scipy.fft import ifft

    whole = int(np.argmax(np.abs(ifft(cross, size))))
    return whole - size if whole > size // 2 else whole


LARGEST_CRYSTAL_DIFFERENCE = 3e-4
"""Largest difference between two crystals: those of cards are within 1e-4 or better, as a share."""
LEAST_SHIFT_SEEN = 0.1
"""A difference that comes to less over a whole record is none, samples."""


def clock_difference(
    recorded: NDArray[np.floating], played: Real, sample_rate: float, sweep: SweepSettings
) -> float:
    """Estimate the difference between two clocks from a drive that was recorded several times.

    Played faster by the share e, a sweep of spectrum U(w) has the spectrum U(w/(1 + e)): its phase leads by
    e w t(w), with the group delay t(w), the moment at which the sweep passes w. Crystals do not change within
    minutes: the middle of all repeats is taken, and samples lost in one of them are not mistaken for a clock.

    Parameters
    ----------
    recorded : (R, M) ndarray
    played : (M,) ndarray, V
    sample_rate : float
        As both cards state it, Hz.
    sweep : SweepSettings
        What was played.

    Returns
    -------
    float
        A share, above 0 where the output is the faster one; within +-`LARGEST_CRYSTAL_DIFFERENCE`, and 0 where
        none is seen.
    """
    from scipy.fft import next_fast_len, rfft, rfftfreq

    if sweep.kind == "burst-random":
        return _difference_of_bursts(recorded, played, sample_rate, sweep)
    level = float(np.abs(played).max())
    size = next_fast_len(played.size, real=True)
    spectra = [rfft(np.asarray(repeat, dtype=np.float64), size) for repeat in recorded]
    grid = rfftfreq(size, 1.0 / sample_rate)
    low, high = sweep.frequency_range
    inside = (grid >= low) & (grid <= high)
    omega = 2.0 * np.pi * grid[inside]
    passing = omega * _passed_at(sweep, grid[inside])
    found = 0.0
    for by_lag in (True, True, False):
        reference = rfft(stretched(played, found, sample_rate, sweep, level) if found else played, size)
        crossed = (_aligned(spectrum * reference.conj(), inside, size) for spectrum in spectra)
        more = [_fitted(cross, omega, passing, by_lag) for cross in crossed]
        found = float(np.clip(found + np.median(more), -LARGEST_CRYSTAL_DIFFERENCE, LARGEST_CRYSTAL_DIFFERENCE))
    return found if abs(found) * played.size > LEAST_SHIFT_SEEN else 0.0


def _passed_at(sweep: SweepSettings, frequency: Real) -> Real:
    """Return when frequencies (F,), Hz, are passed, s.

    By Schroeder's phases a multi-sine, too, passes them one after the other, from the highest to the lowest.
    """
    if sweep.timing is not None:
        return sweep.timing.passed_at(frequency)
    low, high = sweep.band
    return np.asarray(sweep.duration * (high - frequency) / (high - low))


def _difference_of_bursts(
    recorded: NDArray[np.floating], played: Real, sample_rate: float, sweep: SweepSettings
) -> float:
    """Estimate the difference for a drive that plays all frequencies at once: its end is then early, or late.

    The delays of both halves of the drive are compared, each faded in and out.
    """
    level, time = float(np.abs(played).max()), np.arange(played.size) / sample_rate
    half = 0.5 * sweep.duration
    fades = [
        np.where((time >= start) & (time < start + half), np.sin(np.pi * (time - start) / half) ** 2, 0.0)
        for start in (0.0, half)
    ]
    found = 0.0
    for _ in range(3):
        reference = stretched(played, found, sample_rate, sweep, level) if found else played
        more = []
        for repeat in recorded:
            first, last = (
                compare_drive(repeat * fade, reference * fade, sample_rate, sweep.frequency_range)[1]
                for fade in fades
            )
            more.append((first - last) / (half * sample_rate))
        found = float(np.clip(found + np.median(more), -LARGEST_CRYSTAL_DIFFERENCE, LARGEST_CRYSTAL_DIFFERENCE))
    return found if abs(found) * played.size > LEAST_SHIFT_SEEN else 0.0


def stretched(played: Real, difference: float, sample_rate: float, sweep: SweepSettings, level: float) -> Real:
    """Return a drive as it is recorded where the clock that plays it is faster.

    Parameters
    ----------
    played : (M,) ndarray, V
        The drive as asked for; only its length counts.
    difference : float
        Share by which the playing clock is faster.
    sample_rate : float
        Of the recording clock, Hz.
    level : float
        Of the drive, V.

    Returns
    -------
    (M,) ndarray, V
    """
    signal = drive_signal(sweep, level, sample_rate / (1.0 + difference))
    return np.asarray(np.pad(signal, (0, max(0, played.size - signal.size)))[: played.size])


def _aligned(cross: NDArray[np.complex128], inside: NDArray[np.bool_], size: int) -> NDArray[np.complex128]:
    """Return a cross spectrum over the sweep's own lines, whole samples of delay taken out."""
    within = np.where(inside, cross, 0.0)
    turn = 2.0 * np.pi * whole_delay(within, size) / size
    return np.asarray(within[inside] * np.exp(1j * turn * np.flatnonzero(inside)))


def _fitted(cross: NDArray[np.complex128], omega: Real, passing: Real, by_lag: bool) -> float:
    """Fit the cross spectrum's phase by a delay and a difference of clocks; return the latter.

    By lag, from the phase between lines so near to each other that it cannot have gone round; for what is then
    left, from the phase itself.
    """
    if by_lag:
        steepest = float(np.abs(np.diff(passing)).max(initial=0.0))
        lag = int(np.clip(1.0 / max(LARGEST_CRYSTAL_DIFFERENCE * steepest, 1e-9), 1, max(1, cross.size // 3)))
        cross = cross[lag:] * cross[:-lag].conj()
        omega, passing = omega[lag:] - omega[:-lag], passing[lag:] - passing[:-lag]
    weight, phase = np.abs(cross), np.angle(cross)
    scale = np.array([1.0 / np.abs(omega).max(), 1.0 / max(np.abs(passing).max(), 1e-300)])
    basis = np.stack([omega, passing]) * scale[:, None]
    normal = (weight * basis) @ basis.T
    if not weight.sum() > 0.0 or np.linalg.cond(normal) > 1e12:
        return 0.0
    return float((np.linalg.solve(normal, (weight * basis) @ phase) * scale)[1])
