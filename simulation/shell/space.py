"""Hierarchical functions over a mesh of curved quadrilaterals and triangles, and their integrals."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix

from analysis.arrays import Mask, Real, Whole
from simulation.meshing.plate_mesh import PlateMesh
from simulation.shell.shape_functions import (
    QUAD_EDGES,
    TRIANGLE_EDGES,
    ShapeTable,
    boxes_of,
    inverse_of,
    map_cells,
    map_places,
    quad_functions,
    quad_rule,
    triangle_functions,
    triangle_rule,
)

Value = TypeVar("Value", bound=np.generic)

OUTSIDE_TOLERANCE = 1e-4
"""Tolerance for points outside every cell, as a share of a cell's size: rounding of outlines."""


CURVED_ORDER = 4
"""Increase of the order of quadrature for the Jacobian of curved cells."""


@dataclass(frozen=True)
class CellGroup:
    """All quadrilaterals, or all triangles, of a space.

    Attributes
    ----------
    functions : (C, N) ndarray of int
        Functions of the space on every cell.
    sign : (C, N) ndarray
        -1 where a function of odd degree has the opposite direction on its edge to that of the reference cell.
    table : ShapeTable
        Of the reference cell, at the Q points of quadrature.
    places : (C, Q, 2) ndarray
        Points of quadrature, m.
    dx : (C, Q) ndarray
        Their areas (quadrature weight times Jacobian), m2.
    inverse : (C, Q, 2, 2) ndarray
        Derivatives of the reference coordinates (row) by x and y, 1/m.
    """

    functions: Whole
    sign: Real
    table: ShapeTable
    places: Real
    dx: Real
    inverse: Real

    @cached_property
    def values(self) -> Real:
        """Functions at the points, (C, N, Q)."""
        return np.asarray(self.sign[:, :, None] * self.table.value)

    @cached_property
    def slopes(self) -> Real:
        """Derivatives by x and y, (2, C, N, Q), 1/m."""
        found = np.einsum("anq,cqad->dcnq", self.table.slope, self.inverse, optimize=True)
        return np.asarray(found * self.sign[:, :, None])

    def factor(self, letter: str, chosen: Whole | slice) -> Real:
        """Functions (``0``) or their derivatives (``x``, ``y``) on some cells, (C', N, Q)."""
        return self.values[chosen] if letter == "0" else self.slopes["xy".index(letter), chosen]


def cell_group(mesh: PlateMesh, degree: int, *, triangles: bool) -> CellGroup:
    """Return the functions on all quadrilaterals, or all triangles, at their points of quadrature.

    Parameters
    ----------
    degree : int
        Of the functions.

    Raises
    ------
    ValueError
        For an inverted cell, with the place.
    """
    order = 2 * degree + (CURVED_ORDER if mesh.bow.any() else 0)
    places, weights = (triangle_rule if triangles else quad_rule)(order)
    cells = mesh.triangles if triangles else mesh.quads
    edges = mesh.triangle_edges if triangles else mesh.quad_edges
    pairs = TRIANGLE_EDGES if triangles else QUAD_EDGES
    table = (triangle_functions if triangles else quad_functions)(degree, places)
    number = np.arange(len(cells))
    each = (degree - 1) * (degree - 2) // 2 if triangles else (degree - 1) ** 2
    first = len(mesh.points) + len(mesh.edges) * (degree - 1)
    if triangles:
        first += len(mesh.quads) * (degree - 1) ** 2
    on_edges = len(mesh.points) + edges[:, :, None] * (degree - 1) + np.arange(degree - 1)
    functions = np.hstack(
        [
            cells,
            on_edges.reshape(len(cells), len(pairs) * (degree - 1)),
            first + number[:, None] * each + np.arange(each),
        ]
    )
    sign = np.ones(functions.shape)
    odd = np.arange(2, degree + 1) % 2 == 1
    for k, (a, b) in enumerate(pairs):
        start = len(pairs) + k * (degree - 1)
        sign[:, start : start + degree - 1] = np.where((cells[:, a] > cells[:, b])[:, None] & odd, -1.0, 1.0)
    count, q = len(cells), places.shape[1]
    x = np.zeros((count, q, 2))
    jacobian = np.zeros((count, q, 2, 2))
    if count:
        x, jacobian = map_cells(mesh, places, triangles)
    det = np.linalg.det(jacobian)
    turned = (det <= 0.0).any(axis=1)
    if turned.any():
        place = mesh.points[cells[turned][0]].mean(axis=0)
        raise ValueError(f"a cell of the mesh near ({place[0]:.5g}, {place[1]:.5g}) m is turned over")
    inverse = np.asarray(np.linalg.inv(jacobian) if count else jacobian, float)
    return CellGroup(functions, sign, table, x, np.asarray(det * weights, float), inverse)


@dataclass(frozen=True)
class ShapeSpace:
    """Functions of one degree over a mesh.

    Numbering of functions: one of each point, then by degree those of each edge, then those inside each cell.
    Fields over the plate are given at the points of quadrature, (Q,), cell by cell, quadrilaterals first.

    Attributes
    ----------
    mesh : PlateMesh
    degree : int
    groups : tuple of CellGroup
        Quadrilaterals, triangles.
    """

    mesh: PlateMesh
    degree: int
    groups: tuple[CellGroup, CellGroup]

    @classmethod
    def on(cls, mesh: PlateMesh, degree: int) -> "ShapeSpace":
        """Build the space; ValueError, with the place, for an inverted cell."""
        if not 1 <= degree <= 12:
            raise ValueError(f"degree is {degree}; allowed 1 to 12")
        quads = cell_group(mesh, degree, triangles=False)
        return cls(mesh, degree, (quads, cell_group(mesh, degree, triangles=True)))

    @property
    def size(self) -> int:
        """Number of functions."""
        inside = (self.degree - 1) ** 2, (self.degree - 1) * (self.degree - 2) // 2
        own = len(self.mesh.points) + len(self.mesh.edges) * (self.degree - 1)
        return own + inside[0] * len(self.mesh.quads) + inside[1] * len(self.mesh.triangles)

    @cached_property
    def dx(self) -> Real:
        """Areas of the points of quadrature, (Q,), m2."""
        return np.concatenate([group.dx.ravel() for group in self.groups])

    @cached_property
    def points(self) -> Real:
        """Points of quadrature, (Q, 2), m."""
        return np.vstack([group.places.reshape(-1, 2) for group in self.groups])

    def spread(self, cells: NDArray[Value]) -> NDArray[Value]:
        """Values of cells (cells,), or a choice of cells, at the points of quadrature, (Q,)."""
        quads = len(self.mesh.quads)
        parts = (cells[:quads], cells[quads:])
        counts = (group.dx.shape[1] for group in self.groups)
        return np.concatenate([np.repeat(part, count) for part, count in zip(parts, counts, strict=True)])

    def product(self, row: str, column: str, cells: Mask | None = None, weight: Real | None = None) -> csr_matrix:
        """Integral of weight times N_i (or its derivative by ``row``) times N_j (by ``column``).

        Most hierarchical functions are orthogonal on rectangles: entries of the size of rounding errors are
        dropped, because they would fill the factors of a sparse solver.

        Parameters
        ----------
        row, column : str
            ``x`` or ``y`` for that derivative, ``0`` for the function itself.
        cells : (cells,) bool ndarray, optional
            All unless given.
        weight : (Q,) ndarray, optional
            At `points`.

        Returns
        -------
        (n, n) csr_matrix
        """
        rows, columns, values = [], [], []
        for group, chosen, measure in self._measures(cells, weight):
            functions, right = group.functions[chosen], group.factor(column, chosen)
            blocks = (group.factor(row, chosen) * measure[:, None]) @ right.transpose(0, 2, 1)
            largest = np.abs(blocks).max(axis=(1, 2), keepdims=True, initial=0.0)
            cell, i, j = np.nonzero(np.abs(blocks) > 1e-13 * largest)
            rows.append(functions[cell, i])
            columns.append(functions[cell, j])
            values.append(blocks[cell, i, j])
        flat = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return csr_matrix(coo_matrix(flat, shape=(self.size, self.size)))

    def blocks(
        self, row: str, column: str, group: int, weight: Real | None = None, cells: Whole | None = None
    ) -> Real:
        """Integrals of `product` on the cells of a group.

        Parameters
        ----------
        row, column : str
            ``x`` or ``y`` for that derivative, ``0`` for the function itself.
        group : int
            0 for quadrilaterals, 1 for triangles.
        weight : (C, q) ndarray, optional
            At the points of quadrature of the group's cells; one unless given.
        cells : (C',) ndarray of int, optional
            Of the group; all unless given.

        Returns
        -------
        (C', N, N) ndarray
        """
        part, chosen = self.groups[group], slice(None) if cells is None else cells
        measure = (part.dx if weight is None else part.dx * weight)[chosen]
        return np.asarray(
            (part.factor(row, chosen) * measure[:, None]) @ part.factor(column, chosen).transpose(0, 2, 1)
        )

    def _measures(self, cells: Mask | None, weight: Real | None) -> Iterator[tuple[CellGroup, Whole, Real]]:
        """Yield every group, its chosen cells, and the areas of their points times the weight, (C', Q)."""
        first, offset = 0, 0
        for group in self.groups:
            count, each = group.dx.shape
            chosen = np.arange(count) if cells is None else np.flatnonzero(cells[first : first + count])
            measure = group.dx[chosen]
            if weight is not None:
                measure = measure * weight[offset : offset + count * each].reshape(count, each)[chosen]
            first, offset = first + count, offset + count * each
            if chosen.size:
                yield group, chosen, measure

    def moments(self, derivative: str, weight: Real | None = None, cells: Mask | None = None) -> Real:
        """Integral of weight times every function or its derivative.

        Parameters
        ----------
        derivative : str
            ``x`` or ``y`` for that derivative, ``0`` for the function itself.
        weight : (Q,) ndarray, optional
            At `points`; one unless given.
        cells : (cells,) bool ndarray, optional
            All unless given.

        Returns
        -------
        (n,) ndarray
        """
        total = np.zeros(self.size)
        for group, chosen, measure in self._measures(cells, weight):
            moment = np.einsum("cnq,cq->cn", group.factor(derivative, chosen), measure)
            np.add.at(total, group.functions[chosen], moment)
        return total

    def values(self, points: Real) -> csr_matrix:
        """Functions at points (K, 2) in m: (K, n); ValueError, with the place, for a point off the mesh."""
        return self._at(points)[0]

    def slopes(self, points: Real) -> tuple[csr_matrix, csr_matrix]:
        """Differentiate the functions by x and by y at points (K, 2) in m: (K, n) each, 1/m."""
        _, by_x, by_y = self._at(points)
        return by_x, by_y

    def _at(self, points: Real) -> tuple[csr_matrix, csr_matrix, csr_matrix]:
        cell, local = self.locate(points)
        shape, quads = (len(points), self.size), len(self.mesh.quads)
        rows: list[Whole] = []
        columns: list[Whole] = []
        entries: tuple[list[Real], ...] = ([], [], [])
        for triangles, group in enumerate(self.groups):
            mine = np.flatnonzero((cell >= quads) == bool(triangles))
            if not mine.size:
                continue
            number = cell[mine] - quads * triangles
            table = (triangle_functions if triangles else quad_functions)(self.degree, local[mine].T)
            _, jacobian = map_places(self.mesh, number, local[mine].T, bool(triangles))
            slope = np.einsum("anq,qad->dnq", table.slope, np.linalg.inv(jacobian))
            sign, functions = group.sign[number], group.functions[number]
            rows.append(np.repeat(mine, functions.shape[1]))
            columns.append(functions.ravel())
            for store, entry in zip(entries, (table.value, *slope), strict=True):
                store.append((entry.T * sign).ravel())
        if not rows:
            return csr_matrix(shape), csr_matrix(shape), csr_matrix(shape)
        place = (np.concatenate(rows), np.concatenate(columns))
        value, by_x, by_y = (csr_matrix((np.concatenate(entry), place), shape=shape) for entry in entries)
        return value, by_x, by_y

    def locate(self, points: Real) -> tuple[Whole, Real]:
        """Cells (K,) in which points lie, and their reference coordinates (K, 2)."""
        points = np.asarray(points, float).reshape(-1, 2)
        found, local = np.full(len(points), -1), np.zeros((len(points), 2))
        miss = np.full(len(points), np.inf)
        for triangles in (False, True):
            low, high = boxes_of(self.mesh, triangles)
            within = (points[:, None] >= low) & (points[:, None] <= high)
            mine, number = np.nonzero(within.all(axis=2))
            if not mine.size:
                continue
            place, off = inverse_of(self.mesh, number, points[mine], triangles)
            for k in np.lexsort((-off, mine)):  # the best cell of every point comes last
                if off[k] < miss[mine[k]]:
                    miss[mine[k]], local[mine[k]] = off[k], place[k]
                    found[mine[k]] = number[k] + len(self.mesh.quads) * triangles
        outside = miss > OUTSIDE_TOLERANCE
        if outside.any():
            x, y = points[outside][0]
            raise ValueError(f"point ({x:.6g}, {y:.6g}) m is off the plate")
        return found, local

    def on_edges(self, edges: Whole) -> Mask:
        """Which functions belong to some of the mesh's edges, their ends included, (n,)."""
        chosen = np.zeros(self.size, bool)
        chosen[self.mesh.edges[edges].ravel()] = True
        chosen[self.edge_functions(edges).ravel()] = True
        return chosen

    def on_cells(self, cells: Mask) -> Mask:
        """Which functions do not vanish on some of the cells, (n,)."""
        chosen, quads = np.zeros(self.size, bool), len(self.mesh.quads)
        for group, own in zip(self.groups, (cells[:quads], cells[quads:]), strict=True):
            chosen[group.functions[own].ravel()] = True
        return chosen

    def edge_functions(self, edges: Whole) -> Whole:
        """Functions of degree 2 and more of some edges, (K, degree - 1)."""
        first = len(self.mesh.points) + np.asarray(edges)[:, None] * (self.degree - 1)
        return np.asarray(first + np.arange(self.degree - 1))

    def moved(self, shift: Real) -> "ShapeSpace":
        """Build the same functions over the mesh with its points moved by `shift` (V, 2) m."""
        return ShapeSpace.on(self.mesh.moved(shift), self.degree)
