"""Least squares over the poles alone: residues and residual terms are eliminated.

For given poles the model is linear in everything else, so its best residues are known and the misfit
is a function of 2J numbers. Its Gauss-Newton model uses the full derivative of the projection (Golub and
Pereyra, SIAM J. Numer. Anal. 10, 1973). One triangular factor of [columns, derivative columns, data] holds
all of it: solution, misfit, gradient and Hessian come from a matrix as small as the number of columns.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk
from scipy.linalg.lapack import dpotrf, dtrtri

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import pole_columns, real_columns_with_derivatives, residues_from_columns
from analysis.identification.residual_terms import ResidualTerms

WELL_APART = 1e-4
"""Smallest sine between a column and those before it for which normal equations are good enough."""

RIDGE = 1e-10
"""Share of its length squared added to a column that is nearer to the others than that: residues of poles that the
lines cannot tell apart stay below 1e4 times what was measured; a plate's own change as little as by rounding."""


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

    Gradient and Hessian are empty, (0,) and (0, 0), where they were not asked for.
    """

    poles: NDArray[np.complex128]
    residues: NDArray[np.complex128]
    coefficients: NDArray[np.complex128]
    misfit: float
    gradient: NDArray[np.float64]
    hessian: NDArray[np.float64]
    loss: NDArray[np.float64]


def project(
    lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms, *, derivatives: bool = True
) -> Projection:
    """Eliminate residues and residual terms at given poles.

    Parameters
    ----------
    lines : Lines
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    terms : ResidualTerms
    derivatives : bool
        Whether gradient and Hessian are wanted: they take three quarters of the time.

    Returns
    -------
    Projection
    """
    count, fixed = len(poles), lines.term_columns(terms)
    linear, moving = 2 * count + len(fixed), 2 * count * derivatives
    columns, weighted = lines.room(linear + moving + len(lines.h))
    moved = slice(linear, linear + moving)
    if derivatives:
        real_columns_with_derivatives(lines.s, poles, lines.spread, columns[: 2 * count], columns[moved])
    else:
        columns[: 2 * count] = _real(pole_columns(lines.s, poles, lines.spread))
    columns[2 * count : linear] = fixed
    solved = np.zeros((lines.h.shape[0], linear))
    misfit, gradient, hessian = 0.0, np.zeros(moving), np.zeros((moving, moving))
    loss = np.zeros(count)
    chain = _chain(poles)
    for weight, rows, scales in lines.weight_groups:
        triangle, norms = _triangle(columns[: moved.stop], lines.h[rows] * scales[:, None], weight, weighted)
        r22, y = triangle[moved, moved], triangle[:, moved.stop :]
        inverse = dtrtri(triangle[:linear, :linear])[0] if linear else triangle[:0, :0]
        scaled = inverse @ y[:linear]
        misfit += float((y[linear:] ** 2).sum())
        own_inverse = inverse[: 2 * count]
        spread = own_inverse @ own_inverse.T  # of the residues, per unit of variance
        seen = r22.T @ r22  # what no residue can stand in for
        rest = r22.T @ y[moved]  # what the derivative columns still see of the data
        residues = residues_from_columns((scaled[: 2 * count] / norms[: 2 * count, None]).T)
        for k, row in enumerate(rows):
            loss += _losses(spread, scaled[:, k], count)
            solved[row] = scaled[:, k] / norms[:linear] / scales[k]
            if not derivatives:
                continue
            steps = _moves(residues[k], chain) * norms[moved, None]
            bend = _bend(rest[:, k] * norms[moved], chain) / norms[: 2 * count, None]
            hessian += steps.T @ seen @ steps + bend.T @ spread @ bend
            gradient -= steps.T @ rest[:, k]
    return Projection(
        poles=poles,
        residues=residues_from_columns(solved[:, : 2 * count]),
        coefficients=terms.coefficients(solved[:, 2 * count :], lines.scale),
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
    own = _real(pole_columns(lines.s, poles, lines.spread))
    columns = np.concatenate([own, lines.term_columns(terms)])
    misfit = 0.0
    for weight, rows, scales in lines.weight_groups:
        room = lines.room(len(columns) + len(rows))[1]
        triangle, norms = _triangle(columns, lines.h[rows] * scales[:, None], weight, room)
        misfit += float((triangle[len(norms) :, len(norms) :] ** 2).sum())
    return misfit


def change_with_poles(residues: NDArray[np.complex128], poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Change of a model by log |pole| and log damping ratio, pole by pole, in the columns of 1/(s - lambda)^2.

    Parameters
    ----------
    residues, poles : (J,) complex ndarray

    Returns
    -------
    (2J, 2J) ndarray
    """
    return _moves(residues, _chain(poles))


def _real(columns: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Real parts, then imaginary parts."""
    return np.concatenate([columns.real, columns.imag], axis=1)


def _triangle(
    columns: NDArray[np.float64],
    data: NDArray[np.complex128],
    weight: NDArray[np.float64],
    room: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Factor [columns at unit length, data], both weighted in `room`; also the columns' lengths."""
    twice = np.concatenate([weight, weight])
    stacked = room[: len(columns) + len(data)]
    np.multiply(columns, twice, out=stacked[: len(columns)])
    np.multiply(_real(data), twice, out=stacked[len(columns) :])
    gram = dsyrk(1.0, stacked.T, trans=1)  # the upper half only: half the work of a product
    lengths = np.sqrt(np.diag(gram))
    lengths[lengths == 0.0] = 1.0
    triangle = _factor(stacked, gram, lengths, len(columns))
    triangle[:, len(columns) :] *= lengths[len(columns) :]
    return triangle, lengths[: len(columns)]


def _factor(
    rows: NDArray[np.float64], gram: NDArray[np.float64], lengths: NDArray[np.float64], columns: int
) -> NDArray[np.float64]:
    """Return the upper triangular factor R of rows brought to unit length, R^T R = rows rows^T.

    Cholesky's of the Gram matrix, whose upper half is given, costs a quarter of an orthogonal one and squares the
    condition, so it is only taken where every row keeps a ten-thousandth of its length beside the ones before; the
    first `columns` get a ridge if need be.
    """
    unit = gram / lengths[:, None] / lengths
    for ridge, least in ((0.0, WELL_APART), (RIDGE, 0.5 * RIDGE**0.5)):
        unit.flat[: columns * (len(unit) + 1) : len(unit) + 1] += ridge
        factor, failed = dpotrf(unit)
        apart = np.diagonal(factor)
        if not failed and apart[:columns].min(initial=1.0) > least and apart[columns:].min() > WELL_APART:
            upper: NDArray[np.float64] = factor
            return upper
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


def _bend(rest: NDArray[np.float64], chain: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Change of own columns^T residual by every parameter: (2J, 2J)."""
    count = len(chain)
    bend = np.zeros((2 * count, 2 * count))
    rows = 2 * np.arange(count)
    even, odd = rest[0::2], rest[1::2]
    for p in (0, 1):
        d = chain[:, p]
        bend[rows, rows + p] = d.real * even + d.imag * odd
        bend[rows + 1, rows + p] = d.real * odd - d.imag * even
    return bend


def _losses(spread: NDArray[np.float64], solution: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Rise of the misfit for each pole's two columns taken out, from the covariance of the columns' factors."""
    c = solution[: 2 * count].reshape(count, 2)
    even = np.arange(0, 2 * count, 2)
    a, b, d = spread[even, even], spread[even, even + 1], spread[even + 1, even + 1]
    determinant = np.maximum(a * d - b * b, 1e-300)
    rise: NDArray[np.float64] = (d * c[:, 0] ** 2 - 2 * b * c[:, 0] * c[:, 1] + a * c[:, 1] ** 2) / determinant
    return rise
