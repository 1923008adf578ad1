"""A mesh under construction: points, quadrilaterals, and the loops around the area left to be filled."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Real
from simulation.meshing.arrangement import Corner, HalfEdge

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
