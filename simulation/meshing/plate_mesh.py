"""A mesh of curved quadrilaterals and triangles with the borders of its cells; one that is being made."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real, Whole
from simulation.meshing.arrangement import Corner, HalfEdge

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


Path = Callable[[Real], Real]
"""Points (..., 2) over a parameter in [0, 1]."""


@dataclass(frozen=True)
class Stretch:
    """A part of one side of an edge, between two ascending parameters of the edge's curve."""

    half: HalfEdge
    first: float
    last: float


@dataclass(frozen=True)
class Cap:
    """A place, (x, y) m, near which strips were too wide, and the largest width there, m."""

    place: tuple[float, float]
    width: float


@dataclass(frozen=True)
class Repairs:
    """Changes from earlier rounds of meshing.

    Attributes
    ----------
    splits : mapping
        Further parameters at which edges are cut, by edge.
    caps : tuple of Cap
    bare : frozenset of Stretch
        Parts of borders without a strip.
    """

    splits: Mapping[int, frozenset[float]]
    caps: tuple[Cap, ...]
    bare: frozenset[Stretch]

    def without_strip(self, half: HalfEdge, place: float) -> bool:
        """Whether the strip to the left of a half-edge is left out at a parameter of its edge's curve."""
        return any(s.half == half and s.first - 1e-9 <= place <= s.last + 1e-9 for s in self.bare)

    def closed(self, corner: Corner) -> bool:
        """Whether strips end at a corner, because one of them is left out there."""
        ends = ((corner.before, not corner.before.backward), (corner.after, corner.after.backward))
        return any(self.without_strip(half, float(at_end)) for half, at_end in ends)

    def widest(self, places: Real) -> Real:
        """Largest width of strips allowed at places (..., 2), (...), m."""
        found = np.full(np.shape(places)[:-1], np.inf)
        for cap in self.caps:
            away = np.asarray(places) - np.asarray(cap.place)
            found = np.minimum(found, cap.width + 0.4 * np.hypot(away[..., 0], away[..., 1]))
        return found


@dataclass(frozen=True)
class Foot:
    """Origin of an inner point of a strip.

    Attributes
    ----------
    width : float
        Of the strip there, m.
    point : int
        Of the border.
    pieces : tuple of Stretch
        Pieces of the strip on both sides of it.
    """

    width: float
    point: int
    pieces: tuple[Stretch, ...]


@dataclass
class Cells:
    """A mesh under construction: points, quadrilaterals, curved edges and the loops left to be filled."""

    points: list[Real] = field(default_factory=list)
    quads: list[tuple[int, int, int, int]] = field(default_factory=list)
    quad_face: list[int] = field(default_factory=list)
    paths: dict[tuple[int, int], Path] = field(default_factory=dict)
    """Curved edges, by their two points."""
    on_edge: dict[tuple[int, int], tuple[int, float, float]] = field(default_factory=dict)
    """Pieces by their two points -> edge of the arrangement and parameters at these points."""
    rings: list[list[list[int]]] = field(default_factory=list)
    """Rings of points around the area to be filled, by face."""
    inner: dict[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    """Sides of rings, ascending -> the piece from which their strip starts."""
    foot: dict[int, Foot] = field(default_factory=dict)
    """Origin of every inner point of a strip."""
    wedges: list[tuple[int, int, int]] = field(default_factory=list)
    """Triangles in which strips end."""
    wedge_face: list[int] = field(default_factory=list)
    corners: dict[int, bool] = field(default_factory=dict)
    """Points at which the mesh can be graded -> whether it is a convex corner of the plate alone."""

    def add(self, point: Real) -> int:
        """Append a point and return its number."""
        self.points.append(np.asarray(point, float))
        return len(self.points) - 1
