"""Which functions a plate's answers need: chosen by solutions with all of them.

A few answers of the plate are computed with functions of high degree everywhere; a function is kept where its
share of the energy of some answer exceeds a tolerance. What is dropped tells the error that is left. Insides of
cells are eliminated cell by cell, so that only functions of edges and points enter the sparse solver.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from analysis.arrays import Mask, Real, Whole
from simulation.shell.edges import LineBlock
from simulation.shell.factors import factorize
from simulation.shell.rigidity import Block
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns, elimination_order

CHUNK = 16
"""Cells eliminated at a time."""
BEYOND = 0.03
"""Energy in functions of higher degree than the highest, over that in the highest: found against finer meshes at
degree 7, where it is as much as the functions left out hold. On a mesh that is too coarse the latter is large."""


@dataclass(frozen=True)
class Choice:
    """Functions kept, and how much was dropped.

    Attributes
    ----------
    kept : (5, N) ndarray of bool
    dropped : float
        Largest share of the energy of an answer that the dropped functions hold, and functions of still higher
        degree would hold: `BEYOND` of what those of the highest degree do.
    """

    kept: Mask
    dropped: float


@dataclass(frozen=True)
class ResponseProblem:
    """One dynamic stiffness Z = K - w**2 M for which answers are wanted.

    Attributes
    ----------
    terms : sequence of (float, list of Block)
        Matrices, and their factors in Z.
    lines : list of LineBlock
        Springs along edges.
    loads : (5, N, L) ndarray
    energy : (5, N) ndarray
        Diagonal of K + w**2 M.
    """

    terms: Sequence[tuple[float, Sequence[Block]]]
    lines: list[LineBlock]
    loads: Real
    energy: Real


def chosen(
    space: ShapeSpace,
    held: Mask,
    problems: Sequence[ResponseProblem],
    tolerance: float,
    executor: Executor | None = None,
    step: Callable[[], None] | None = None,
) -> Choice:
    """Keep the functions whose share |x|**2 K_ii / (x' K x) of some answer x exceeds `tolerance`.

    Functions of points stay in any case.

    Parameters
    ----------
    space : ShapeSpace
        Of N functions.
    held : (5, N) ndarray of bool
        Functions held at zero by supports.
    problems : sequence of ResponseProblem
    tolerance : float
    executor : Executor, optional
        Solves several problems at a time.
    step : callable, optional
        Called after each problem.

    Returns
    -------
    Choice
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
    lost = [share[~kept].sum(axis=0) + BEYOND * share[:, highest].sum(axis=(0, 1)) for share in shares]
    dropped = max(float(one.max(initial=0.0)) for one in lost)
    return Choice(kept, dropped)


def _highest(space: ShapeSpace) -> Mask:
    """Return which functions (N,) of edges and of the insides of cells have the highest degree."""
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
    for f, g, group, block in blocks:
        if f == g:
            np.add.at(found[f], space.groups[group].functions, np.einsum("cii->ci", block))
    return found


@dataclass(frozen=True)
class _Condensed:
    """Insides of some cells of one group, eliminated.

    Attributes
    ----------
    inner : (C, i) ndarray of int
        Field and function, as in `Unknowns.chosen`, of what was eliminated.
    outer : (C, e) ndarray of int
        Unknowns that remain, -1 where they are held at zero.
    schur : (C, e, e) ndarray
        Stiffness of these.
    followed : (C, i, e) ndarray
        Inner answer per outer one, with the sign turned.
    alone : (C, i, L) ndarray
        Inner answer to the loads with the outer ones held.
    lost : (C, e, L) ndarray
        What the inner loads take off the outer ones.
    """

    inner: Whole
    outer: Whole
    schur: Real
    followed: Real
    alone: Real
    lost: Real


def _shares(space: ShapeSpace, held: Mask, problem: ResponseProblem, order: Whole) -> Real:
    """Share of every function in the energy of every answer, (5, N, L)."""
    size = space.size
    free = ~held
    free[:, _first_inside(space) :] = False
    outer = Unknowns.ordered(space, free, order)
    loads = problem.loads.reshape(5 * size, -1)
    load = loads[outer.chosen].copy()
    rows, columns, values, parts = [], [], [], []  # the largest arrays of all: hence 32-bit indices
    for part in _condensed(space, problem, outer.number):
        used = part.outer >= 0
        np.subtract.at(load, part.outer[used], part.lost[used])
        cell, r, c = np.nonzero(used[:, :, None] & used[:, None, :])
        rows.append(part.outer[cell, r].astype(np.int32))
        columns.append(part.outer[cell, c].astype(np.int32))
        values.append(part.schur[cell, r, c])
        parts.append(part)
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    matrix = csr_matrix(coo_matrix(entries, shape=(outer.size, outer.size)))
    solved = factorize(csr_matrix(matrix + outer.lines(problem.lines))).solve(load)
    answer = np.zeros_like(loads)
    answer[outer.chosen] = solved
    padded = np.vstack([solved, np.zeros((1, load.shape[1]))])  # number -1: held at zero
    for part in parts:
        answer[part.inner] = part.alone - part.followed @ padded[part.outer]
    energy = problem.energy.reshape(-1, 1) * answer**2
    total = np.maximum(np.abs(np.einsum("nl,nl->l", loads, answer)), energy.max(axis=0))  # x' Z x is x' load
    return np.asarray((energy / total).reshape(5, size, -1))


def _condensed(space: ShapeSpace, problem: ResponseProblem, number: Whole) -> Iterator[_Condensed]:
    """Eliminate the insides of all cells, `CHUNK` cells at a time; `number` (5, N) is that of `Unknowns`."""
    size, first = space.size, _first_inside(space)
    loads = problem.loads.reshape(5 * size, -1)
    for group in (0, 1):
        functions = space.groups[group].functions
        count = functions.shape[1]
        for start in range(0, len(functions), CHUNK):
            mine = slice(start, start + CHUNK)
            here = functions[mine]
            inside = np.flatnonzero(here[0] >= first)
            i = (np.arange(5)[:, None] * count + inside).ravel()
            e = np.setdiff1d(np.arange(5 * count), i)
            place = (np.arange(5)[:, None] * size + here[:, None, :]).reshape(len(here), -1)
            z = _dense(problem, group, mine, len(here), count)
            between = z[:, i[:, None], e]
            followed = np.linalg.solve(z[:, i[:, None], i], np.concatenate([between, loads[place[:, i]]], axis=2))
            followed, alone = followed[:, :, : e.size], followed[:, :, e.size :]
            across = between.transpose(0, 2, 1)
            yield _Condensed(
                inner=place[:, i],
                outer=number.ravel()[place[:, e]],
                schur=z[:, e[:, None], e] - across @ followed,
                followed=followed,
                alone=alone,
                lost=across @ alone,
            )


def _first_inside(space: ShapeSpace) -> int:
    """Return the number of the first function inside a cell."""
    return len(space.mesh.points) + len(space.mesh.edges) * (space.degree - 1)


def _dense(problem: ResponseProblem, group: int, cells: slice, size: int, count: int) -> Real:
    """Z of some cells of a group as whole matrices, (C, 5 N, 5 N)."""
    z = np.zeros((size, 5 * count, 5 * count))
    for factor, blocks in problem.terms:
        for f, g, which, block in blocks:
            if which != group:
                continue
            rows, columns = slice(f * count, (f + 1) * count), slice(g * count, (g + 1) * count)
            part = factor * block[cells]
            z[:, rows, columns] += part
            if f != g:
                z[:, columns, rows] += part.transpose(0, 2, 1)
    return z
