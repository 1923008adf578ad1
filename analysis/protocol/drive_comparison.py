"""Comparison of a drive as recorded with the drive as played: delay, deviation, and the clocks of both.

Two crystals differ by a constant share, some ten millionths, and a sweep of a minute is then some hundred samples
shorter or longer than it was asked for. That harms no result: drive and responses are recorded by the same clock.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.protocol.sweep import SweepSettings, drive_signal


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
