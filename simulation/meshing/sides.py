"""Division of the edges of faces into pieces, and widths of the strips along them.

The length of pieces is limited by the longest piece allowed, by the edge's turn, and by the free distance to the
next border. At a corner the first piece on both sides is as long as the strips are wide, so that the strips meet.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from analysis.arrays import Real
from analysis.geometry.curves import Curve, turning
from simulation.meshing.arrangement import (
    CONVEX,
    REENTRANT,
    Arrangement,
    Corner,
    Face,
    HalfEdge,
    corners_of,
    direction,
)
from simulation.meshing.cells import Repairs, Stretch

WIDEST_STRIP = 0.3
"""Largest width of a strip, as a share of the free distance to the next border, or of an edge's length."""
LONGEST_PIECE = 2.5
"""Largest length of a piece, relative to the local width of the face."""


@dataclass(frozen=True)
class Sizes:
    """Sizes of the strips of one edge.

    Attributes
    ----------
    left, right : float
        Width on each side, m; 0 where nothing is meshed.
    longest : float
        Largest length of its pieces, m.
    turn : float
        Largest turn of a piece, rad.
    pieces : int
        Smallest number of pieces.
    """

    left: float
    right: float
    longest: float
    turn: float
    pieces: int


@dataclass(frozen=True)
class Side:
    """One half-edge cut into pieces.

    Attributes
    ----------
    half : HalfEdge
    curve : Curve
        In the half-edge's direction.
    place : (n + 1,) ndarray
        Parameters of the pieces' ends.
    number : list of int
        Their points in the mesh.
    width : (n + 1,) ndarray
        Of the strip on the left there, m.
    bare : (n,) ndarray of bool
        Pieces without a strip.
    """

    half: HalfEdge
    curve: Curve
    place: Real
    number: list[int]
    width: Real
    bare: NDArray[np.bool_]

    def stretch(self, piece: int) -> Stretch:
        """Return where a piece lies on its edge."""
        ends = self.place[piece : piece + 2]
        first, last = 1.0 - ends[::-1] if self.half.backward else ends
        return Stretch(self.half, float(first), float(last))

    def inwards(self, k: int) -> Real:
        """Return the unit normal to the left at the end of piece k, (2,)."""
        return _left(self.curve, self.place[k])


HALF_APERTURE = 1.14
"""Half of the angle in which the next border is searched, rad."""


class Clearance:
    """Free distance from a point to the next border in some direction."""

    def __init__(self, plan: Arrangement, edges: set[int]) -> None:
        samples = []
        for edge in edges:
            curve = plan.edges[edge].curve
            count = int(np.clip(length_of(curve) / 1e-3, 24, 400))
            samples.append(curve.at(np.linspace(0.0, 1.0, count)))
        self.points = np.vstack(samples)
        self.tree = cKDTree(self.points)
        self.largest = float(np.ptp(self.points, axis=0).max())

    def __call__(self, point: Real, normal: Real, aperture: float = HALF_APERTURE, reach: float = np.inf) -> float:
        """Distance from `point` to the next border within `aperture` rad of `normal`, at most `reach`, m."""
        least = np.cos(aperture)
        radius = min(0.02 * self.largest, reach)
        while True:
            near = self.points[self.tree.query_ball_point(point, radius)] - point
            away = np.sqrt((near**2).sum(axis=1))
            seen = away[(near @ normal > least * away) & (away > 1e-6)]
            if seen.size:
                return float(seen.min())
            if radius >= min(reach, self.largest):
                return float(min(reach, self.largest))
            radius = min(3.0 * radius, reach)


def length_of(curve: Curve) -> float:
    """Length of a curve, m, with a relative error of about 1e-4."""
    along = curve.derivative(np.linspace(0.0, 1.0, 33))
    return float(np.sqrt((along**2).sum(axis=1)).mean())


@dataclass(frozen=True)
class Cutter:
    """Data for cutting the edges of an arrangement, with caches."""

    plan: Arrangement
    faces: Mapping[int, Face]
    sizes: Mapping[int, Sizes]
    clear: Clearance
    corners: Mapping[int, list[list[Corner]]]
    known: dict[tuple[HalfEdge, float], float] = field(default_factory=dict)
    """Cache of free distances beside half-edges, by parameter: most are needed again in every round."""
    places: dict[tuple[int, float, float, frozenset[float]], Real] = field(default_factory=dict)
    """Cuts by edge, ends of the first and the last piece, and further cuts."""

    @classmethod
    def of(cls, plan: Arrangement, faces: Mapping[int, Face], sizes: Mapping[int, Sizes]) -> "Cutter":
        """Prepare corners and free distances, which do not change from round to round.

        Parameters
        ----------
        faces : mapping of int to Face
            Those to be meshed.
        sizes : mapping of int to Sizes
            Of every edge.
        """
        edges = {half.edge for face in faces.values() for cycle in face.cycles for half in cycle}
        corners = {f: corners_of(plan, face) for f, face in faces.items()}
        return cls(plan, faces, sizes, Clearance(plan, edges), corners)

    def width(self, half: HalfEdge) -> float:
        """Desired width of the strip to the left of a half-edge, m."""
        size = self.sizes[half.edge]
        return size.right if half.backward else size.left

    def reaches(self, repairs: Repairs) -> dict[int, float]:
        """Distance along the edges of every node with a corner at which its first pieces end, by node, m."""
        reach: dict[int, float] = {}
        for corner in (c for rows in self.corners.values() for row in rows for c in row):
            if not CONVEX <= corner.angle <= REENTRANT and not repairs.closed(corner):
                found = self._reach(corner, repairs)
                reach[corner.node] = min(reach.get(corner.node, np.inf), found)
        return reach

    def _reach(self, corner: Corner, repairs: Repairs) -> float:
        point = self.plan.nodes[corner.node]
        width = min(self.width(corner.before), self.width(corner.after), float(repairs.widest(point)))
        lengths = [length_of(self.plan.curve(half)) for half in (corner.before, corner.after)]
        x, y = direction(self.plan.curve(corner.after))
        c, s = np.cos(0.5 * corner.angle), np.sin(0.5 * corner.angle)
        inwards = np.array([c * x - s * y, s * x + c * y])
        if corner.angle < CONVEX:
            wanted, free = width / np.tan(0.5 * corner.angle), self.clear(point, inwards, 0.35 * corner.angle)
            return float(min(wanted, WIDEST_STRIP * min(lengths), 0.5 * free))
        free = self.clear(point, inwards, 0.5 * corner.angle - 0.5, 4.0 * width)
        return min(width, WIDEST_STRIP * min(lengths), WIDEST_STRIP * free)

    def cut(self, edge: int, reach: Mapping[int, float], repairs: Repairs) -> Real:
        """Cut an edge into pieces.

        Parameters
        ----------
        reach : mapping of int to float
            Length of the first piece next to a corner, m, by the number of the corner's node.

        Returns
        -------
        (n + 1,) ndarray
            Parameters of the ends of the n pieces, 0 to 1, ascending.
        """
        whole, size = self.plan.edges[edge], self.sizes[edge]
        curve = whole.curve
        first = _parameter(curve, reach[whole.start], 0.0) if whole.start in reach else 0.0
        last = _parameter(curve, reach[whole.end], 1.0) if whole.end in reach else 1.0
        key = (edge, first, last, repairs.splits.get(edge, frozenset()))
        if key not in self.places:
            self.places[key] = self._cut(size, curve, first, last, key[3])
        return self.places[key]

    def _cut(self, size: Sizes, curve: Curve, first: float, last: float, splits: frozenset[float]) -> Real:
        middle = curve.part(first, last)
        count = max(
            1,
            int(np.ceil(length_of(middle) / size.longest - 1e-6)),
            int(np.ceil(turning(middle) / size.turn - 1e-6)),
            size.pieces - (first > 0.0) - (last < 1.0),
        )
        places = list(np.linspace(first, last, count + 1))
        k = 0
        while k < len(places) - 1:
            piece = curve.part(places[k], places[k + 1])
            long, normal = length_of(piece), _left(piece, 0.5)
            ways = [way for way, width in ((1, size.left), (-1, size.right)) if width > 0.0]
            free = min((self.clear(piece.at(0.5), way * normal, reach=long) for way in ways), default=np.inf)
            if long > LONGEST_PIECE * free:
                places.insert(k + 1, 0.5 * (places[k] + places[k + 1]))
            else:
                k += 1
        inner = {round(p, 12) for p in places} | splits
        return np.array(sorted({0.0, 1.0} | inner))

    def side(self, half: HalfEdge, cut: Real, number: list[int], repairs: Repairs) -> Side:
        """One side of an edge, with the width of its strip at every cut.

        Parameters
        ----------
        cut : (n + 1,) ndarray
            Parameters of the ends of the edge's pieces, 0 to 1, in the edge's own direction.
        number : list of int
            Numbers of the n + 1 points there.

        Returns
        -------
        Side
            In the direction of `half`, widths in m.
        """
        curve, wanted = self.plan.curve(half), self.width(half)
        bare = np.array([repairs.without_strip(half, 0.5 * (a + b)) for a, b in pairwise(cut)])
        if half.backward:
            cut, number, bare = 1.0 - cut[::-1], number[::-1], bare[::-1]
        points = curve.at(cut)
        width = np.minimum(wanted, repairs.widest(points))
        for k in range(1, len(cut) - 1):
            key = (half, float(cut[k]))
            if key not in self.known:
                self.known[key] = self.clear(points[k], _left(curve, cut[k]), reach=wanted / WIDEST_STRIP)
            width[k] = min(width[k], WIDEST_STRIP * self.known[key])
        return Side(half, curve, cut, list(number), width, bare)


def _left(curve: Curve, place: float) -> Real:
    x, y = curve.derivative(place)
    return np.asarray(np.array([-y, x]) / np.hypot(x, y))


def _parameter(curve: Curve, distance: float, end: float) -> float:
    """Parameter at a straight distance from one end of a curve."""
    start = curve.at(end)
    low, high = end, 0.5
    for _ in range(40):
        place = 0.5 * (low + high)
        x, y = curve.at(place) - start
        low, high = (place, high) if x * x + y * y < distance**2 else (low, place)
    return low
