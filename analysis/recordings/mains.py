"""Mains hum in FRFs: which lines it takes, and its true frequency where that is not the nominal one."""

from math import comb

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.recordings.noise_power import single_repeat_power

FUNDAMENTALS = np.arange(45.0, 65.0, 0.01)
"""Hz: 50 and 60 Hz grids, and generators."""
LEAST_HARMONICS = 10
"""Fewer could be loud by chance at one of so many fundamentals."""
LOUD_HARMONICS = 5.0
"""Excess of the harmonics' median power over the noise, for one sweep; averages over n may be sqrt(n) fainter."""
GRIDS, WANDER = np.array([50.0, 60.0]), 0.1
"""Hz: grids, and how far their frequency wanders. So near to them fewer harmonics do, if they are louder."""
LEAST_OF_A_GRID, LOUD_OF_A_GRID = 4, 20.0
"""Harmonics that do there, and their excess."""

STANDS_OUT = 30.0
"""Power of an odd harmonic's roughness, over that around it, from which it counts as loud."""
FEWEST_ODD = 3
"""Odd harmonics within the band: of fewer, all may be loud by chance."""
CHANCE = 1e-3
"""Probability that as many places chosen at random are as loud, above which harmonics are no hum."""


def mains_lines(frequency: Real, mains: float, record: float) -> NDArray[np.bool_]:
    """Lines within one and a half spacings of a harmonic of the mains.

    Parameters
    ----------
    frequency : (F,) ndarray, Hz
    mains : float
        Mains frequency, Hz.
    record : float
        Length of the record, s; its inverse is the spacing.

    Returns
    -------
    (F,) ndarray of bool

    Raises
    ------
    ValueError
        For a mains frequency that is not above 0.
    """
    if not mains > 0.0:
        raise ValueError(f"mains {mains:g} Hz: above 0 wanted")
    distance = np.abs(frequency - mains * np.round(frequency / mains))
    lines: NDArray[np.bool_] = distance < 1.5 / record
    return lines


def other_fundamentals(frequency: Real, rough: Real, excluded: NDArray[np.bool_]) -> list[float]:
    """Return fundamentals of hum above the noise whose harmonics are not all on `excluded` lines.

    They are sought in all sweeps together and in each: mains wander by some hundredths of a hertz.

    Parameters
    ----------
    frequency : (F,) ndarray
        Evenly spaced, Hz.
    rough : (T, K, F) ndarray
        Power that neighbouring lines have not in common, in units of the noise, of T sweeps and K channels.
    excluded : (F,) bool ndarray

    Returns
    -------
    list of float
        Hz, ascending.
    """
    sweeps, channels, _ = rough.shape
    power = np.concatenate([rough.mean((0, 1))[None], rough.mean(1)])
    power = power / np.maximum(np.median(power, axis=1, keepdims=True), 1e-300)
    independent = channels / (1.0 + (channels - 1) * _shared(rough))
    averaged = np.sqrt(independent * np.array([sweeps] + [1] * sweeps))
    level, few, covered = _harmonics_level(frequency, power, excluded)
    level[level <= 1.0 + np.where(few, LOUD_OF_A_GRID, LOUD_HARMONICS) / averaged[:, None]] = 0.0
    first = level.argmax(axis=1)
    found = (level.max(axis=1) > 0.0) & ~covered[first]
    return sorted({float(fundamental) for fundamental in FUNDAMENTALS[first[found]]})


def _shared(rough: Real) -> float:
    """Mean correlation between the noise powers (T, K, F) of channels; ranks are robust to the lines of a hum.

    It is 1 where all noise is that of the measured drive, which all channels are divided by.
    """
    count = rough.shape[1]
    if count == 1:
        return 0.0
    rank = rough.argsort(axis=-1).argsort(axis=-1) - 0.5 * (rough.shape[-1] - 1)
    rank /= np.linalg.norm(rank, axis=-1, keepdims=True)
    among = float((rank @ rank.swapaxes(-1, -2)).sum(axis=(1, 2)).mean())
    return float(max(among - count, 0.0) / (count * (count - 1)))


def _harmonics_level(
    frequency: Real, power: Real, excluded: NDArray[np.bool_]
) -> tuple[Real, NDArray[np.bool_], NDArray[np.bool_]]:
    """Median power (S, N) at every fundamental's harmonics; whether these are few, and all excluded, (N,) each.

    0 for fundamentals of too few harmonics within the lines.
    """
    lowest, highest = np.ceil(frequency[0] / FUNDAMENTALS), np.floor(frequency[-1] / FUNDAMENTALS)
    counts = np.maximum(highest - lowest + 1, 0).astype(int)
    few = counts < LEAST_HARMONICS
    near = np.abs(FUNDAMENTALS[:, None] - GRIDS).min(axis=1) <= WANDER
    sought = ~few | (near & (counts >= LEAST_OF_A_GRID))
    spacing = frequency[1] - frequency[0]
    level = np.zeros((len(power), FUNDAMENTALS.size))
    covered = np.zeros(FUNDAMENTALS.size, dtype=bool)
    for count in np.unique(counts[sought]):
        those = np.flatnonzero(sought & (counts == count))
        harmonics = (lowest[those, None] + np.arange(count)) * FUNDAMENTALS[those, None]
        lines = np.round((harmonics - frequency[0]) / spacing).astype(int)
        level[:, those] = np.median(power[:, lines], axis=-1)
        covered[those] = excluded[lines].all(axis=-1)
    return level, few, covered


def likely_mains(frequency: Real, h: NDArray[np.complex128]) -> float | None:
    """Find from FRFs whether mains of 50 or of 60 Hz disturb them; None where neither is clear.

    At most odd harmonics (those that transformers make) of the one, the FRF has to be `STANDS_OUT` times rougher,
    in power, than around them, and at so many that this is no chance: resonances of few lines are as rough.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz, evenly spaced.
    h : (L, F) complex ndarray
    """
    rough = np.mean([one / np.maximum(_around(one), 1e-300) for one in map(single_repeat_power, h)], axis=0)
    spacing = float(np.median(np.diff(frequency)))
    highest = np.maximum(rough, np.maximum(np.append(rough[1:], 0.0), np.append(0.0, rough[:-1])))
    share = float((highest > STANDS_OUT).mean())
    found: list[tuple[float, float]] = []
    for mains in (50.0, 60.0):
        odd = mains * np.arange(1, frequency[-1] / mains, 2)
        odd = odd[(odd > frequency[0] + 2 * spacing) & (odd < frequency[-1] - 2 * spacing)]
        if len(odd) < FEWEST_ODD or spacing > mains / 10.0:
            continue
        level = highest[np.searchsorted(frequency, odd)]
        if _chance(int((level > STANDS_OUT).sum()), len(odd), share) < CHANCE:
            found.append((float(np.median(level)), mains))
    loudest = max(found, default=(0.0, 0.0))
    return loudest[1] if loudest[0] > STANDS_OUT else None


def _chance(least: int, count: int, share: float) -> float:
    """Probability of `least` or more of `count` places, where each has the probability `share`."""
    return sum(comb(count, k) * share**k * (1.0 - share) ** (count - k) for k in range(least, count + 1))


def _around(rough: Real) -> Real:
    """Median of a power over neighbouring lines."""
    from scipy.ndimage import median_filter

    middle: Real = median_filter(rough, min(41, len(rough)), mode="nearest")
    return middle
