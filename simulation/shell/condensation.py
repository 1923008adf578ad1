"""Static condensation: only functions of edges and points enter the sparse solver."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from analysis.arrays import Real, Whole
from simulation.shell.edges import LineBlock
from simulation.shell.rigidity import THX, THY, Block, U, V, W
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns

CELLS_AT_ONCE = 16
"""Number of cells condensed at a time."""

Fields = tuple[int, ...]


@dataclass(frozen=True)
class ResponseProblem:
    """One dynamic stiffness Z = K - w**2 M, with its loads.

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


@dataclass(frozen=True)
class Condensed:
    """Condensation of the interior functions of some cells of one group.

    Attributes
    ----------
    inner : (C, i) ndarray of int
        Field and function, as in `Unknowns.chosen`, of the eliminated unknowns.
    outer : (C, e) ndarray of int
        Remaining unknowns, -1 where they are held at zero.
    schur : (C, e, e) ndarray
        Condensed stiffness of these.
    followed : (C, i, e) ndarray
        Minus the inner response per outer displacement.
    alone : (C, i, L) ndarray
        Inner response to the loads with the outer unknowns held.
    lost : (C, e, L) ndarray
        Reduction of the outer loads by the inner ones.
    """

    inner: Whole
    outer: Whole
    schur: Real
    followed: Real
    alone: Real
    lost: Real


def without_insides(
    space: ShapeSpace, problem: ResponseProblem, outer: Unknowns
) -> tuple[csr_matrix, Real, list[Condensed]]:
    """Z and loads over the outer unknowns, and the data to recover the inner ones.

    A separate function, so that the triplets of Z, the largest arrays, are freed before it is factorized.

    Parameters
    ----------
    outer : Unknowns
        The m unknowns shared by cells.

    Returns
    -------
    matrix : (m, m) csr_matrix
    load : (m, L) ndarray
    parts : list of Condensed
        With empty `schur` and `lost`, which are contained in matrix and load.
    """
    load = problem.loads.reshape(5 * space.size, -1)[outer.chosen].copy()
    rows, columns, values, parts = [], [], [], []
    for part in _condensed(space, problem, outer.number):
        used = part.outer >= 0
        np.subtract.at(load, part.outer[used], part.lost[used])
        cell, r, c = np.nonzero(used[:, :, None] & used[:, None, :])
        rows.append(part.outer[cell, r].astype(np.int32))
        columns.append(part.outer[cell, c].astype(np.int32))
        values.append(part.schur[cell, r, c])
        parts.append(replace(part, schur=np.zeros(0), lost=np.zeros(0)))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    del values, rows, columns
    matrix = csr_matrix(coo_matrix(entries, shape=(outer.size, outer.size)))
    if problem.lines:
        matrix = csr_matrix(matrix + outer.lines(problem.lines))
    return matrix, load, parts


def _condensed(space: ShapeSpace, problem: ResponseProblem, number: Whole) -> Iterator[Condensed]:
    """Condense all cells, `CELLS_AT_ONCE` at a time; `number` (5, N) is that of `Unknowns`."""
    size, first = space.size, first_inside(space)
    loads = problem.loads.reshape(5 * size, -1)
    for group in (0, 1):
        functions = space.groups[group].functions
        count = functions.shape[1]
        for fields, cells in _coupled(problem, group, len(functions)):
            for start in range(0, cells.size, CELLS_AT_ONCE):
                mine = cells[start : start + CELLS_AT_ONCE]
                here = functions[mine]
                inside = np.flatnonzero(here[0] >= first)
                i = (np.arange(len(fields))[:, None] * count + inside).ravel()
                e = np.setdiff1d(np.arange(len(fields) * count), i)
                place = (np.array(fields)[:, None] * size + here[:, None, :]).reshape(len(here), -1)
                z = _dense(problem, group, mine, fields, count)
                between = z[:, i[:, None], e]
                right = np.concatenate([between, loads[place[:, i]]], axis=2)
                followed = np.linalg.solve(z[:, i[:, None], i], right)
                followed, alone = followed[:, :, : e.size], followed[:, :, e.size :]
                across = between.transpose(0, 2, 1)
                yield Condensed(
                    inner=place[:, i],
                    outer=number.ravel()[place[:, e]],
                    schur=z[:, e[:, None], e] - across @ followed,
                    followed=followed,
                    alone=alone,
                    lost=across @ alone,
                )


def _coupled(problem: ResponseProblem, group: int, count: int) -> list[tuple[Fields, Whole]]:
    """Coupled fields, and the cells of a group with this coupling: all fields under patches and on curved plates.

    Elsewhere membrane and bending are uncoupled, and zeros between them would only fill the factors.
    """
    found = np.zeros(count, bool)
    for _, blocks in problem.terms:
        for f, g, which, cells, block in blocks:
            if which == group and f <= V < g:
                found[cells] |= block.any(axis=(1, 2))
    together, apart = np.flatnonzero(found), np.flatnonzero(~found)
    return [((U, V, W, THX, THY), together), ((U, V), apart), ((W, THX, THY), apart)]


def first_inside(space: ShapeSpace) -> int:
    """Return the number of the first function inside a cell."""
    return len(space.mesh.points) + len(space.mesh.edges) * (space.degree - 1)


def _dense(problem: ResponseProblem, group: int, cells: Whole, fields: Fields, count: int) -> Real:
    """Z of some fields on some cells of a group as whole matrices, (C, f N, f N)."""
    z = np.zeros((len(cells), len(fields) * count, len(fields) * count))
    part = {field: slice(k * count, (k + 1) * count) for k, field in enumerate(fields)}
    for factor, blocks in problem.terms:
        for f, g, which, acting, block in blocks:
            if which != group or f not in part or g not in part:
                continue
            there = np.searchsorted(acting, cells)
            same = acting[np.minimum(there, len(acting) - 1)] == cells
            if not same.any():
                continue
            here = slice(None) if same.all() else np.flatnonzero(same)
            some = factor * block[there[same]]
            z[here, part[f], part[g]] += some
            if f != g:
                z[here, part[g], part[f]] += some.transpose(0, 2, 1)
    return z
