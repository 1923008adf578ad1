"""Selection and order of the unknowns, matrices over them, and their sparse factorization.

Unknowns are eliminated in the order of nested dissection (George, SIAM J. Numer. Anal. 10, 1973). Cells are halved
by straight cuts, recursively. The functions common to both halves are eliminated after both, so that until then
the halves are uncoupled.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix
from scipy.sparse.linalg import SuperLU, splu

from analysis.arrays import Mask, Real, Whole
from simulation.shell.edges import LineBlock
from simulation.shell.points import point_springs
from simulation.shell.rigidity import Block
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.space import ShapeSpace


@dataclass(frozen=True)
class Unknowns:
    """Unknowns of a shell on a space, in elimination order.

    Attributes
    ----------
    space : ShapeSpace
    chosen : (n,) ndarray of int
        Field times the number of functions plus the function.
    """

    space: ShapeSpace
    chosen: Whole

    @classmethod
    def of(cls, space: ShapeSpace, kept: Mask) -> "Unknowns":
        """Order the kept functions (5, N) so that factors of matrices over them are sparse."""
        return cls.ordered(space, kept, elimination_order(space))

    @classmethod
    def ordered(cls, space: ShapeSpace, kept: Mask, order: Whole) -> "Unknowns":
        """Take the kept functions in a given order.

        Parameters
        ----------
        space : ShapeSpace
            Of N functions.
        kept : (5, N) ndarray of bool
            By field and function.
        order : (N,) ndarray of int
            All functions, in elimination order.
        """
        rank = np.empty(space.size, int)
        rank[order] = np.arange(space.size)
        field, function = np.nonzero(kept)
        by = np.lexsort((field, rank[function]))
        return cls(space, field[by] * space.size + function[by])

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return int(self.chosen.size)

    @cached_property
    def number(self) -> Whole:
        """Unknown of every field and function, (5, N); -1 for functions that are no unknowns."""
        found = np.full(5 * self.space.size, -1)
        found[self.chosen] = np.arange(self.size)
        return found.reshape(5, -1)

    @property
    def kept(self) -> Mask:
        """Functions that are unknowns, (5, N)."""
        return self.number >= 0

    def matrix(self, blocks: Iterable[Block]) -> csr_matrix:
        """Sum of cells' matrices, (n, n); blocks of two different fields are added with their transposes."""
        rows, columns, values = [], [], []
        for f, g, group, cells, block in blocks:
            functions = self.space.groups[group].functions[cells]
            row, column = self.number[f][functions], self.number[g][functions]
            largest = np.abs(block).max(axis=(1, 2), keepdims=True, initial=0.0)
            used = (np.abs(block) > 1e-13 * largest) & (row >= 0)[:, :, None] & (column >= 0)[:, None, :]
            cell, i, j = np.nonzero(used)
            r, c, value = row[cell, i], column[cell, j], block[cell, i, j]
            rows += [r] if f == g else [r, c]
            columns += [c] if f == g else [c, r]
            values += [value] if f == g else [value, value]
        if not values:
            return csr_matrix((self.size, self.size))
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return csr_matrix(coo_matrix(entries, shape=(self.size, self.size)))

    def lines(self, blocks: Iterable[LineBlock]) -> csr_matrix:
        """Sum of matrices along edges, (n, n)."""
        found = csr_matrix((self.size, self.size))
        for f, g, functions, block in blocks:
            row, column = self.number[f][functions], self.number[g][functions]
            edge, i, j = np.nonzero((row >= 0)[:, :, None] & (column >= 0)[:, None, :])
            entries = (block[edge, i, j], (row[edge, i], column[edge, j]))
            part = csr_matrix(coo_matrix(entries, shape=(self.size, self.size)))
            found = found + part if f == g else found + part + part.T
        return csr_matrix(found)

    def springs(self, shell: ShellPlate, *, damping: bool = False) -> csr_matrix:
        """Stiffness of a plate's supports along edges and at points, (n, n), or with `damping` their dashpots."""
        total = self.lines(shell.springs(damping=damping))
        for field, row, stiffness in point_springs(shell.space, shell.plate, damping=damping):
            mean = self.rows(row, field)
            total = csr_matrix(total + stiffness * (mean.T @ mean))
        return total

    def vector(self, parts: dict[int, Real]) -> Real:
        """Values over the functions (N,) of some fields as a vector over the unknowns, (n,)."""
        found = np.zeros((5, self.space.size))
        for field, values in parts.items():
            found[field] = values
        return np.asarray(found.ravel()[self.chosen])

    def rows(self, matrix: csr_matrix, field: int) -> csr_matrix:
        """Matrix (K, N) over the functions of one field as one over the unknowns, (K, n)."""
        wide = coo_matrix(matrix)
        column = self.number[field][wide.col]
        used = column >= 0
        entries = (wide.data[used], (wide.row[used], column[used]))
        return csr_matrix(coo_matrix(entries, shape=(matrix.shape[0], self.size)))


DIRECTIONS = 8
"""Directions of the cuts that are tried."""
LEAST_SIDE_SHARE = 0.35
"""Smallest share of the functions on one side of a cut, if the cells allow it."""
UNEVEN_PENALTY = 4.0
"""Penalty on the cost of a cut for unequal sides: factor on the squared deviation of their shares from a half."""
CELLS_NOT_HALVED = 2
"""Largest number of cells that is not halved further: it would cost more than it saves."""


def dissected(members: Whole, size: Real, places: Real) -> Whole:
    """Order the parts of cells, for example points and edges, for elimination.

    Parameters
    ----------
    members : (C, K) ndarray of int
        Parts of every cell; -1 where it has fewer.
    size : (P,) ndarray
        Functions on every part.
    places : (C, 2) ndarray
        Middles of the cells, m.

    Returns
    -------
    ndarray of int
        Every part of a cell once.
    """
    angles = np.arange(DIRECTIONS) * np.pi / DIRECTIONS
    along = np.array([np.cos(angles), np.sin(angles)]).T @ places.T
    left = np.ones(len(size), bool)
    order: list[Whole] = []

    def eliminate(cells: Whole) -> None:
        parts = members[cells]
        used = (parts >= 0) & left[parts]
        inside, which = np.unique(parts[used], return_inverse=True)
        if not inside.size:
            return
        last = inside
        if len(cells) > CELLS_NOT_HALVED:
            row = np.nonzero(used)[0]
            cuts = [_cut(one, row, which, size[inside]) for one in along[:, cells]]
            _, before, shared = min(cuts, key=lambda cut: cut[0])
            last = inside[shared]
            left[last] = False
            eliminate(cells[before])
            eliminate(cells[~before])
        left[last] = False
        order.append(last)

    eliminate(np.arange(len(members)))
    return np.concatenate(order)


def _cut(along: Real, row: Whole, which: Whole, size: Real) -> tuple[float, Mask, Mask]:
    """Cheapest cut across a direction: its cost, the cells (C,) before it, the parts (P,) on both its sides.

    `along` (C,) are places of the cells; each incidence of a part and a cell is one of `which` and one of `row`.
    """
    count = len(along)
    rank = np.empty(count, int)
    rank[np.argsort(along, kind="stable")] = np.arange(count)
    first, last = np.full(size.size, count), np.zeros(size.size, int)
    np.minimum.at(first, which, rank[row])
    np.maximum.at(last, which, rank[row])
    # of the cut before each cell but the first: functions of parts wholly before it, and of those on both sides
    before = np.cumsum(np.bincount(last + 1, size, count + 1))[1:count]
    shared = np.cumsum(np.bincount(first + 1, size, count + 1))[1:count] - before
    uneven = np.abs(before / np.maximum(size.sum() - shared, 1.0) - 0.5)
    cost = np.where(
        uneven <= max(0.5 - LEAST_SIDE_SHARE, uneven.min()), shared * (1.0 + UNEVEN_PENALTY * uneven**2), np.inf
    )
    cut = int(cost.argmin()) + 1
    return float(cost[cut - 1]), rank < cut, (first < cut) & (last >= cut)


def elimination_order(space: ShapeSpace) -> Whole:
    """Order of the functions (N,) that keeps factors sparse: insides of cells, then edges and points, dissected.

    Functions of one cell, edge or point have the same neighbours, and are consecutive.
    """
    mesh, p = space.mesh, space.degree
    points, edges = len(mesh.points), len(mesh.edges)
    quads = np.hstack([mesh.quads, points + mesh.quad_edges])
    triangles = np.hstack([mesh.triangles, points + mesh.triangle_edges])
    members = np.vstack([quads, np.pad(triangles, ((0, 0), (0, 2)), constant_values=-1)])
    places = np.vstack([mesh.points[cells].mean(axis=1) for cells in (mesh.quads, mesh.triangles)])
    size = np.concatenate([np.ones(points), np.full(edges, p - 1.0)])
    order = [np.arange(points + edges * (p - 1), space.size)]
    for part in dissected(members, size, places):
        first = points + (part - points) * (p - 1)
        order.append(np.array([part]) if part < points else np.arange(first, first + p - 1))
    return np.concatenate(order)


def factorize(matrix: csr_matrix) -> SuperLU:
    """Factorize a (complex) symmetric matrix with unknowns in elimination order.

    Its rows are read as columns, which saves a transposition. There is no pivoting, because it would change the
    order. Solutions are nevertheless accurate to about 1e-12, because a plate's dynamic stiffness away from an
    undamped resonance is far from singular.
    """
    return splu(
        csc_matrix((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape),
        permc_spec="NATURAL",
        diag_pivot_thresh=0.0,
        relax=1,
        options={"SymmetricMode": True},
    )
