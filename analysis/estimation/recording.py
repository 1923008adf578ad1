"""Signals of one run of a test, all sampled together."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
