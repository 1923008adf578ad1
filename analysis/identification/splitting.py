"""Replacement of one pole by two close ones: which pole, and how far apart the two start.

Poles at lambda + d and lambda - d with total residue R differ from one pole between them by R d^2/(s - lambda)^3
and higher powers; a term in 1/(s - lambda)^2 only moves the one pole. The coefficient of 1/(s - lambda)^3 in the
residual gives the complex d, so that the search starts with the separation and orientation estimated from the
data.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.added_columns import pair_gains
from analysis.identification.bic import bic, misfit_worth
from analysis.identification.lines import Lines
from analysis.identification.missing import residual
from analysis.identification.order import attempt
from analysis.identification.pole_residue import fill_columns, paired
from analysis.identification.pole_search import PREDICTED_FALL_FACTOR, PoleFit

LARGEST_SPLIT = 0.5
"""Largest distance from a pole to either of the two, in half widths: with a larger one there are two peaks."""

POLES_TRIED = 4
"""Number of poles that are tried, in order of predicted gain."""


def split(lines: Lines, fitted: PoleFit) -> PoleFit | None:
    """Replace a pole by two close ones where BIC falls most.

    Parameters
    ----------
    fitted : PoleFit
        Converged for its number of poles.

    Returns
    -------
    PoleFit or None
        None where BIC does not fall.
    """
    gain, apart = _thirds(lines, fitted)
    if lines.damping is not None:  # two close modes of usual damping look like one with more
        gain = gain + 0.5 * lines.redundancy * lines.damping.departure(fitted.poles)[0]
    level, now = bic(fitted, lines), fitted.projection
    target = misfit_worth(lines, level, len(fitted.poles) + 1, fitted.terms)
    for j in np.argsort(-gain)[:POLES_TRIED]:
        if now.misfit - PREDICTED_FALL_FACTOR * gain[j] > target:
            break
        pole, half_width = fitted.poles[j], -fitted.poles[j].real
        d = np.sqrt(apart[j])
        d *= min(1.0, LARGEST_SPLIT * half_width / abs(d))
        two = attempt(lines, np.append(np.delete(fitted.poles, j), [pole + d, pole - d]), fitted.terms, level)
        if two is not None:
            return two
    return None


def _thirds(lines: Lines, fitted: PoleFit) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Fall of the misfit with a term in 1/(s - lambda)^3 for each pole, and the d^2 from it, (J,) each."""
    poles, residues, count = fitted.poles, fitted.projection.residues, len(fitted.poles)
    known = np.empty((4 * count, len(lines.s)), dtype=complex)
    fill_columns(lines.s, poles, known[: 2 * count], known[2 * count :])
    known = np.concatenate([known, lines.term_columns(fitted.terms)])
    inverse = 1.0 / (lines.s - np.concatenate([poles, poles.conj()])[:, None])
    new = np.empty((2 * count, len(lines.s)), dtype=complex)
    paired(inverse**3, new)
    gain, factor = pair_gains(lines, known, new, residual(lines, fitted))
    return gain, (residues.conj() * factor).sum(axis=0) / (np.abs(residues) ** 2).sum(axis=0)
