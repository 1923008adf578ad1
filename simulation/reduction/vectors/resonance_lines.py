"""Frequencies for the comparison of a plate's responses: an even grid, and lines on every narrow resonance.

At a loss factor of 1e-3 a resonance at 500 Hz is half a hertz wide: an even grid of a few hundred lines does not
resolve it.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real

NARROW_WIDTH = 2.0
"""Resonances with a half-power width below this many steps of the even grid get lines of their own."""


def resonance_lines(natural: Real, loss_factor: float, grid: Real) -> Real:
    """Lines over a band: those of an even grid, and more around narrow resonances.

    Parameters
    ----------
    natural : (r,) ndarray
        Natural frequencies, Hz; those outside the band are left out.
    loss_factor : float
        Of every mode: the half-power width is loss_factor times the natural frequency.
    grid : (G,) ndarray
        Even lines from one end of the band to the other, Hz.

    Returns
    -------
    (F,) ndarray, Hz
        Ascending.
    """
    step = grid[1] - grid[0]
    inside = natural[(natural > grid[0]) & (natural < grid[-1])]
    narrow = inside[loss_factor * inside < NARROW_WIDTH * step]
    if not narrow.size:
        return grid
    lines = [grid]
    for center in narrow:
        width = loss_factor * center
        doublings = max(int(np.ceil(np.log2(step / width))), 0) + 2
        offsets = 0.5 * width * 2.0 ** np.arange(doublings)
        lines.append(center + np.concatenate([-offsets[::-1], [0.0], offsets]))
    joined = np.unique(np.concatenate(lines))
    return np.asarray(joined[(joined >= grid[0]) & (joined <= grid[-1])])


def root_mean_square(values: NDArray[np.complex128], lines: Real) -> Real:
    """Rms of values (..., F) over the band that uneven lines (F,) span, trapezoidal: (...)."""
    power = np.trapezoid(np.abs(values) ** 2, lines, axis=-1) / (lines[-1] - lines[0])
    return np.asarray(np.sqrt(power))
