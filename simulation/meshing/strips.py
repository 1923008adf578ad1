"""Strips of quadrilaterals along both sides of every border, divided along it, and rings around each face.

A strip joins the pieces of an edge to nodes a strip's width inside the face. Where the border turns, strips of
both sides meet: at a convex corner in one kite between the feet of the two inner lines, at a re-entrant one in
kites that fan out from the corner.

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
from analysis.geometry.loop import Curve, turning
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
from simulation.meshing.plate_mesh import Cells, Foot, Repairs, Stretch

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


FAN = np.deg2rad(100.0)
"""Largest turn of one kite of a fan."""


def strips(cutter: Cutter, repairs: Repairs) -> Cells:
    """Cut every edge and add the strips along it."""
    plan, cells = cutter.plan, Cells()
    for point in plan.nodes:
        cells.add(point)
    reach = cutter.reaches(repairs)
    cuts = {edge: cutter.cut(edge, reach, repairs) for edge in cutter.sizes}
    numbers = {}
    for edge, place in cuts.items():
        curve = plan.edges[edge].curve
        inner = [cells.add(point) for point in curve.at(place[1:-1])]
        numbers[edge] = [plan.edges[edge].start, *inner, plan.edges[edge].end]
        straight = turning(curve) == 0.0
        for k, pair in enumerate(pairwise(numbers[edge])):
            if not straight:
                cells.paths[pair] = curve.part(place[k], place[k + 1]).at
            cells.on_edge[pair] = (edge, float(place[k]), float(place[k + 1]))
    for f, face in cutter.faces.items():
        rings = []
        for cycle, row in zip(face.cycles, cutter.corners[f], strict=True):
            sides = [cutter.side(half, cuts[half.edge], numbers[half.edge], repairs) for half in cycle]
            corners = [(corner, repairs.closed(corner)) for corner in row]
            rings.append(_strip_of_cycle(cells, sides, corners, reach, f))
        cells.rings.append(rings)
    cells.corners = _to_grade(cutter)
    return cells


def _to_grade(cutter: Cutter) -> dict[int, bool]:
    """Corners of patches and of the plate itself, see `Cells.corners`."""
    meshed = {half for face in cutter.faces.values() for cycle in face.cycles for half in cycle}
    found: dict[int, bool] = {}
    for corner in (c for rows in cutter.corners.values() for row in rows for c in row):
        if CONVEX <= corner.angle <= REENTRANT:
            continue
        sides = (corner.before, corner.after)
        between = any(HalfEdge(half.edge, not half.backward) in meshed for half in sides)
        outer = corner.angle < CONVEX and not between
        found[corner.node] = found.get(corner.node, True) and outer
    return found


def _strip_of_cycle(
    cells: Cells, sides: list[Side], corners: list[tuple[Corner, bool]], reach: Mapping[int, float], face: int
) -> list[int]:
    """Add the strip of one cycle to the cells; return the ring of its inner points.

    `corners[k]` is between `sides[k]` and the next one; its flag says whether strips end there.
    """
    inner: list[dict[int, int]] = [{} for _ in sides]
    beyond: list[list[int]] = []
    kites: list[bool] = []
    for k, (corner, closed) in enumerate(corners):
        after = (k + 1) % len(sides)
        strips_meet = not (closed or sides[k].bare[-1] or sides[after].bare[0])
        kites.append(strips_meet and corner.angle < CONVEX)
        pair, ends = (sides[k], sides[after]), (inner[k], inner[after])
        between = _corner(cells, pair, corner, reach, ends, face) if strips_meet else []
        beyond.append(between)
    ring: list[int] = []
    for k, side in enumerate(sides):
        last = len(side.place) - 1
        for i in range(1, last):
            if i not in inner[k] and not side.bare[i - 1 : i + 1].any():
                inner[k][i] = cells.add(side.curve.at(side.place[i]) + side.width[i] * side.inwards(i))
                pieces = (side.stretch(i - 1), side.stretch(i))
                cells.foot[inner[k][i]] = Foot(float(side.width[i]), side.number[i], pieces)
        for i in range(int(kites[k - 1]), last - int(kites[k])):
            ring += _piece(cells, side, i, inner[k], face)
        ring += beyond[k]
    return [number for k, number in enumerate(ring) if number != ring[k - 1]]


def _corner(
    cells: Cells,
    sides: tuple[Side, Side],
    corner: Corner,
    reach: Mapping[int, float],
    inner: tuple[dict[int, int], dict[int, int]],
    face: int,
) -> list[int]:
    """Join the strips of the two sides of a corner; return the points between the ends of their inner lines.

    `inner` holds the inner points of the two strips, by the cut of the border, and gets those at the corner.
    """
    before, after = sides
    into, out = inner
    n = len(before.place) - 1
    pieces = (before.stretch(n - 1), after.stretch(0))
    if corner.angle < CONVEX:
        into[n - 1] = out[1] = tip = cells.add(_kite_tip(before, after))
        width = reach[corner.node] * float(np.tan(0.5 * corner.angle))
        cells.foot[tip] = Foot(width, corner.node, pieces)
        _quad(cells, (after.number[0], after.number[1], tip, before.number[n - 1]), face)
        return [before.number[n - 1]] * bool(before.bare[-2]) + [tip] + [after.number[1]] * bool(after.bare[1])
    if corner.angle <= REENTRANT:
        width = float(min(before.width[-2:].min(), after.width[:2].min()))
        normal = before.inwards(n) + after.inwards(0)
        normal *= width / np.sin(0.5 * corner.angle) / np.hypot(*normal)
        into[n] = out[0] = cells.add(cells.points[corner.node] + normal)
        cells.foot[into[n]] = Foot(width, corner.node, pieces)
        return []
    return _fan(cells, before, after, corner, reach[corner.node], inner, face)


def _piece(cells: Cells, side: Side, i: int, inner: Mapping[int, int], face: int) -> tuple[int, int]:
    """Add one piece of a strip; return the two points in which its inner side ends.

    At the beginning and end of a strip a piece is a triangle; without a strip it is the border itself.
    """
    a, b = side.number[i], side.number[i + 1]
    if side.bare[i] or not (i in inner or i + 1 in inner):
        return a, b
    pair = (inner.get(i, a), inner.get(i + 1, b))
    cells.inner[min(pair), max(pair)] = (b, a) if side.half.backward else (a, b)
    if i in inner and i + 1 in inner:
        _quad(cells, (a, b, pair[1], pair[0]), face)
        _parallel(cells, side, i, pair)
    else:
        cells.wedges.append((a, b, pair[1] if i + 1 in inner else pair[0]))
        cells.wedge_face.append(face)
    return pair


def _kite_tip(before: Side, after: Side) -> Real:
    """Point where the inner lines of two sides meet inside a convex corner, above their first cuts."""
    a, b = before.curve.at(before.place[-2]), after.curve.at(after.place[1])
    lines = np.column_stack([before.inwards(len(before.place) - 2), -after.inwards(1)])
    if abs(np.linalg.det(lines)) < 1e-3:
        return np.asarray(0.5 * (a + b))
    share = np.linalg.solve(lines, b - a)
    return np.asarray(a + share[0] * lines[:, 0])


def _fan(
    cells: Cells,
    before: Side,
    after: Side,
    corner: Corner,
    reach: float,
    inner: tuple[dict[int, int], dict[int, int]],
    face: int,
) -> list[int]:
    """Kites around a re-entrant corner; return the points between the two sides' inner ends."""
    turn = corner.angle - np.pi
    count = int(np.ceil(turn / FAN))
    point, number = cells.points[after.number[0]], after.number[0]
    width = float(min(before.width[-1], after.width[0], reach))
    start = before.inwards(len(before.place) - 1)
    pieces = (before.stretch(len(before.place) - 2), after.stretch(0))

    def at(share: float, distance: float) -> int:
        c, s = np.cos(-turn * share), np.sin(-turn * share)
        found = cells.add(point + distance * np.array([c * start[0] - s * start[1], s * start[0] + c * start[1]]))
        cells.foot[found] = Foot(width, number, pieces)
        return found

    ends = [at(k / count, width) for k in range(count + 1)]
    tips = [at((k + 0.5) / count, width / np.cos(0.5 * turn / count)) for k in range(count)]
    between = [tips[0]]
    for k in range(count):
        _quad(cells, (number, ends[k + 1], tips[k], ends[k]), face)
        if k:
            between += [ends[k], tips[k]]
    inner[0][len(before.place) - 1], inner[1][0] = ends[0], ends[-1]
    return between


def _quad(cells: Cells, quad: tuple[int, int, int, int], face: int) -> None:
    cells.quads.append(quad)
    cells.quad_face.append(face)


def _parallel(cells: Cells, side: Side, k: int, pair: tuple[int, int]) -> None:
    """Curve the inner line of a strip parallel to a curved border, with its ends unchanged."""
    piece = side.curve.part(side.place[k], side.place[k + 1])
    if turning(piece) == 0.0:
        return
    start, end = cells.points[pair[0]], cells.points[pair[1]]
    first, last = piece.at(0.0), piece.at(1.0)
    scale = np.hypot(*(end - start)) / np.hypot(*(last - first))

    def path(t: Real) -> Real:
        t = np.asarray(t, float)[..., None]
        bow = piece.at(t[..., 0]) - (first + t * (last - first))
        return np.asarray(start + t * (end - start) + scale * bow)

    cells.paths[pair] = path


def length_of(curve: Curve) -> float:
    """Length of a curve, m, with a relative error of about 1e-4."""
    along = curve.derivative(np.linspace(0.0, 1.0, 33))
    return float(np.sqrt((along**2).sum(axis=1)).mean())


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
