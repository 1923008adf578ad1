"""The voltage to be played: a sine sweep in closed form, faded outside its band, or many sines; then silence."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.protocol.sweep import SweepSettings

SEED = 20
"""Of the phases of burst random: the same burst in every repeat and after every interruption, so that the spread
of repeats is that of the noise."""
SAMPLES_OF_PERIOD = 32
"""Samples in a period of the highest sine, among which the peak of their sum is sought: it is found to 0.12 %."""
PEAK_FACTOR = 1.002
"""By which the peak is taken to be higher, for what lies between those samples: a level is never exceeded."""


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
