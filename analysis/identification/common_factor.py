"""The factor by which a change of temperature moves all frequencies."""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.variable_projection import misfit_at

WIDEST_STEP = 0.12
"""Range of the first scan: largest shift of log frequency from one sweep to the next."""

WIDE_MISFIT = 0.1
"""Unexplained share of the FRF's energy at the best factor above which a wider scan is made."""


def common_factor(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> tuple[float, bool]:
    """Find the common factor on all poles that explains the FRFs best.

    A scan in steps of half the median half width, no coarser than 0.5 %, then a parabola through the lowest three;
    three times as wide where the lowest is at the edge or leaves a large residual.

    Parameters
    ----------
    poles : (J,) complex ndarray
        Upper half plane, rad/s.

    Returns
    -------
    factor : float
    edge : bool
        Whether the lowest misfit is at the edge of the scan.
    """
    zeta = float(np.median(-poles.real / np.abs(poles))) if len(poles) else 0.01
    step = min(max(0.5 * zeta, 1e-3), 5e-3)
    energy = float((np.abs(lines.h / lines.deviation) ** 2).sum())
    grid, misfit = _scan(lines, poles, terms, WIDEST_STEP, step)
    if not 0 < np.argmin(misfit) < len(grid) - 1 or misfit.min() > WIDE_MISFIT * energy:
        grid, misfit = _scan(lines, poles, terms, 3.0 * WIDEST_STEP, step)
    lowest = int(np.argmin(misfit))
    if not 0 < lowest < len(grid) - 1:
        return float(np.exp(grid[lowest])), True
    left, middle, right = misfit[lowest - 1 : lowest + 2]
    bend = left - 2.0 * middle + right
    offset = 0.5 * (left - right) / bend if bend > 0.0 else 0.0
    return float(np.exp(grid[lowest] + step * offset)), False


def _scan(
    lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms, widest: float, step: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shifts of log frequency to either side, and the misfit at each."""
    grid = step * np.arange(-np.ceil(widest / step), np.ceil(widest / step) + 1)
    return grid, np.array([misfit_at(lines, poles * np.exp(g), terms) for g in grid])
