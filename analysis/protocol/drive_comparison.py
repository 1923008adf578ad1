"""Comparison of a drive as recorded with the drive as played."""

import numpy as np
from numpy.typing import NDArray


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
