"""One pole that stands for two: which one, and how far apart they are.

Poles at lambda + d and lambda - d with a residue R in all differ from one between them by R d^2/(s - lambda)^3 and
higher powers; a term in 1/(s - lambda)^2 has moved the one already. What the residual has of such a term tells d,
complex, so that the search starts at the separation and the orientation that the data ask for.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.added_columns import pair_gains
from analysis.identification.bic import bic, misfit_worth
from analysis.identification.lines import Lines
from analysis.identification.missing import residual
from analysis.identification.order import attempt
from analysis.identification.pole_residue import fill_columns, paired
from analysis.identification.pole_search import PATIENCE, PoleFit

FARTHEST = 0.5
"""Half widths from a pole to either of the two at most: farther ones have two peaks."""

TRIED = 4
"""Poles that are tried, the one that promises most first."""


def split(lines: Lines, fitted: PoleFit) -> PoleFit | None:
    """Put two poles in the place of one that gains much by it.

    Parameters
    ----------
    lines : Lines
    fitted : PoleFit
        About as good as its number of poles lets it be.

    Returns
    -------
    PoleFit or None
        None where BIC does not fall.
    """
    gain, apart = _thirds(lines, fitted)
    if lines.damping is not None:  # two of the others' damping look like one of more
        gain = gain + 0.5 * lines.correlation * lines.damping.departure(fitted.poles)[0]
    level, now = bic(fitted, lines), fitted.projection
    target = misfit_worth(lines, level, fitted.parameters + 2 + 2 * len(lines.h))
    for j in np.argsort(-gain)[:TRIED]:
        if now.misfit - PATIENCE * gain[j] > target:
            break
        pole, half_width = fitted.poles[j], -fitted.poles[j].real
        d = np.sqrt(apart[j])
        d *= min(1.0, FARTHEST * half_width / abs(d))
        two = attempt(lines, np.append(np.delete(fitted.poles, j), [pole + d, pole - d]), fitted.terms, level)
        if two is not None:
            return two
    return None


def _thirds(lines: Lines, fitted: PoleFit) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Fall of the misfit with a term in 1/(s - lambda)^3 for each pole, and the d^2 that it tells, (J,) each."""
    poles, residues, count = fitted.poles, fitted.projection.residues, len(fitted.poles)
    known = np.empty((4 * count, len(lines.s)), dtype=complex)
    fill_columns(lines.s, poles, lines.spread, known[: 2 * count], known[2 * count :])
    known = np.concatenate([known, lines.term_columns(fitted.terms)])
    inverse = 1.0 / (lines.s - np.concatenate([poles, poles.conj()])[:, None])
    cubed = inverse**3
    if lines.spread is not None:
        cubed -= 6.0 * lines.spread * inverse**5
    new = np.empty((2 * count, len(lines.s)), dtype=complex)
    paired(cubed, new)
    gain, factor = pair_gains(known, new, residual(lines, fitted), lines.deviation)
    return gain, (residues.conj() * factor).sum(axis=0) / (np.abs(residues) ** 2).sum(axis=0)
