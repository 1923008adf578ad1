"""Selection of the functions that a plate's responses need, from solutions with all of them.

A few responses of the plate are computed with functions of high degree everywhere; a function is kept if its share
of the energy of some response exceeds a tolerance. The energy dropped is an estimate of the error. Interior
functions are eliminated cell by cell, so that only functions of edges and points enter the sparse solver.
"""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Mask, Real, Whole
from simulation.shell.condensation import ResponseProblem, first_inside, without_insides
from simulation.shell.factors import factorize
from simulation.shell.rigidity import Block
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns, elimination_order

ENERGY_RATIO_ABOVE = 0.03
"""Energy of functions above the highest degree, over that in the highest degree: determined with finer meshes at
degree 7, where it equals the energy of the functions left out. On too coarse a mesh the latter is large."""


@dataclass(frozen=True)
class Choice:
    """Functions kept, and how much was dropped.

    Attributes
    ----------
    kept : (5, N) ndarray of bool
    dropped : float
        Largest share of a response's energy in the dropped functions and, by estimate, in functions of still
        higher degree: `ENERGY_RATIO_ABOVE` times that of the highest degree.
    """

    kept: Mask
    dropped: float


def chosen(
    space: ShapeSpace,
    held: Mask,
    problems: Sequence[ResponseProblem],
    tolerance: float,
    executor: Executor | None = None,
    step: Callable[[], None] | None = None,
    counted: int | None = None,
) -> Choice:
    """Keep the functions whose share |x|**2 K_ii / (x' K x) of some response x exceeds `tolerance`.

    Functions of points are always kept.

    Parameters
    ----------
    space : ShapeSpace
        Of N functions.
    held : (5, N) ndarray of bool
        Functions held at zero by supports.
    executor : Executor, optional
        Solves several problems at a time.
    step : callable, optional
        Called after each problem.
    counted : int, optional
        Number of loads, the first ones, in whose responses the dropped energy is counted; default: all.
    """
    order = elimination_order(space)
    run = map if executor is None else executor.map
    shares = []
    for found in run(lambda problem: _shares(space, held, problem, order), problems):
        shares.append(found)
        if step is not None:
            step()
    worst = np.max([share.max(axis=2) for share in shares], axis=0)
    kept = worst > tolerance
    kept[:, : len(space.mesh.points)] = True
    kept &= ~held
    highest = _highest(space)
    lost = [share[~kept].sum(axis=0) + ENERGY_RATIO_ABOVE * share[:, highest].sum(axis=(0, 1)) for share in shares]
    dropped = max(float(one[:counted].max(initial=0.0)) for one in lost)
    return Choice(kept, dropped)


def _highest(space: ShapeSpace) -> Mask:
    """Return which functions (N,) of edges and of the interiors of cells have the highest degree."""
    p, found = space.degree, np.zeros(space.size, bool)
    inside = np.arange((p - 1) ** 2)
    along = np.stack([inside // (p - 1), inside % (p - 1)])
    last = {4: (along == p - 2).any(axis=0), 3: np.arange((p - 1) * (p - 2) // 2) >= (p - 2) * (p - 3) // 2}
    for corners, group in zip((4, 3), space.groups, strict=True):
        edges = np.tile(np.arange(p - 1) == p - 2, corners)
        local = np.concatenate([np.zeros(corners, bool), edges, last[corners]])
        found[group.functions[:, local]] = True
    return found


def diagonal(space: ShapeSpace, blocks: Iterable[Block]) -> Real:
    """Diagonal of a matrix given by its blocks, (5, N)."""
    found = np.zeros((5, space.size))
    for f, g, group, cells, block in blocks:
        if f == g:
            np.add.at(found[f], space.groups[group].functions[cells], np.einsum("cii->ci", block))
    return found


def _shares(space: ShapeSpace, held: Mask, problem: ResponseProblem, order: Whole) -> Real:
    """Share of every function in the energy of every response, (5, N, L)."""
    size = space.size
    free = ~held
    free[:, first_inside(space) :] = False
    outer = Unknowns.ordered(space, free, order)
    loads = problem.loads.reshape(5 * size, -1)
    matrix, load, parts = without_insides(space, problem, outer)
    solved = factorize(matrix).solve(load)
    answer = np.zeros_like(loads)
    answer[outer.chosen] = solved
    padded = np.vstack([solved, np.zeros((1, load.shape[1]))])  # number -1: held at zero
    for part in parts:
        answer[part.inner] = part.alone - part.followed @ padded[part.outer]
    energy = problem.energy.reshape(-1, 1) * answer**2
    total = np.maximum(np.abs(np.einsum("nl,nl->l", loads, answer)), energy.max(axis=0))  # x' Z x is x' load
    return np.asarray((energy / total).reshape(5, size, -1))
