"""Levenberg-Marquardt step inside bounds."""

import numpy as np

from analysis.arrays import Mask, Real


def bounded_step(matrix: Real, gradient: Real, moving: Mask, low: Real, high: Real, damping: float) -> Real:
    """Solve for the damped step of the moving unknowns inside bounds.

    An unknown that would leave its bounds is set to the bound and the others are solved for again: otherwise they
    would be adjusted to a step that is not made.

    Parameters
    ----------
    matrix : (P, P) ndarray
        Positive definite.
    gradient : (P,) ndarray
    moving : (P,) bool ndarray
        Unknowns that may move; the others stay.
    low : (P,) ndarray
        Lower bounds of the step.
    high : (P,) ndarray
        Upper bounds.
    damping : float
        Added to the unit diagonal of the scaled matrix.

    Returns
    -------
    (P,) ndarray
    """
    step, moving = np.zeros(len(gradient)), moving.copy()
    while moving.any():
        part = matrix[np.ix_(moving, moving)]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(part), 1e-300))
        unit = part * scale[:, None] * scale + (damping + 1e-12) * np.eye(len(scale))
        pull = gradient[moving] - matrix[np.ix_(moving, ~moving)] @ step[~moving]
        step[moving] = scale * np.linalg.solve(unit, scale * pull)
        outside = moving & ((step < low) | (step > high))
        if not outside.any():
            break
        step = np.where(outside, np.clip(step, low, high), step)
        moving &= ~outside
    return step
