"""Least squares over the poles alone: residues and residual terms are eliminated.

For given poles the model is linear in everything else, so its best residues are known and the misfit
is a function of 2J numbers. Its Gauss-Newton model uses the full derivative of the projection (Golub and
Pereyra, SIAM J. Numer. Anal. 10, 1973). One triangular factor of [columns, derivative columns, data] holds
all of it: solution, misfit, gradient and Hessian come from a matrix as small as the number of columns.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky, solve_triangular
from scipy.linalg.blas import dsyrk

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import columns_with_derivatives, pole_columns, residues_from_columns
from analysis.identification.residual_terms import ResidualTerms

WELL_APART = 1e-4
"""Smallest sine between a column and those before it for which normal equations are good enough."""


@dataclass(frozen=True)
class Projection:
    """The problem at one set of poles, residues and residual terms eliminated.

    Attributes
    ----------
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray
    coefficients : (K, P) complex ndarray
        Of the residual terms.
    misfit : float
        Weighted sum of squared magnitudes, sum |h - model|^2 / deviation^2.
    gradient : (2J,) ndarray
        Half the derivative of `misfit` by log |pole| and log damping ratio, pole by pole.
    hessian : (2J, 2J) ndarray
        Jacobian transposed times Jacobian of the projected residual by the same parameters.
    loss : (J,) ndarray
        Rise of `misfit` were a pole dropped, the other poles held and all residues refitted.
    """

    poles: NDArray[np.complex128]
    residues: NDArray[np.complex128]
    coefficients: NDArray[np.complex128]
    misfit: float
    gradient: NDArray[np.float64]
    hessian: NDArray[np.float64]
    loss: NDArray[np.float64]


def project(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> Projection:
    """Eliminate residues and residual terms at given poles.

    Parameters
    ----------
    lines : Lines
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    terms : ResidualTerms

    Returns
    -------
    Projection
    """
    s, scale, count = lines.s, lines.scale, len(poles)
    own, moved = columns_with_derivatives(s, poles, lines.spread)
    columns = np.concatenate([own, terms.columns(s, scale, lines.spread)])
    linear = len(columns)
    solved = np.zeros((lines.h.shape[0], linear))
    misfit, gradient, hessian = 0.0, np.zeros(2 * count), np.zeros((2 * count, 2 * count))
    loss = np.zeros(count)
    chain = _chain(poles)
    for weight, rows, scales in lines.weight_groups:
        data = lines.h[rows] * scales[:, None]
        triangle, norms = _triangle(np.concatenate([columns, moved]), data, weight)
        r11 = triangle[:linear, :linear]
        r22, y = triangle[linear:, linear : linear + 2 * count], triangle[:, linear + 2 * count :]
        scaled = solve_triangular(r11, y[:linear])
        misfit += float((y[linear:] ** 2).sum())
        inverse = solve_triangular(r11, np.eye(linear))
        for k in range(len(rows)):
            solution = scaled[:, k]
            loss += _losses(inverse, solution, count)
            solved[rows[k]] = solution / norms[:linear] / scales[k]
            steps = _moves(residues_from_columns(solution[: 2 * count] / norms[: 2 * count]), chain)
            steps *= norms[linear:, None]
            rest = r22.T @ y[linear:, k]  # what the derivative columns still see of the data
            bend = _bend(rest * norms[linear:], chain, linear) / norms[:linear, None]
            pulled = solve_triangular(r11, bend, trans="T")
            hessian += (r22 @ steps).T @ (r22 @ steps) + pulled.T @ pulled
            gradient -= steps.T @ rest
    return Projection(
        poles=poles,
        residues=residues_from_columns(solved[:, : 2 * count]),
        coefficients=terms.coefficients(solved[:, 2 * count :], scale),
        misfit=misfit,
        gradient=gradient,
        hessian=hessian,
        loss=loss,
    )


def misfit_at(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> float:
    """Misfit of the best residues and residual terms at given poles: that of `project`, without derivatives.

    Parameters
    ----------
    lines : Lines
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    terms : ResidualTerms

    Returns
    -------
    float
        Sum of squared errors in units of the deviations.
    """
    columns = np.concatenate(
        [pole_columns(lines.s, poles, lines.spread), terms.columns(lines.s, lines.scale, lines.spread)]
    )
    misfit = 0.0
    for weight, rows, scales in lines.weight_groups:
        triangle, norms = _triangle(columns, lines.h[rows] * scales[:, None], weight)
        misfit += float((triangle[len(norms) :, len(norms) :] ** 2).sum())
    return misfit


def _triangle(
    columns: NDArray[np.complex128], data: NDArray[np.complex128], weight: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Factor [columns at unit length, data], both weighted; also the columns' lengths."""
    points = len(weight)
    stacked = np.empty((len(columns) + len(data), 2 * points))
    np.multiply(columns.real, weight, out=stacked[: len(columns), :points])
    np.multiply(columns.imag, weight, out=stacked[: len(columns), points:])
    np.multiply(data.real, weight, out=stacked[len(columns) :, :points])
    np.multiply(data.imag, weight, out=stacked[len(columns) :, points:])
    gram = dsyrk(1.0, stacked.T, trans=1)  # the upper half only: half the work of a product
    lengths = np.sqrt(np.diag(gram))
    lengths[lengths == 0.0] = 1.0
    triangle = _factor(stacked, gram, lengths)
    triangle[:, len(columns) :] *= lengths[len(columns) :]
    return triangle, lengths[: len(columns)]


def _factor(
    rows: NDArray[np.float64], gram: NDArray[np.float64], lengths: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the upper triangular factor R of rows brought to unit length, R^T R = rows rows^T.

    Cholesky's of the Gram matrix, whose upper half is given, costs a quarter of an orthogonal one and squares the
    condition, so it is only taken where every row keeps a ten-thousandth of its length beside the ones before.
    """
    try:
        factor: NDArray[np.float64] = cholesky(gram / lengths[:, None] / lengths, check_finite=False)
        if np.diag(factor).min() > WELL_APART:
            return factor
    except LinAlgError:
        pass
    factor = np.asarray(np.linalg.qr((rows / lengths[:, None]).T, mode="r"))
    short = len(rows) - len(factor)
    if short > 0:  # fewer lines than columns: pad, so that the parts can be cut out all the same
        factor = np.vstack([factor, np.zeros((short, factor.shape[1]))])
    diagonal = np.einsum("ii->i", factor)
    diagonal += np.where(np.abs(diagonal) < 1e-12, 1e-12, 0.0)
    return factor


def _chain(poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Differentiate each pole by log |pole| and log damping ratio, (J, 2)."""
    w = np.abs(poles)
    zeta = -poles.real / w
    return np.column_stack([poles, -w * (zeta + 1j * zeta**2 / np.sqrt(1.0 - zeta**2))])


def _moves(residues: NDArray[np.complex128], chain: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Change of the model by every parameter, in derivative columns: (2J, 2J)."""
    count = len(residues)
    moves = np.zeros((2 * count, 2 * count))
    rows = 2 * np.arange(count)
    for p in (0, 1):
        moved = residues * chain[:, p]
        moves[rows, rows + p] = moved.real
        moves[rows + 1, rows + p] = moved.imag
    return moves


def _bend(rest: NDArray[np.float64], chain: NDArray[np.complex128], linear: int) -> NDArray[np.float64]:
    """Change of columns^T residual by every parameter: (linear, 2J)."""
    count = len(chain)
    bend = np.zeros((linear, 2 * count))
    rows = 2 * np.arange(count)
    even, odd = rest[0::2], rest[1::2]
    for p in (0, 1):
        d = chain[:, p]
        bend[rows, rows + p] = d.real * even + d.imag * odd
        bend[rows + 1, rows + p] = d.real * odd - d.imag * even
    return bend


def _losses(inverse: NDArray[np.float64], solution: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Rise of the misfit for each pole's two columns taken out, from the inverse triangular factor."""
    rows = inverse[: 2 * count].reshape(count, 2, inverse.shape[1])
    block = np.einsum("jan,jbn->jab", rows, rows)
    c = solution[: 2 * count].reshape(count, 2)
    a, b, d = block[:, 0, 0], block[:, 0, 1], block[:, 1, 1]
    determinant = np.maximum(a * d - b * b, 1e-300)
    rise: NDArray[np.float64] = (d * c[:, 0] ** 2 - 2 * b * c[:, 0] * c[:, 1] + a * c[:, 1] ** 2) / determinant
    return rise
