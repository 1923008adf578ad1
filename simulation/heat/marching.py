"""Temperatures over time, step by step.

Two implicit stages with the same matrix (Alexander, SIAM J. Numer. Anal. 14, 1977, 1006-1021): of second order,
and what is much faster than a step, as the first moments of sun on a face, dies out instead of ringing on.
"""

from collections.abc import Callable, Iterator

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import SuperLU, splu

from analysis.arrays import Real
from simulation.heat.heat_model import HeatModel

SHARE = 1.0 - np.sqrt(0.5)
"""Of a step, at which the first stage stands."""

ROUNDING = 1e-12
"""Share of all conductances up to which what is left of them, when every place is as warm, is rounding."""


def march(model: HeatModel, load: Callable[[float], Real], start: Real, step: float, count: int) -> Iterator[Real]:
    """Yield coefficients (L N,) after every step.

    Parameters
    ----------
    load : callable
        Heat that flows in, (L N,), W, at a time, s.
    start : (L N,) ndarray
        Coefficients at the time 0.
    step : float
        s.
    count : int
        Number of steps.
    """
    solver = _factors(model.capacity + SHARE * step * model.conductance)
    here = start
    for number in range(count):
        now = number * step
        first = solver.solve(load(now + SHARE * step) - model.conductance @ here)
        between = here + (1.0 - SHARE) * step * first
        second = solver.solve(load(now + step) - model.conductance @ between)
        here = between + SHARE * step * second
        yield here


def settled(model: HeatModel, load: Real) -> Real:
    """Return coefficients (L N,) of the state of rest under a load (L N,), W.

    Raises
    ------
    ValueError
        Where no face and no edge gives heat to anything: then there is none.
    """
    uniform = model.uniform(1.0)
    conducted = float(np.abs(model.conductance.data).sum())
    if not float(uniform @ (model.conductance @ uniform)) > ROUNDING * conducted:
        raise ValueError("no face and no edge exchanges heat: the plate never comes to rest")
    return np.asarray(_factors(model.conductance).solve(load))


def _factors(matrix: csr_matrix) -> SuperLU:
    """Factors of a symmetric matrix; by the order for those that are not, they take eight times as long."""
    return splu(
        csc_matrix(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
