"""Poles of a lightly coupled complex symmetric matrix, in half the time of a general eigensolver.

Losses couple the real modes of a plate weakly. Their vectors are corrected as in Ogita and Aishima, Iterative
refinement for symmetric eigenvalue decomposition (Japan Journal of Industrial and Applied Mathematics 35, 2018),
with transposes in place of adjoints: quadratic convergence, and matrix products only.
"""

import numpy as np

from analysis.arrays import Complex, Real

CONVERGED_CORRECTION = 1e-6
"""Largest correction whose square, the next one, is left out."""
COUPLING_ROUNDING = 1e-15
"""Largest coupling of real modes, over the largest element, that is taken for rounding."""
MOST_CORRECTIONS = 8
"""Number of corrections after which poles count as too close."""


def symmetric_poles(matrix: Complex) -> tuple[Complex, Complex] | None:
    """Eigenvalues (r,) of a complex symmetric (r, r) matrix, and eigenvectors whose transpose is their inverse.

    None if eigenvalues are closer than the coupling of their modes, so that corrections do not converge.
    """
    coupled, modes = _in_real_modes(0.5 * (matrix + matrix.T))
    own = np.arange(len(coupled))
    poles = coupled[own, own]
    with np.errstate(all="ignore"):  # coinciding poles are detected by the size of the correction
        first = coupled / _gaps(poles)
        first[own, own] = 0.0
        first *= 2.0 / (1.0 + np.sqrt(1.0 + 4.0 * first * first))  # each pair rotated by its own angle
        vectors = first + 0.5 * (first @ first)
        vectors[own, own] += 1.0
        for _ in range(MOST_CORRECTIONS):
            product, gram = vectors.T @ (coupled @ vectors), vectors.T @ vectors
            poles = product[own, own] / gram[own, own]
            product = 0.5 * (product + product.T)  # removes the asymmetry by rounding
            correction = (product - poles * gram) / _gaps(poles)
            correction[own, own] = 0.5 * (1.0 - gram[own, own])
            vectors += vectors @ correction
            largest = float(np.abs(correction).max())
            if largest < CONVERGED_CORRECTION:
                return poles, vectors if modes is None else modes @ vectors
            if not largest < 1.0:
                return None
    return None


def _in_real_modes(matrix: Complex) -> tuple[Complex, Real | None]:
    """Matrix (r, r) in the modes (r, r) of its real part; None for modes where that is diagonal already."""
    size = np.abs(matrix.real)
    largest = size.max(initial=0.0)
    np.fill_diagonal(size, 0.0)
    if size.max(initial=0.0) <= COUPLING_ROUNDING * largest:
        return matrix, None
    modes = np.linalg.eigh(matrix.real)[1]
    return modes.T @ matrix @ modes, modes


def _gaps(poles: Complex) -> Complex:
    """Pole of the column less that of the row, 1 on the diagonal."""
    gaps = poles - poles[:, None]
    np.fill_diagonal(gaps, 1.0)
    return np.asarray(gaps)
