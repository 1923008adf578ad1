"""Signals of one run of a test, and their auto and cross spectra, averaged over segments or blocks.

Blows, periods, bursts, sweeps or noise: what drove a test, as far as it decides how spectra are averaged.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range, check_shapes
from analysis.estimation.windows import Shape, effective_averages, segment_window

PILED_UP = 5.0
"""Ratio of how often the largest value of a signal and the next one occur, from which the signal was cut off."""

FEWEST_SAMPLES = 16
"""Samples below which nothing can be estimated."""


@dataclass(frozen=True)
class SampledSignals:
    """What drove a structure, and what it answered.

    Attributes
    ----------
    rate : float
        Samples per second, Hz.
    drives : (M, N) ndarray
        Forces or what else drove, SI.
    responses : (K, N) ndarray
        SI.
    """

    rate: float
    drives: NDArray[np.float64]
    responses: NDArray[np.float64]

    def __post_init__(self) -> None:
        if not (np.isfinite(self.rate) and self.rate > 0.0):
            raise ValueError(f"sample rate {self.rate:g} Hz; above 0 allowed")
        if self.drives.ndim != 2 or self.responses.ndim != 2 or not len(self.drives) or not len(self.responses):
            raise ValueError("at least one drive and one response are needed")
        if self.drives.shape[1] != self.responses.shape[1]:
            raise ValueError(
                f"drives of {self.drives.shape[1]} samples, responses of {self.responses.shape[1]}; all "
                "channels of a run are as long"
            )
        if self.drives.shape[1] < FEWEST_SAMPLES:
            raise ValueError(f"{self.drives.shape[1]} samples; at least {FEWEST_SAMPLES} are needed")

    @property
    def samples(self) -> int:
        """In each channel."""
        return int(self.drives.shape[1])


def signal_faults(names: Sequence[str], signals: Sequence[NDArray[np.float64]]) -> list[str]:
    """Return the faults of recorded signals: a sentence for each, with what to do next."""
    said = []
    for name, signal in zip(names, signals, strict=True):
        place = f"channel {name!r}"
        bad = np.flatnonzero(~np.isfinite(signal))
        if len(signal) < FEWEST_SAMPLES:
            said.append(f"{place}: {len(signal)} of at least {FEWEST_SAMPLES} samples; export the whole recording")
        elif len(bad):
            said.append(
                f"{place}: sample {bad[0] + 1} of {len(signal)} is not a finite number ({len(bad)} in all); "
                "export the recording again, or leave these samples out"
            )
        elif not signal.any():
            said.append(f"{place}: zero throughout; look at cable and sensor, or give it the role unused")
        elif np.ptp(signal) == 0.0:
            said.append(
                f"{place}: constant at {signal[0]:g}; a channel without a sensor? look at cable and coupling, or "
                "give it the role unused"
            )
    return said


def _piled_up(signal: NDArray[np.float64]) -> bool:
    """Whether the largest value occurs far more often than the next one."""
    largest = signal.max()
    often = int((signal == largest).sum())
    below = signal[signal < largest]
    return often >= 4 and len(below) > 0 and often >= PILED_UP * int((below == below.max()).sum())


def clipped(signal: NDArray[np.float64], full_scale: float | None = None) -> bool:
    """Whether a signal was cut off: at its full scale, or at a largest value held for four samples or often met.

    Of fast vibration single samples are cut off: the largest value then occurs `PILED_UP` times
    as often as the next one. A signal of few levels that was not cut off has its next value nearly as often.
    """
    if not signal.any():
        return False
    size = np.abs(signal)
    if full_scale is not None and size.max() >= full_scale * (1.0 - 1e-6):
        return True
    flat = ((signal == signal.max()) | (signal == signal.min())) & (size >= 0.5 * size.max())
    together: NDArray[np.bool_] = flat[3:] & flat[2:-1] & flat[1:-2] & flat[:-3]
    if any(_piled_up(one) for one in (signal, -signal) if one.max() >= 0.5 * size.max()):
        return True
    same = (np.diff(signal)[:-2] == 0.0) & (np.diff(signal)[1:-1] == 0.0) & (np.diff(signal)[2:] == 0.0)
    return bool((together & same).any())


@dataclass(frozen=True)
class Spectra:
    """Averages over n segments; their common factor, which every ratio is free of, is left as it comes.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    g_uu : (F, M, M) complex ndarray
        Drives by drives: mean of u u^H.
    g_yu : (F, K, M) complex ndarray
        Responses by drives: mean of y u^H.
    g_yy : (F, K) ndarray
        Of each response.
    averages : float
        Number of independent segments with the same information.
    """

    frequency: NDArray[np.float64]
    g_uu: NDArray[np.complex128]
    g_yu: NDArray[np.complex128]
    g_yy: NDArray[np.float64]
    averages: float

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", g_uu="F M M", g_yu="F K M", g_yy="F K")
        check_range(self, 0.0, np.inf, "averages", above=True)


def of_blocks(
    drives: NDArray[np.float64], responses: NDArray[np.float64], rate: float, averages: float | None = None
) -> Spectra:
    """Spectra of blocks that are windowed already.

    Parameters
    ----------
    drives, responses : (B, M, N) and (B, K, N) ndarray
        Blocks of each channel.
    rate : float
        Hz.
    averages : float, optional
        Number of independent blocks with the same information; all of them unless given.
    """
    count, _, samples = drives.shape
    u = np.moveaxis(np.fft.rfft(drives, axis=2), 2, 0)
    y = np.moveaxis(np.fft.rfft(responses, axis=2), 2, 0)
    return Spectra(
        frequency=np.asarray(np.fft.rfftfreq(samples, 1.0 / rate), dtype=float),
        g_uu=np.einsum("fbi,fbj->fij", u, u.conj()) / count,
        g_yu=np.einsum("fbi,fbj->fij", y, u.conj()) / count,
        g_yy=(np.abs(y) ** 2).mean(1),
        averages=float(count) if averages is None else averages,
    )


def welch(recording: SampledSignals, segment: float, window: Shape = "hann", overlap: float = 0.5) -> Spectra:
    """Spectra of a stationary recording from overlapping windowed segments (Welch, 1967), each less its mean.

    Parameters
    ----------
    segment : float
        Length of a segment, s; lines lie 1/segment apart.
    window : str
    overlap : float
        Share of a segment that the next one begins with, 0 to 0.95.

    Raises
    ------
    ValueError
        Where the recording is shorter than a segment, or the overlap out of its range.
    """
    if not 0.0 <= overlap <= 0.95:
        raise ValueError(f"overlap {overlap:g}; 0 to 0.95 allowed")
    length = round(segment * recording.rate)
    if not 16 <= length <= recording.samples:
        raise ValueError(
            f"segments of {segment:g} s are {length} samples; allowed: 16 to the {recording.samples} of the "
            f"recording ({recording.samples / recording.rate:g} s): record longer, or take shorter segments"
        )
    starts = segment_starts(recording.samples, length, overlap)
    weight = segment_window(window, length)

    def cut(signals: NDArray[np.float64]) -> NDArray[np.float64]:
        blocks = np.stack([signals[:, start : start + length] for start in starts])
        blocks = blocks - blocks.mean(axis=2, keepdims=True)
        return np.asarray(blocks * weight)

    averages = effective_averages(weight, int(starts[1]) if len(starts) > 1 else length, len(starts))
    return of_blocks(cut(recording.drives), cut(recording.responses), recording.rate, averages)


def segment_starts(samples: int, length: int, overlap: float) -> NDArray[np.intp]:
    """Return where the segments of a recording begin.

    Parameters
    ----------
    samples : int
        Of the recording.
    length : int
        Of a segment, samples.
    overlap : float
        Share of a segment that the next one begins with.

    Returns
    -------
    (S,) ndarray of int
        First sample of each segment that fits in.
    """
    return np.arange(0, samples - length + 1, max(round(length * (1.0 - overlap)), 1))


def pooled(parts: list[Spectra]) -> Spectra:
    """Average spectra of several runs of the same channels, each with the weight of its averages."""
    total = sum(part.averages for part in parts)
    share = [part.averages / total for part in parts]
    return Spectra(
        frequency=parts[0].frequency,
        g_uu=np.sum([s * part.g_uu for s, part in zip(share, parts, strict=True)], axis=0),
        g_yu=np.sum([s * part.g_yu for s, part in zip(share, parts, strict=True)], axis=0),
        g_yy=np.sum([s * part.g_yy for s, part in zip(share, parts, strict=True)], axis=0),
        averages=total,
    )


PERIODIC_CORRELATION = 0.9
"""Correlation of a drive with itself one period later; 0.99 with 10 % of noise in the measured drive."""

FALLEN_CORRELATION = 0.5
"""Correlation to which a drive falls before it repeats; slow signals resemble themselves at short delays."""

SWEPT_UNEVENNESS = 4.0
"""Ratio of two unevennesses of power over time, that of a line and that of all lines, from which lines are driven
in turn. It is 2 for stationary noise and for bursts of noise, and the number of pieces for a slow sweep."""

SWEPT_PIECES = 32
"""Into which a recording is cut to see whether it is swept."""

DRIVEN_POWER = 1e-3
"""Share of the strongest line's power from which a line is driven."""

LEVEL_AT_REST = 0.03
"""Level at the end of a segment, as a share of the whole segment's, below which it is at rest."""

SHARE_OF_END = 0.02
"""Share of a segment that is its end."""

HAMMER_LEVEL, HAMMER_TIME_SHARE = 0.1, 0.1
"""A hammer's force exceeds this share of its largest value in less than this share of the time; noise in 0.7."""


def period(drives: NDArray[np.float64]) -> int | None:
    """Return the samples after which the drives repeat; None where they do not, twice at least.

    Parameters
    ----------
    drives : (M, N) ndarray
    """
    count = drives.shape[1]
    centred = drives - drives.mean(axis=1, keepdims=True)
    spectrum = np.fft.rfft(centred, 2 * count, axis=1)
    product = np.fft.irfft((np.abs(spectrum) ** 2).sum(axis=0))[: count // 2 + 1]
    energy = np.cumsum((centred**2).sum(axis=0))
    lags = np.arange(len(product))
    early, late = energy[count - 1 - lags], energy[-1] - np.append(0.0, energy)[lags]
    alike = product / np.sqrt(np.maximum(early * late, np.finfo(float).tiny))
    apart = np.flatnonzero(alike < FALLEN_CORRELATION)
    if not len(apart) or not (rest := alike[apart[0] :]).size or rest.max() < PERIODIC_CORRELATION:
        return None
    near = np.flatnonzero(rest > 0.98 * rest.max())
    first = near[: 1 + int(np.argmax(np.append(np.diff(near) > 1, True)))]  # samples around the first peak
    return int(apart[0] + first[np.argmax(rest[first])])


def is_swept(drives: NDArray[np.float64]) -> bool:
    """Whether the lines are driven one after the other, in (M, N) drives."""
    length = drives.shape[1] // SWEPT_PIECES
    if length < 16:
        return False
    pieces = drives[:, : SWEPT_PIECES * length].reshape(len(drives), SWEPT_PIECES, length)
    weight = np.hanning(length)
    power = (np.abs(np.fft.rfft((pieces - pieces.mean(axis=2, keepdims=True)) * weight, axis=2)) ** 2).sum(axis=0)
    lines = power[:, power.mean(axis=0) > DRIVEN_POWER * power.mean(axis=0).max()]
    by_line = (lines**2).mean(axis=0) / lines.mean(axis=0) ** 2
    whole = lines.sum(axis=1)
    return bool(np.median(by_line) > SWEPT_UNEVENNESS * (whole**2).mean() / whole.mean() ** 2)


def is_impacts(drive: NDArray[np.float64]) -> bool:
    """Whether a drive (N,) acts in short blows with rest between them."""
    force = np.abs(drive - np.median(drive))
    return bool((force > HAMMER_LEVEL * force.max()).mean() < HAMMER_TIME_SHARE)


def fitting_segments(recording: SampledSignals, seconds: float) -> tuple[float, Shape, float]:
    """Return length, window and overlap of segments: a whole period or sweep, or else Hann's of `seconds`."""
    repeats = period(recording.drives)
    if repeats is None and not is_swept(recording.drives):
        return seconds, "hann", 0.5
    return (recording.samples if repeats is None else repeats) / recording.rate, "rectangular", 0.0


def leaks(recording: SampledSignals, seconds: float, window: Shape = "hann", overlap: float = 0.5) -> bool:
    """Whether segments cut through responses that go on, as with noise; the leakage is then that of `Segments`.

    Rectangular segments that hold a whole period, a whole burst or a whole sweep have none.

    Parameters
    ----------
    seconds : float
        Length of a segment.
    window : str
    overlap : float
        Share of a segment that the next one begins with.

    Raises
    ------
    ValueError
        Where the segments cut a periodic or swept drive, whose leakage depends on the phases of its lines and
        cannot be corrected; with the segments that do not.
    """
    rate = recording.rate
    length = round(seconds * rate)
    starts = segment_starts(recording.samples, length, overlap)
    if window == "rectangular" and _rests_at_ends(recording, starts, length):
        return False
    wanted, shape, _ = fitting_segments(recording, seconds)
    if shape != "rectangular":
        return True
    if window == "rectangular" and abs(length - round(wanted * rate)) <= 1:
        return False
    seen = "sweeps once" if round(wanted * rate) == recording.samples else f"repeats every {wanted:.6g} s"
    raise ValueError(
        f"its drive {seen}; segments of {seconds:g} s with the window {window} would make damping wrong by an "
        f'unknown amount: set segments.seconds = {wanted:.9g}, segments.window = "rectangular" and '
        "segments.overlap = 0"
    )


def _rests_at_ends(recording: SampledSignals, starts: NDArray[np.intp], length: int) -> bool:
    """Whether drives and responses are at rest at the end of every segment, as after bursts."""
    if not len(starts):
        return False
    signals = np.concatenate([recording.drives, recording.responses])
    blocks = np.stack([signals[:, start : start + length] for start in starts])
    blocks = blocks - np.median(blocks, axis=2, keepdims=True)
    ends = blocks[:, :, length - max(round(SHARE_OF_END * length), 1) :]
    return bool((np.sqrt((ends**2).mean(axis=2)) < LEVEL_AT_REST * np.sqrt((blocks**2).mean(axis=2))).all())
