"""The voltage to be played: a sine sweep in closed form, faded outside its band, then silence."""

import numpy as np
from numpy.typing import NDArray

from analysis.protocol.sweep import SweepSettings


def drive_signal(sweep: SweepSettings, level: float, sample_rate: float) -> NDArray[np.float64]:
    """Sample one repeat of the drive.

    With f1 and f2 the band's edges, D the duration, c the taper and s = t - c, the phase is

        2 pi f1 L (exp(s/L) - exp(-c/L)),  L = (D - 2c)/ln(f2/f1)     logarithmic
        2 pi (f1 t + k (s**2 - c**2)/2),   k = (f2 - f1)/(D - 2c)     linear

    (A. Farina, 108th AES Convention, 2000, for the former), so that the frequency passes f1 at t = c
    and f2 at t = D - c. The level is constant between, and a raised cosine in both tapers.

    Parameters
    ----------
    level : float
        Amplitude, V.
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
    angle = 2.0 * np.pi * _cycles(sweep, time)
    sounding = time < sweep.duration
    signal: NDArray[np.float64] = np.where(sounding, level * _fade(sweep, time) * np.sin(angle), 0.0)
    return signal


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
