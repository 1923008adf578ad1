"""Fall of the misfit if columns are added to a linear model and all its coefficients are refitted."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtrs

from analysis.identification.lines import Lines
from analysis.identification.normal_equations import triangular_factor
from analysis.identification.pole_residue import residues_from_columns


def pair_gains(
    lines: Lines, known: NDArray[np.complex128], pairs: NDArray[np.complex128], left: NDArray[np.complex128]
) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Fall of the misfit if one pair of columns (a pole) is added alone, with a coefficient for every response.

    Parameters
    ----------
    known : (P, F) complex ndarray
        Columns of the model.
    pairs : (2N, F) complex ndarray
        Columns multiplied by the real and the imaginary part of a complex coefficient, alternating.
    left : (K, F) complex ndarray
        Measured minus model.

    Returns
    -------
    gain : (N,) ndarray
    factor : (K, N) complex ndarray
    """
    gain = np.zeros(len(pairs) // 2)
    factor = np.zeros((len(left), len(gain)), dtype=complex)
    for group in lines.weight_groups:
        model = known.view(float) * group.weight
        fresh = np.concatenate([pairs, left[group.rows] * group.scales[:, None]]).view(float) * group.weight
        triangle, lengths = triangular_factor(model, len(model))
        onto = dtrtrs(triangle, model @ fresh.T / lengths[:, None], trans=1)[0]
        among = fresh @ fresh.T - onto.T @ onto
        for n in range(len(gain)):
            own = slice(2 * n, 2 * n + 2)
            overlap = among[own, len(pairs) :]
            solved = np.linalg.lstsq(among[own, own], overlap, rcond=1e-10)[0]
            gain[n] += (overlap * solved).sum()
            factor[group.rows, n] = residues_from_columns((solved / group.scales).T)[:, 0]
    return gain, factor
