"""A mesh of curved quadrilaterals and triangles, with the borders of its cells and edges."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real, Whole

CURVE_DEGREE = 8
"""Polynomial degree of curved edges."""


@dataclass(frozen=True)
class BorderEdges:
    """Mesh edges along one border.

    Attributes
    ----------
    edge : (K,) ndarray of int
    curve : (K,) ndarray of int
        Curve of the border's loop on which each lies.
    span : (K, 2) ndarray
        Parameters of that curve at the edge's first and second point.
    """

    edge: Whole
    curve: Whole
    span: Real


@dataclass(frozen=True)
class PlateMesh:
    """Cells of one plate.

    Cells are counted quadrilaterals first. An edge runs from its point of lower number to the other.

    Attributes
    ----------
    points : (V, 2) ndarray
        m.
    quads : (Q, 4) ndarray of int
    triangles : (T, 3) ndarray of int
        Points, counter-clockwise.
    edges : (E, 2) ndarray of int
        Points, ascending.
    bow : (E, CURVE_DEGREE - 1, 2) ndarray
        Coefficients of the hierarchical functions of degree 2 to `CURVE_DEGREE` that turn straight edges into
        curved ones, m.
    inside : mapping from border to (Q + T,) ndarray of bool
        Cells that each border encloses.
    borders : mapping
        `BorderEdges` of each border, by its name.
    """

    points: Real
    quads: Whole
    triangles: Whole
    edges: Whole
    bow: Real
    inside: dict[str, NDArray[np.bool_]]
    borders: dict[str, BorderEdges]

    @property
    def cells(self) -> int:
        """Number of cells."""
        return len(self.quads) + len(self.triangles)

    @cached_property
    def quad_edges(self) -> Whole:
        """Edges 0-1, 1-2, 2-3, 3-0 of every quadrilateral, (Q, 4)."""
        return self._lookup(self.quads, ((0, 1), (1, 2), (2, 3), (3, 0)))

    @cached_property
    def triangle_edges(self) -> Whole:
        """Edges 0-1, 1-2, 2-0 of every triangle, (T, 3)."""
        return self._lookup(self.triangles, ((0, 1), (1, 2), (2, 0)))

    def _lookup(self, cells: Whole, pairs: tuple[tuple[int, int], ...]) -> Whole:
        key = self.edges[:, 0] * len(self.points) + self.edges[:, 1]
        columns = []
        for a, b in pairs:
            low, high = np.minimum(cells[:, a], cells[:, b]), np.maximum(cells[:, a], cells[:, b])
            columns.append(np.searchsorted(key, low * len(self.points) + high))
        return np.column_stack(columns).reshape(len(cells), len(pairs))

    @cached_property
    def centers(self) -> Real:
        """Mean of every cell's corners, (cells, 2), m."""
        return np.vstack([self.points[self.quads].mean(axis=1), self.points[self.triangles].mean(axis=1)])

    def moved(self, shift: Real) -> "PlateMesh":
        """Move every point by `shift` (V, 2) m; curved edges keep their bow."""
        return replace(self, points=self.points + shift)


def edges_of(quads: Whole, triangles: Whole) -> Whole:
    """All edges of the cells, (E, 2), ascending."""
    pairs = [quads[:, [k, (k + 1) % 4]] for k in range(4)] + [triangles[:, [k, (k + 1) % 3]] for k in range(3)]
    return np.asarray(np.unique(np.sort(np.vstack(pairs), axis=1), axis=0), dtype=np.int64)
