"""Levenberg-Marquardt search for the poles of lowest misfit, with residues and residual terms eliminated."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import Bounds, ResidualTerms, to_parameters, to_poles
from analysis.identification.variable_projection import Projection, project

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
