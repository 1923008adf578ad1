"""Candidates of a score test: their tangents, and the largest gain inside their ranges."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import Parameter, Values


@dataclass(frozen=True)
class Column:
    """One tangent of a score test.

    Attributes
    ----------
    effect : str
    site : int
        Index of the site on the effect's card; 0 for an effect that is on.
    card : Parameter
    at : float
        Value of the parameter at which it was computed.
    shapes : mapping
        Values of the effect's shapes there.
    """

    effect: str
    site: int
    card: Parameter
    at: float
    shapes: Values


@dataclass(frozen=True)
class Candidate:
    """Predicted gain of one effect, or of a pair, to first order.

    Attributes
    ----------
    effects : tuple of str
    gain : float
        Laplace evidence over the present twin, nats, less log of the number of sites tried.
    step : tuple of float
        Of each of `columns`.
    columns : tuple of int
    size : float
        Size in sigma of the part of the signal that only this candidate explains, at `step`.
    fit : float
        Log likelihood over the present twin, at `step`, nats.
    """

    effects: tuple[str, ...]
    gain: float
    step: tuple[float, ...]
    columns: tuple[int, ...]
    size: float
    fit: float = 0.0


def solve_inside(matrix: Real, pull: Real, low: Real, high: Real) -> Real:
    """Maximise pull'x - x'matrix x / 2 over low <= x <= high.

    An unknown that leaves the box is set to its bound and the others are solved for again: exact for one unknown,
    approximate for few.

    Parameters
    ----------
    matrix : (q, q) ndarray
        Positive definite.
    pull : (q,) ndarray
    low : (q,) ndarray
    high : (q,) ndarray

    Returns
    -------
    (q,) ndarray
    """
    x = np.zeros(len(pull))
    free = np.ones(len(pull), dtype=bool)
    for _ in range(len(pull)):
        held = matrix[np.ix_(free, ~free)] @ x[~free]
        x[free] = np.linalg.solve(matrix[np.ix_(free, free)], pull[free] - held)
        outside = free & ((x < low) | (x > high))
        if not outside.any():
            break
        x = np.where(outside, np.clip(x, low, high), x)
        free &= ~outside
        if not free.any():
            break
    return x
