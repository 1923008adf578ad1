"""Levenberg-Marquardt search for the poles of lowest misfit, with residues and residual terms eliminated.

Variable projection: least squares over the poles alone, and the triangular factor of such problems.

For given poles the model is linear in everything else, so its best residues are known and the misfit
is a function of 2J numbers. Its Gauss-Newton model uses the full derivative of the projection (Golub and
Pereyra, SIAM J. Numer. Anal. 10, 1973). Solution, misfit, gradient and Hessian all come from one triangular factor
of [columns, derivative columns, data], a matrix as small as the number of columns.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.lapack import dpotrf, dtrtri

from analysis.identification.lines import Lines
from analysis.identification.modes import DampingPrior
from analysis.identification.pole_residue import (
    Bounds,
    ResidualTerms,
    residues_from_columns,
    to_parameters,
    to_poles,
)

WELL_APART = 1e-4
"""Smallest sine between a column and those before it for which normal equations are good enough."""
RIDGE = 1e-10
"""Ridge on columns nearer to the others than that, relative to their squared length: residues of poles that the
lines cannot separate stay below 1e4 times the data; others change by no more than rounding."""


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


PREDICTED_FALL_FACTOR = 2.0
"""A search stops if even this many times the predicted fall of the misfit does not reach its target."""


@dataclass(frozen=True)
class PoleFit:
    """Outcome of the search over poles."""

    projection: Projection
    terms: ResidualTerms
    iterations: int
    converged: bool
    stuck: NDArray[np.bool_] = field(repr=False)

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles (J,), rad/s."""
        return self.projection.poles

    @property
    def parameters(self) -> int:
        """Real parameters: two per pole, two per residue, and the residual terms."""
        responses = len(self.projection.residues)
        return len(self.poles) * (2 + 2 * responses) + int(responses) * self.terms.parameters


def fit(
    lines: Lines,
    poles: NDArray[np.complex128],
    terms: ResidualTerms,
    *,
    tolerance: float = 1e-6,
    max_iterations: int = 60,
    start: Projection | None = None,
    target: float | None = None,
) -> PoleFit:
    """Levenberg-Marquardt search over the poles.

    Parameters
    ----------
    lines : Lines
        What was measured.
    poles : (J,) complex ndarray
        Start, rad/s, upper half plane.
    terms : ResidualTerms
        Eliminated together with the residues.
    tolerance : float
        Stop once both the predicted and the actual relative fall of the misfit in an accepted step are below this.
    max_iterations : int
        Largest number of projections; with 0, the projection at the start has no derivatives.
    start : Projection, optional
        The projection at `poles`, if it is known already.
    target : float, optional
        Stop once this misfit is reached, or once the Gauss-Newton model predicts that it cannot be, which may be
        before the first step.
    """
    bounds = Bounds.of(lines.frequency, lines.spacing)
    x = bounds.clip(to_parameters(poles))
    now = start if start is not None else project(lines, to_poles(x), terms, derivatives=max_iterations > 0)
    damping, grow, iterations = 1e-3, 2.0, 0
    done = len(poles) == 0 or (target is not None and now.misfit - PREDICTED_FALL_FACTOR * _promise(now) > target)
    while not done and iterations < max_iterations:
        trial = bounds.clip(x + _step(now, damping, np.exp(x[:, 1])))
        if np.abs(trial - x).max() < 1e-12:
            done = True
            break
        ahead = project(lines, to_poles(trial), terms)
        iterations += 1
        fall = now.misfit - ahead.misfit
        if fall > 0.0:
            done = fall < tolerance * (now.misfit + lines.hidden) and damping <= 1e-2
            x, now = trial, ahead
            damping, grow = max(damping / 5.0, 1e-9), 2.0
            if target is not None and _decided(now, fall, target):
                break
        else:
            done = damping > 1e8
            damping, grow = damping * grow, grow * 2.0
    return PoleFit(now, terms, iterations, done, bounds.stuck(now.poles))


def _decided(now: Projection, fall: float, target: float) -> bool:
    """Whether a target is reached and little more can be gained, or is out of reach."""
    if now.misfit < target:
        return fall < 0.1 * (target - now.misfit)
    return now.misfit - PREDICTED_FALL_FACTOR * _promise(now) > target


def _promise(now: Projection) -> float:
    """Fall of the misfit that the quadratic Gauss-Newton model predicts for a full step."""
    root = np.sqrt(np.maximum(np.diag(now.hessian), np.finfo(float).tiny))
    scaled = now.hessian / root[:, None] / root + 1e-6 * np.eye(len(root))
    return float(now.gradient / root @ cho_solve(cho_factor(scaled), now.gradient / root))


def _step(now: Projection, damping: float, zeta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Damped Gauss-Newton step (J, 2), at most three half widths in frequency and a factor e in damping."""
    diagonal = np.maximum(np.diag(now.hessian), 1e-14 * np.diag(now.hessian).max() + 1e-300)
    root = np.sqrt(diagonal)
    scaled = now.hessian / root[:, None] / root + (damping + 1e-12) * np.eye(len(root))
    step = -cho_solve(cho_factor(scaled), now.gradient / root) / root
    step = step.reshape(-1, 2)
    limit = np.column_stack([np.maximum(3.0 * zeta, 1e-5), np.ones_like(zeta)])
    limited: NDArray[np.float64] = np.clip(step, -limit, limit)
    return limited
