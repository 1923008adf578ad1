"""Fall of the misfit if columns are added to a linear model and all its coefficients are refitted."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtrs

from analysis.identification.normal_equations import triangular_factor
from analysis.identification.pole_residue import residues_from_columns


def pair_gains(
    known: NDArray[np.complex128],
    pairs: NDArray[np.complex128],
    left: NDArray[np.complex128],
    deviation: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Fall of the misfit if one pair of columns (a pole) is added alone, with a coefficient for every response.

    Parameters
    ----------
    known : (P, F) complex ndarray
        Columns of the model.
    pairs : (2N, F) complex ndarray
        Columns multiplied by the real and the imaginary part of a complex coefficient, alternating.
    left, deviation : (K, F) ndarray
        Measured minus model, and the standard deviation of every line.

    Returns
    -------
    gain : (N,) ndarray
    factor : (K, N) complex ndarray
    """
    gain = np.zeros(len(pairs) // 2)
    factor = np.zeros((len(left), len(gain)), dtype=complex)
    for k, (row, sigma) in enumerate(zip(left, deviation, strict=True)):
        weight = np.repeat(1.0 / sigma, 2)
        model = known.view(float) * weight
        fresh = np.concatenate([pairs, row[None]]).view(float) * weight
        triangle, lengths = triangular_factor(model, len(model))
        onto = dtrtrs(triangle, model @ fresh.T / lengths[:, None], trans=1)[0]
        among = fresh @ fresh.T - onto.T @ onto
        for n in range(len(gain)):
            own = slice(2 * n, 2 * n + 2)
            overlap = among[own, -1]
            solved = np.linalg.lstsq(among[own, own], overlap, rcond=1e-10)[0]
            gain[n] += overlap @ solved
            factor[k, n] = residues_from_columns(solved)[0]
    return gain, factor
