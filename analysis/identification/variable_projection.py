"""Variable projection: least squares over the poles, with residues and residual terms eliminated.

For given poles the model is linear in everything else, so its best residues are known and the misfit
is a function of 2J numbers. Its Gauss-Newton model uses the full derivative of the projection (Golub and
Pereyra, SIAM J. Numer. Anal. 10, 1973). Solution, misfit, gradient and Hessian all come from one triangular factor
of [columns, derivative columns, data], a matrix as small as the number of columns.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtri

from analysis.identification.damping_prior import DampingPrior
from analysis.identification.lines import Lines
from analysis.identification.normal_equations import factor_of_gram
from analysis.identification.pole_residue import residues_from_columns
from analysis.identification.residual_terms import ResidualTerms


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
        Half the derivative of `misfit` with respect to log |pole| and log damping ratio, pole by pole.
    hessian : (2J, 2J) ndarray
        Jacobian transposed times Jacobian of the projected residual with respect to the same parameters.
    loss : (J,) ndarray
        Rise of `misfit` if a pole is dropped, with the other poles held and all residues refitted.

    Gradient and Hessian are empty, (0,) and (0, 0), if `project` was called without derivatives.
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
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    derivatives : bool
        Whether gradient and Hessian are computed, which takes three quarters of the time.
    """
    count = len(poles)
    linear, moving = 2 * count + terms.parameters, 2 * count * derivatives
    moved = slice(linear, linear + moving)  # the derivative columns
    solved = np.zeros((lines.h.shape[0], linear))
    misfit, gradient, hessian = 0.0, np.zeros(moving), np.zeros((moving, moving))
    loss = np.zeros(count)
    chain = _chain(poles)
    for group, weighted in zip(lines.weight_groups, lines.weighted(terms), strict=True):
        triangle, norms = factor_of_gram(
            weighted.at(poles, derivatives=derivatives).gram(terms.parameters),
            moved.stop,
            partial(weighted.line_by_line, poles, terms.parameters, derivatives=derivatives),
        )
        r22, y = triangle[moved, moved], triangle[:, moved.stop :]
        inverse = dtrtri(triangle[:linear, :linear])[0] if linear else triangle[:0, :0]
        scaled = inverse @ y[:linear]
        misfit += float((y[linear:] ** 2).sum())
        own = np.ascontiguousarray(inverse[: 2 * count]).reshape(count, 2, linear)
        spread = own @ own.swapaxes(1, 2)  # of each pole's residue, per unit of variance
        rest = r22.T @ y[moved]  # products of the derivative columns with the data
        residues = residues_from_columns((scaled[: 2 * count] / norms[: 2 * count, None]).T)
        for k, row in enumerate(group.rows):
            loss += _losses(spread, scaled[:, k])
            solved[row] = scaled[:, k] / norms[:linear] / group.scales[k]
            if not derivatives:
                continue
            moves = _moves(residues[k], chain) * norms[moved].reshape(count, 2, 1)
            bend = _bend(rest[:, k] * norms[moved], chain) / norms[: 2 * count].reshape(count, 2, 1)
            seen = (moves.swapaxes(1, 2) @ r22.T.reshape(count, 2, moving)).reshape(moving, moving)
            turned = (bend.swapaxes(1, 2) @ own).reshape(moving, linear)
            hessian += seen @ seen.T + turned @ turned.T
            gradient -= seen @ y[moved, k]
    if lines.damping is not None:
        misfit += _add_damping_prior(lines.damping, poles, 0.5 * lines.redundancy, gradient, hessian)
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
    poles : (J,) complex ndarray
        Upper half plane, rad/s.

    Returns
    -------
    float
        Sum of squared errors in units of the deviations.
    """
    return project(lines, poles, terms, derivatives=False).misfit


def change_with_poles(residues: NDArray[np.complex128], poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Differentiate a model by log |pole| and log damping ratio, in the columns of 1/(s - lambda)^2.

    Parameters
    ----------
    residues, poles : (J,) complex ndarray

    Returns
    -------
    (J, 2, 2) ndarray
        For each pole: coefficients of its two columns by its two parameters.
    """
    return _moves(residues, _chain(poles))


def _add_damping_prior(
    prior: DampingPrior,
    poles: NDArray[np.complex128],
    variance: float,
    gradient: NDArray[np.float64],
    hessian: NDArray[np.float64],
) -> float:
    """Return what the prior adds to the misfit; add to gradient and Hessian, in place, unless they are empty.

    `variance` is that of one number.
    """
    value, slope, bend = prior.departure(poles)
    if gradient.size:
        gradient[1::2] += variance * slope
        hessian[np.diag_indices(len(gradient))] += variance * np.repeat(bend, 2) * np.tile([0.0, 1.0], len(poles))
    return variance * float(value.sum())


def _chain(poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Differentiate each pole by log |pole| and log damping ratio, (J, 2)."""
    w = np.abs(poles)
    zeta = -poles.real / w
    return np.column_stack([poles, -w * (zeta + 1j * zeta**2 / np.sqrt(1.0 - zeta**2))])


def _moves(residues: NDArray[np.complex128], chain: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Change of the model by a pole's two parameters, in its two derivative columns: (J, 2, 2)."""
    moved = residues[:, None] * chain
    return np.stack([moved.real, moved.imag], axis=1)


def _bend(rest: NDArray[np.float64], chain: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Differentiate a pole's own two columns^T residual by its two parameters: (J, 2, 2)."""
    even, odd = rest[0::2, None], rest[1::2, None]
    return np.stack([chain.real * even + chain.imag * odd, chain.real * odd - chain.imag * even], axis=1)


def _losses(spread: NDArray[np.float64], solution: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rise of the misfit without each pole's two columns, from the covariance (J, 2, 2) of their coefficients."""
    c = solution[: 2 * len(spread)].reshape(-1, 2)
    a, b, d = spread[:, 0, 0], spread[:, 0, 1], spread[:, 1, 1]
    determinant = np.maximum(a * d - b * b, 1e-300)
    rise: NDArray[np.float64] = (d * c[:, 0] ** 2 - 2 * b * c[:, 0] * c[:, 1] + a * c[:, 1] ** 2) / determinant
    return rise
