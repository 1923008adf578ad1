"""Lines of an FRF disturbed by mains hum or other tones."""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import roughness
from analysis.identification.running_median import running_median

HUM_SIGMA = 5.0
"""How far a line must lie from the model, in local standard deviations, to count as mains hum."""

GRIDS = (50.0, 60.0)
"""Mains frequencies in use, Hz: if the wrong one was stated, harmonics of the other appear."""

HARMONIC_DISTANCE = 5e-3
"""Largest relative distance of a narrow pole from its mains harmonic: the mains frequency drifts."""

TONE_HALF_WIDTH = 0.5
"""Half width in lines up to which a pole may be a tone: such a resonance would ring longer than the record."""

TONE_HEIGHT = 10.0
"""Height of a line above its neighbours, over their own difference, that no resonance reaches."""


def harmonic_of(frequency: float, mains: float, spacing: float) -> tuple[int, float] | None:
    """Return the mains harmonic that a narrow pole may be; harmonics of `mains` are tried first.

    Parameters
    ----------
    frequency : float
        Of the narrow pole, Hz.
    mains : float
        Mains frequency, Hz.
    spacing : float
        Of the lines, Hz.

    Returns
    -------
    (int, float) or None
        Number of the harmonic and its fundamental, Hz; None where there is none within a line.
    """
    for fundamental in dict.fromkeys((mains, *GRIDS)):
        number = max(round(frequency / fundamental), 1)
        if abs(frequency - number * fundamental) <= max(spacing, HARMONIC_DISTANCE * frequency):
            return number, fundamental
    return None


def needle_hum(
    pole: complex, mains: float, spacing: float, around: float | None = None
) -> tuple[int, float] | None:
    """Mains harmonic that a pole represents.

    Parameters
    ----------
    pole : complex
        rad/s.
    mains : float
        Mains frequency, Hz.
    spacing : float
        Of the lines, Hz.
    around : float, optional
        Of uneven lines near the pole, Hz: its width counts in these, but hum is where the mains is, however far
        apart the lines of a stepped sine are.

    Returns
    -------
    (int, float) or None
        As `harmonic_of` gives it; None where the pole is wider than a line.
    """
    frequency, width = pole.imag / (2.0 * np.pi), -pole.real / (2.0 * np.pi)
    return harmonic_of(frequency, mains, spacing) if width <= TONE_HALF_WIDTH * (around or spacing) else None


def harmonic_lines(
    frequency: NDArray[np.float64], left: NDArray[np.complex128], spacing: float, mains: float
) -> NDArray[np.bool_]:
    """Find the lines within one spacing of a mains harmonic that stand out of a fit's residual.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.
    left : (K, F) complex ndarray
        Measured minus model.
    spacing : float
        Of the lines, Hz.
    mains : float
        Hz; harmonics of the other mains frequency in `GRIDS` are searched as well.

    Returns
    -------
    (F,) bool ndarray
    """
    size = np.abs(left)
    window = min(101, left.shape[1])
    usual = running_median(size, window, "nearest") / np.sqrt(np.log(2.0))
    near = np.zeros(len(frequency), dtype=bool)
    for fundamental in {mains, *GRIDS}:
        number = np.maximum(np.round(frequency / fundamental), 1.0)
        near |= np.abs(frequency - fundamental * number) <= 1.001 * spacing
    spoilt: NDArray[np.bool_] = near & (size > HUM_SIGMA * np.maximum(usual, np.finfo(float).tiny)).any(axis=0)
    return spoilt


def tones(h: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Find single lines that no resonance could make: (F,) bool ndarray.

    The peak of a resonance as narrow as the search allows (a tenth of a line) is five times the difference of its
    two neighbours; a tone that is not part of the response appears on one line alone.

    Parameters
    ----------
    h : (K, F) complex ndarray
        As measured, evenly spaced.
    """
    alone = np.zeros(h.shape, dtype=bool)
    if h.shape[1] >= 32:
        height = np.abs(h[:, 1:-1] - 0.5 * (h[:, :-2] + h[:, 2:]))
        beside = np.maximum(np.abs(h[:, 2:] - h[:, :-2]), roughness(h)[:, 1:-1])
        alone[:, 1:-1] = height > TONE_HEIGHT * beside
    found: NDArray[np.bool_] = np.asarray(alone.any(axis=0))
    return found
