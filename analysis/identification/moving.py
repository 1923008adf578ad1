"""Pairs of poles that represent one mode whose frequency differs between FRFs measured one after the other.

A structure that warms up, dries or is touched between the hits of a roving hammer has another frequency in every
FRF. To the first order two poles describe that, with another share of either in every FRF. So does a pole of its
own in every FRF, with four parameters fewer. At the second order the two differ, and the likelihood decides.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import synthesis
from analysis.identification.pole_search import fit
from analysis.identification.residual_terms import COMPLEX_E_F_G, NONE
from analysis.identification.variable_projection import project
from analysis.shapes.assurance import mpc

VERY_STRONG = 10.0
"""Twice the log of the likelihood ratio from which evidence is "very strong" (Kass and Raftery, J. Am. Stat.
Assoc. 90, 1995)."""

IN_PHASE, OUT_OF_PHASE = 0.95, 0.9
"""Where evidence is weaker, modal phase collinearity that the sum of the two residues has at least, and that of
one of the two at most, in one mode: only together are they a shape. A beam hit at nine places gives 0.98 and 0.80;
its other modes over 0.98."""

WINDOW = 10.0
"""Lines compared, in half widths on either side: beyond, both models are the same."""

FEWEST = 24
"""Lines compared at least."""

STEPS = 8
"""Most steps of the search for the pole of one FRF, which starts between the two."""


def one_that_moves(
    lines: Lines, poles: NDArray[np.complex128], residues: NDArray[np.complex128], pair: tuple[int, int]
) -> bool:
    """Whether two close poles represent one mode with a pole of its own in every FRF.

    Parameters
    ----------
    lines : Lines
        K FRFs.
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray
    pair : tuple of int
        The two poles in question.

    Returns
    -------
    bool
    """
    if len(residues) < 2:
        return False
    evidence = _evidence_for_two(lines, poles, residues, pair)
    if abs(evidence) > VERY_STRONG or len(residues) < 3:  # a shape has three places at least
        return evidence < -VERY_STRONG
    each = residues[:, list(pair)]
    together, *alone = mpc(np.column_stack([each.sum(axis=1), each]).T)
    return bool(together > IN_PHASE and min(alone) < OUT_OF_PHASE)


def _evidence_for_two(
    lines: Lines, poles: NDArray[np.complex128], residues: NDArray[np.complex128], pair: tuple[int, int]
) -> float:
    """Twice the log of the likelihood ratio of two poles that all FRFs share over one of its own in every FRF."""
    two = poles[list(pair)]
    away = np.abs(2.0 * np.pi * lines.frequency - two.imag.mean())
    near = away <= max(WINDOW * -two.real.mean(), np.sort(away)[min(FEWEST, len(away)) - 1])
    f, others = lines.frequency[near], np.delete(np.arange(len(poles)), pair)
    none = np.zeros((len(residues), 0), complex)
    h = lines.h[:, near] - synthesis(f, poles[others], residues[:, others], NONE, none)
    shared = own = 0.0
    for row, deviation in zip(h, lines.deviation[:, near], strict=True):
        one = Lines(f, row[None], deviation[None])
        shared += project(one, two, COMPLEX_E_F_G, derivatives=False).misfit
        own += fit(one, two.mean()[None], COMPLEX_E_F_G, max_iterations=STEPS, tolerance=1e-4).projection.misfit
    return float(2 * h.size / lines.redundancy * np.log(own / max(shared, np.finfo(float).tiny)))
