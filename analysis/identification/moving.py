"""Pairs of poles that represent one mode whose frequency differs between FRFs measured one after the other.

A structure that warms up, dries or is touched between the hits of a roving hammer has another frequency in every
FRF. To the first order two poles describe that, with another share of either in every FRF. So does a pole of its
own in every FRF, with four parameters fewer. At the second order the two differ.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import synthesis
from analysis.identification.pole_search import fit
from analysis.identification.residual_terms import COMPLEX_E_F_G, NONE
from analysis.identification.variable_projection import project

WINDOW = 10.0
"""Lines compared, in half widths on either side: beyond, both models are the same."""

FEWEST = 24
"""Lines compared at least."""

MOST = 12
"""FRFs compared, those that show the poles best: the others tell little and take as long."""

STEPS = 8
"""Most steps of the search for the pole of one FRF, which starts between the two."""


def one_that_moves(
    lines: Lines, poles: NDArray[np.complex128], residues: NDArray[np.complex128], group: NDArray[np.intp]
) -> bool:
    """Whether close poles represent one mode with a pole of its own in every FRF: whether that has the lower BIC.

    Parameters
    ----------
    lines : Lines
        K FRFs.
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray
    group : (M,) ndarray of int
        The poles in question.

    Returns
    -------
    bool
    """
    count = len(residues)
    if count < 2 or lines.together:
        return False
    shared_poles = poles[group]
    away = np.abs(2.0 * np.pi * lines.frequency - shared_poles.imag.mean())
    near = away <= max(WINDOW * -shared_poles.real.mean(), np.sort(away)[min(FEWEST, len(away)) - 1])
    f, others = lines.frequency[near], np.delete(np.arange(len(poles)), group)
    none = np.zeros((count, 0), complex)
    h = lines.h[:, near] - synthesis(f, poles[others], residues[:, others], NONE, none)
    signal = (np.abs(residues[:, group]).sum(axis=1)[:, None] / lines.deviation[:, near]).mean(axis=1)
    strongest = np.argsort(signal)[::-1][:MOST]
    h, count = h[strongest], len(strongest)
    shared = own = 0.0
    for row, deviation in zip(h, lines.deviation[strongest][:, near], strict=True):
        one = Lines(f, row[None], deviation[None])
        start = shared_poles.mean()[None]
        shared += project(one, shared_poles, COMPLEX_E_F_G, derivatives=False).misfit
        own += fit(one, start, COMPLEX_E_F_G, max_iterations=STEPS, tolerance=1e-4).projection.misfit
    independent = 2 * h.size / lines.redundancy
    parameters = 2 * len(group) * (1 + count) - 4 * count  # with shared poles minus with a pole in every FRF
    least = np.finfo(float).tiny
    rise = independent * np.log(max(own, least) / max(shared, least))
    return bool(rise < parameters * np.log(independent))
