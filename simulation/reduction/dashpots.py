"""Dashpots of supports: a damping matrix R R' of low rank, added to a plate without them.

Z = Z0 + j w R R' is not diagonal in the modes of Z0. But the effect of the dashpots follows from the responses of
Z0 to the columns of R (Woodbury): Z**-1 b = Z0**-1 b - Z0**-1 R x, where x = (1 + j w R' Z0**-1 R)**-1 j w R'
Z0**-1 b are the forces of the dashpots.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix, issparse

from analysis.arrays import Complex, Real

LEAST_POWER = 1e-7
"""Smallest dissipated power of a column, as a share of the largest."""
MOST_COLUMNS = 12
"""Largest number of columns of dashpots at points, each of which is a load of the plate without dashpots."""


def columns(damping: csr_matrix | Real, answers: Real) -> Real:
    """R (n, q) with R R' x = C x for every x among the answers (n, k), C (n, n) symmetric (Nystroem).

    Directions that dissipate less than `LEAST_POWER` of the power of the strongest are left out; all responses
    have equal weight, whether to a volt or to a newton.
    """
    if not (damping.nnz if issparse(damping) else damping.any()):
        return np.zeros((len(answers), 0))
    answers = answers / np.linalg.norm(answers, axis=0)
    forces = damping @ answers
    power, directions = np.linalg.eigh(answers.T @ forces)
    kept = power > LEAST_POWER * power.max()
    return np.asarray(forces @ (directions[:, kept] / np.sqrt(power[kept])))


def few_columns(damping: csr_matrix) -> Real | None:
    """Return R (n, q) with R R' = C where q is at most `MOST_COLUMNS`; None for more, as along an edge."""
    held = np.flatnonzero(np.diff(damping.indptr))
    power, directions = np.linalg.eigh(damping[held][:, held].toarray())
    kept = power > LEAST_POWER * power.max(initial=0.0)
    if kept.sum() > MOST_COLUMNS:
        return None
    found = np.zeros((damping.shape[0], int(kept.sum())))
    found[held] = directions[:, kept] * np.sqrt(power[kept])
    return found


def forces(between: Complex, moved: Complex, frequency: ArrayLike) -> Complex:
    """Return the forces of the dashpots.

    Parameters
    ----------
    between : (q, q, F) complex ndarray
        R' Z0**-1 R.
    moved : (q, J, F) complex ndarray
        R' Z0**-1 b of J loads.
    frequency : (F,) array_like, Hz

    Returns
    -------
    (q, J, F) complex ndarray
    """
    factor = 2j * np.pi * np.asarray(frequency, float)
    system = np.moveaxis(factor * between, -1, 0) + np.eye(len(between))
    return np.asarray(np.moveaxis(np.linalg.solve(system, np.moveaxis(factor * moved, -1, 0)), 0, -1))


def connected(compliance: Complex, count: int, frequency: ArrayLike) -> Complex:
    """Add the dashpots to the compliance of a plate without them.

    Parameters
    ----------
    compliance : (I + q, J + q, F) ndarray
        Without the dashpots; the last q rows and columns are theirs.
    count : int
        q.
    frequency : (F,) array_like, Hz

    Returns
    -------
    (I, J, F) complex ndarray
    """
    if not count:
        return compliance
    x = forces(compliance[-count:, -count:], compliance[-count:, :-count], frequency)
    return np.asarray(compliance[:-count, :-count] - np.einsum("iqf,qjf->ijf", compliance[:-count, -count:], x))


def connected_derivatives(compliance: Complex, slopes: Complex, count: int, frequency: ArrayLike) -> Complex:
    """Differentiate `connected` by D parameters.

    Parameters
    ----------
    compliance : (I + q, J + q, F) ndarray
        Without the dashpots; the last q rows and columns are theirs.
    slopes : (D, I + q, J + q, F) ndarray
        Derivatives of `compliance`.
    count : int
        q.
    frequency : (F,) array_like, Hz

    Returns
    -------
    (D, I, J, F) complex ndarray
    """
    if not count:
        return slopes
    between = compliance[-count:, -count:]
    right = -forces(between, compliance[-count:, :-count], frequency)
    left = -forces(between.swapaxes(0, 1), compliance[:-count, -count:].swapaxes(0, 1), frequency)
    change = slopes[:, :-count, :-count] + np.einsum("diqf,qjf->dijf", slopes[:, :-count, -count:], right)
    over = slopes[:, -count:, :-count] + np.einsum("dpqf,qjf->dpjf", slopes[:, -count:, -count:], right)
    return np.asarray(change + np.einsum("pif,dpjf->dijf", left, over))
