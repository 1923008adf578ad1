"""A mesh of curved quadrilaterals and triangles with the borders of its cells; one that is being made.

Sizes of the mesh, in multiples of the plate's thickness.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

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


PER_WAVE = 0.55
"""Largest edge of a cell in bending wavelengths, for functions of degree 7. Functions of higher degree then have a
few 1e-6 of a response's energy; with 0.65, 4e-5 on a disc, and with 0.9, 2e-4 to 3e-3."""
MOST_CELLS_ACROSS = 25
"""Cells across a large plate that are enough where the waves are long: a sheet of 2 m2, 1 mm thick, would have
8300 triangles of the usual size and a million functions, for waves of 0.2 m."""


@dataclass(frozen=True)
class MeshRecipe:
    """Sizes of the mesh.

    Strips of quadrilaterals along every border resolve the shear layer of a Reissner-Mindlin plate, whose width is
    of the order of the thickness h; so their width is given in h.

    Attributes
    ----------
    spacing : float
        Largest edge of a cell of a plate 3 mm thick, m; for other plates it scales with the root of the thickness,
        like bending wavelengths. See `of_plate`.
    strip : float
        Width of the strips on both sides of the borders of patches and zones, in h.
    edge_strip : float
        Width of the strips along free and supported edges, in h.
    growth : float
        Growth of cells with the distance from a border.
    turn : float
        Largest turn of a border within a cell, rad.
    grading : float
        Share of a cell at a corner taken by its smallest part; 0: no refinement of corners.
    levels : int
        How many times cells next to a corner are refined.
    outer_corners : bool
        Whether corners of the outline are refined, too; else only those of patches and re-entrant ones.
    pieces : int
        Smallest number of cells along a side of a patch, including those at its corners.
    """

    spacing: float = 0.040
    strip: float = 0.83
    edge_strip: float = 1.0
    growth: float = 1.3
    turn: float = 0.79
    grading: float = 0.3
    levels: int = 1
    outer_corners: bool = False
    pieces: int = 3

    def __post_init__(self) -> None:
        for name, low, high in (
            ("spacing", 1e-3, 10.0),
            ("strip", 0.05, 20.0),
            ("edge_strip", 0.05, 20.0),
            ("growth", 0.1, 2.0),
            ("turn", 0.05, 1.6),
            ("grading", 0.0, 0.6),
            ("levels", 0, 20),
            ("pieces", 1, 50),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"mesh recipe: {name} is {value:g}; allowed {low:g} to {high:g}")

    @classmethod
    def of_plate(cls, area: float, thickness: float, wavelength: float) -> Self:
        """Return the usual recipe, with larger cells on large plates, at most `PER_WAVE` wavelengths.

        Parameters
        ----------
        area : float
            Of the plate, m2.
        thickness : float
            m.
        wavelength : float
            The shortest of bending waves, m.

        Returns
        -------
        MeshRecipe
        """
        unit = float((thickness / 0.003) ** 0.5)
        return cls(
            spacing=min(max(cls.spacing, area**0.5 / MOST_CELLS_ACROSS / unit), PER_WAVE * wavelength / unit)
        )

    def bulk(self, thickness: float) -> float:
        """Largest edge of a cell, m."""
        return self.spacing * float((thickness / 0.003) ** 0.5)
