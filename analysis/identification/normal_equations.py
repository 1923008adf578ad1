"""Triangular factor of a weighted least-squares problem."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dpotrf

WELL_APART = 1e-4
"""Smallest sine between a column and those before it for which normal equations are good enough."""

RIDGE = 1e-10
"""Ridge on columns nearer to the others than that, relative to their squared length: residues of poles that the
lines cannot separate stay below 1e4 times the data; others change by no more than rounding."""


def triangular_factor(rows: NDArray[np.float64], columns: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Factor [columns at unit length, data].

    Parameters
    ----------
    rows : (N, 2F) ndarray
        Columns of the problem and data after them, weighted.
    columns : int
        Number of columns; the other rows are data.

    Returns
    -------
    triangle : (N, N) ndarray
        Upper triangular R, R^T R = rows rows^T, the columns divided by their lengths.
    lengths : (columns,) ndarray
    """
    return factor_of_gram(rows @ rows.T, columns, lambda: rows)


def factor_of_gram(
    gram: NDArray[np.float64], columns: int, rows: Callable[[], NDArray[np.float64]]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what `triangular_factor` does, from the inner products of the rows.

    A Cholesky factor of the Gram matrix costs a quarter of an orthogonal one but squares the condition number. So
    it is used only where every row has a component of a ten-thousandth of its length orthogonal to those before
    it; if need be, a ridge is added to the columns.

    Parameters
    ----------
    gram : (N, N) ndarray
        Lower triangle of rows rows^T; changed.
    columns : int
        Number of columns; the other rows are data.
    rows : callable
        Returns the rows (N, 2F), for an orthogonal factor.

    Returns
    -------
    triangle : (N, N) ndarray
    lengths : (columns,) ndarray
    """
    lengths = np.sqrt(np.diagonal(gram))
    lengths[lengths == 0.0] = 1.0
    needed = np.full(len(gram), WELL_APART)
    for ridge, least in ((0.0, WELL_APART), (RIDGE, 0.5 * RIDGE**0.5)):
        gram.flat[: columns * (len(gram) + 1) : len(gram) + 1] += ridge * lengths[:columns] ** 2
        triangle, failed = dpotrf(gram.T, lower=0)
        needed[:columns] = least
        if not failed and (np.diagonal(triangle) > needed * lengths).all():
            triangle[:, :columns] /= lengths[:columns]
            return triangle, lengths[:columns]
    return _orthogonal(rows(), lengths, columns), lengths[:columns]


def _orthogonal(rows: NDArray[np.float64], lengths: NDArray[np.float64], columns: int) -> NDArray[np.float64]:
    """Return the triangle of an orthogonal factor."""
    factor = np.asarray(np.linalg.qr((rows / lengths[:, None]).T, mode="r"))
    short = len(rows) - len(factor)
    if short > 0:  # fewer lines than columns: pad, so that the factor has its usual shape
        factor = np.vstack([factor, np.zeros((short, factor.shape[1]))])
    diagonal = np.einsum("ii->i", factor)
    diagonal += np.where(np.abs(diagonal) < 1e-12, 1e-12, 0.0)
    factor[:, columns:] *= lengths[columns:]
    return factor
