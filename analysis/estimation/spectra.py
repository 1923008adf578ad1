"""Auto and cross spectra of drives and responses, averaged over segments or blocks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range, check_shapes
from analysis.estimation.recording import SampledSignals
from analysis.estimation.windows import Shape, effective_averages, segment_window


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
