"""Curves as they can be drawn: the phase of an FRF, and lines with gaps."""

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real

KNOWN_PHASE_SIGMA = 2.0
"""Standard deviations that |h| must exceed: the phase is then known to 20 degrees."""


def drawn_phase(frequency: Real, h: Complex, deviation: ArrayLike = 0.0) -> tuple[Real, Real]:
    """Return the phase as a curve with gaps where it is noise, and where it leaps between -180 and 180 degrees.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.
    h : (F,) complex ndarray
    deviation : (F,) array_like or float
        Standard deviation of h; 0 where none is known.

    Returns
    -------
    frequency, phase : (G,) ndarray
        Hz and degrees; where it leaps, a gap (NaN) is put between the two lines.
    """
    phase = np.where(np.abs(h) > KNOWN_PHASE_SIGMA * np.asarray(deviation), np.degrees(np.angle(h)), np.nan)
    leaps = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
    between = 0.5 * (frequency[leaps] + frequency[leaps - 1])
    return np.insert(frequency, leaps, between), np.insert(phase, leaps, np.nan)


def in_lines(values: Real) -> Real:
    """Return values along the first axis, of any shape, without those alone between gaps (NaN).

    No line leads to those, so that the range of a plot of lines must not reach for them: of a tracked mode they
    often belong to another mode.
    """
    known = np.isfinite(values)
    beside = np.zeros_like(known)
    beside[1:] |= known[:-1]
    beside[:-1] |= known[1:]
    return np.where(known & beside, values, np.nan)
