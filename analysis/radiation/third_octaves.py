"""Third-octave bands (IEC 61260-1, base ten) and the level of a response in each."""

import numpy as np

from analysis.arrays import Complex, Real

FEWEST_LINES = 3
"""Lines in a band, for which its mean is taken."""


def third_octaves(frequency: Real) -> tuple[Real, Real]:
    """Bands whose middle lies within a set of lines.

    Parameters
    ----------
    frequency : (F,) ndarray, Hz
        Ascending.

    Returns
    -------
    middle : (B,) ndarray, Hz
    member : (B, F) ndarray of bool
        Which lines each band has, at least three.
    """
    first, last = np.ceil(10.0 * np.log10(frequency[0])), np.floor(10.0 * np.log10(frequency[-1]))
    middle = 10.0 ** (np.arange(first, last + 1.0) / 10.0)
    half = 10.0**0.05
    member = (frequency >= middle[:, None] / half) & (frequency < middle[:, None] * half)
    held = member.sum(axis=1) >= FEWEST_LINES
    return middle[held], member[held]


def third_octave_levels(response: Complex, frequency: Real) -> Real:
    """Level of a response in third-octave bands.

    Parameters
    ----------
    response : (..., F) ndarray
        Relative to what is wanted.
    frequency : (F,) ndarray, Hz

    Returns
    -------
    (..., B) ndarray
        dB of the mean square over the lines of each band.
    """
    _, member = third_octaves(frequency)
    squares = np.abs(response) ** 2 @ (member / member.sum(axis=1, keepdims=True)).T
    return np.asarray(10.0 * np.log10(np.maximum(squares, 1e-20)))


def ripple(response: Complex, frequency: Real) -> Real:
    """Ripple (...), ± dB: half the difference of the loudest and the softest third-octave band."""
    return np.asarray(0.5 * np.ptp(third_octave_levels(response, frequency), axis=-1))
