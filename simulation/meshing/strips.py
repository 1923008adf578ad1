"""Strips of quadrilaterals along both sides of every border, and what they leave of each face.

Every edge is cut into pieces. A strip joins the pieces to nodes a strip's width inside the face. Where the border
turns, strips of both sides meet: at a convex corner in one kite between the feet of the two inner lines, at a
re-entrant one in kites that fan out from the corner.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from analysis.geometry.curves import Curve, turning
from simulation.meshing.arrangement import Arrangement, Face, HalfEdge, direction

Real = NDArray[np.float64]
Path = Callable[[Real], Real]
"""Points (..., 2) over a parameter in [0, 1]."""

CONVEX, REENTRANT = np.deg2rad(140.0), np.deg2rad(220.0)
"""Angles inside a face below and above which a corner gets cells of its own."""
FAN = np.deg2rad(100.0)
"""Largest turn of one kite of a fan."""
SHARE = 0.3
"""Of the free distance to the next border, or of an edge's length, that a strip may take."""
LONGEST = 2.5
"""Pieces are at most so many times as long as the face is wide there."""


@dataclass(frozen=True)
class Sizes:
    """What the strips of one edge shall be: width on each side, longest piece, least number of pieces, all in m."""

    left: float
    right: float
    longest: float
    pieces: int


@dataclass
class Cells:
    """A mesh under construction: points, quadrilaterals, curved edges and the loops left to be filled."""

    points: list[Real] = field(default_factory=list)
    quads: list[tuple[int, int, int, int]] = field(default_factory=list)
    quad_face: list[int] = field(default_factory=list)
    paths: dict[tuple[int, int], Path] = field(default_factory=dict)
    on_edge: dict[tuple[int, int], tuple[int, float, float]] = field(default_factory=dict)
    """Pieces by their two points -> edge of the arrangement and parameters at these points."""
    rings: list[list[list[int]]] = field(default_factory=list)
    """Of every face: chains of points round what is to be filled."""
    corners: set[int] = field(default_factory=set)
    """Points at which the mesh shall be graded."""

    def add(self, point: Real) -> int:
        """Append a point and return its number."""
        self.points.append(np.asarray(point, float))
        return len(self.points) - 1


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
    """

    half: HalfEdge
    curve: Curve
    place: Real
    number: list[int]
    width: Real

    def inwards(self, k: int) -> Real:
        """Unit normal to the left at the end of piece k, (2,)."""
        x, y = self.curve.derivative(self.place[k])
        return np.array([-y, x]) / np.hypot(x, y)


@dataclass(frozen=True)
class Corner:
    """The angle of a face at a node, from one half-edge to the next."""

    node: int
    before: HalfEdge
    after: HalfEdge
    angle: float


def corners_of(plan: Arrangement, face: Face) -> list[list[Corner]]:
    """Angles of a face, cycle by cycle, each between a half-edge and the next, rad."""
    found = []
    for cycle in face.cycles:
        row = []
        for before, after in zip(cycle, (*cycle[1:], cycle[0]), strict=True):
            back = direction(plan.curve(before).part(1.0, 0.0))
            ahead = direction(plan.curve(after))
            turn = np.arctan2(back[1], back[0]) - np.arctan2(ahead[1], ahead[0])
            row.append(Corner(plan.start(after), before, after, float(turn % (2 * np.pi)) or 2 * np.pi))
        found.append(row)
    return found


def strips(
    plan: Arrangement,
    faces: Mapping[int, Face],
    sizes: Mapping[int, Sizes],
    splits: Mapping[int, frozenset[float]],
) -> Cells:
    """Cut every edge and lay the strips.

    Parameters
    ----------
    plan : Arrangement
    faces : mapping
        Those to be meshed, by number.
    sizes : mapping
        By edge.
    splits : mapping
        Further parameters at which edges are to be cut, by edge.
    """
    cells = Cells()
    nodes = {k: cells.add(point) for k, point in enumerate(plan.nodes)}
    corners = {f: corners_of(plan, face) for f, face in faces.items()}
    clear = Clearance(plan, {half.edge for face in faces.values() for cycle in face.cycles for half in cycle})
    reach = _corner_reach(plan, corners, sizes, clear)
    cuts = {
        edge: _cut(plan, edge, size, reach, clear, splits.get(edge, frozenset())) for edge, size in sizes.items()
    }
    numbers = {}
    for edge, place in cuts.items():
        curve = plan.edges[edge].curve
        inner = [cells.add(point) for point in curve.at(place[1:-1])]
        numbers[edge] = [nodes[plan.edges[edge].start], *inner, nodes[plan.edges[edge].end]]
        for k, pair in enumerate(zip(numbers[edge], numbers[edge][1:], strict=False)):
            cells.paths[pair] = curve.part(place[k], place[k + 1]).at
            cells.on_edge[pair] = (edge, float(place[k]), float(place[k + 1]))
    for f, face in faces.items():
        rings = []
        for cycle, row in zip(face.cycles, corners[f], strict=True):
            sides = [_side(plan, half, sizes, cuts, numbers, clear) for half in cycle]
            rings.append(_lay(cells, sides, row, reach, f))
        cells.rings.append(rings)
    cells.corners = {
        nodes[corner.node]
        for rows in corners.values()
        for row in rows
        for corner in row
        if corner.angle > REENTRANT or (corner.angle < CONVEX and _interface(plan, corner, faces))
    }
    return cells


class Clearance:
    """Free distance to the next border, seen from one side of an edge."""

    def __init__(self, plan: Arrangement, edges: set[int]) -> None:
        samples = []
        for edge in edges:
            curve = plan.edges[edge].curve
            start, end = curve.at(0.0), curve.at(1.0)
            count = int(np.clip(np.hypot(*(end - start)) / 5e-4, 24, 400))
            samples.append(curve.at(np.linspace(0.0, 1.0, count)))
        self.points = np.vstack(samples)
        self.tree = cKDTree(self.points)
        self.largest = float(np.ptp(self.points, axis=0).max())

    def __call__(self, point: Real, normal: Real, aperture: float = 1.14) -> float:
        """Distance from `point` to the next border within `aperture` rad of `normal`, m."""
        least = np.cos(aperture)
        radius = 0.02 * self.largest
        while radius < 2.0 * self.largest:
            near = self.points[self.tree.query_ball_point(point, radius)] - point
            away = np.hypot(*near.T)
            seen = away[(near @ normal > least * away) & (away > 1e-6)]
            if seen.size:
                return float(seen.min())
            radius *= 3.0
        return self.largest


def _interface(plan: Arrangement, corner: Corner, faces: Mapping[int, Face]) -> bool:
    """Whether material lies on both sides of the edges that meet in a corner."""
    meshed = {half for face in faces.values() for cycle in face.cycles for half in cycle}
    return any(HalfEdge(h.edge, not h.backward) in meshed for h in (corner.before, corner.after))


def _width(half: HalfEdge, sizes: Mapping[int, Sizes]) -> float:
    size = sizes[half.edge]
    return size.right if half.backward else size.left


def _length(curve: Curve) -> float:
    speed = curve.derivative(np.linspace(0.0, 1.0, 33))
    return float(np.hypot(*speed.T).mean())


def _corner_reach(
    plan: Arrangement, corners: Mapping[int, list[list[Corner]]], sizes: Mapping[int, Sizes], clear: Clearance
) -> dict[int, float]:
    """Distance along the edges of every node with a corner at which its first pieces end, by node, m."""
    reach: dict[int, float] = {}
    for rows in corners.values():
        for corner in (c for row in rows for c in row):
            if CONVEX <= corner.angle <= REENTRANT:
                continue
            width = min(_width(corner.before, sizes), _width(corner.after, sizes))
            lengths = [_length(plan.curve(half)) for half in (corner.before, corner.after)]
            wanted = width / np.tan(0.5 * corner.angle) if corner.angle < CONVEX else width
            middle = direction(plan.curve(corner.after))
            half = 0.5 * corner.angle
            inwards = np.array([[np.cos(half), -np.sin(half)], [np.sin(half), np.cos(half)]]) @ middle
            free = 0.5 * clear(plan.nodes[corner.node], inwards, 0.7 * half) if corner.angle < CONVEX else np.inf
            found = min(wanted, SHARE * min(lengths), free)
            reach[corner.node] = min(reach.get(corner.node, np.inf), float(found))
    return reach


def _cut(
    plan: Arrangement,
    edge: int,
    size: Sizes,
    reach: Mapping[int, float],
    clear: Clearance,
    splits: frozenset[float],
) -> Real:
    """Parameters (n + 1,) of the ends of an edge's pieces."""
    whole = plan.edges[edge]
    curve = whole.curve
    first = _parameter(curve, reach[whole.start], 0.0) if whole.start in reach else 0.0
    last = _parameter(curve, reach[whole.end], 1.0) if whole.end in reach else 1.0
    middle = curve.part(first, last)
    extra = (first > 0.0) + (last < 1.0)
    count = max(
        1,
        int(np.ceil(_length(middle) / size.longest - 1e-6)),
        int(np.ceil(turning(middle) / 0.79 - 1e-6)),
        size.pieces - extra,
    )
    places = list(np.linspace(first, last, count + 1))
    k = 0
    while k < len(places) - 1:
        piece = curve.part(places[k], places[k + 1])
        along = piece.derivative(0.5)
        normal = np.array([-along[1], along[0]]) / np.hypot(*along)
        free = min(
            (clear(piece.at(0.5), way * normal) for way, w in ((1, size.left), (-1, size.right)) if w > 0.0),
            default=np.inf,
        )
        if _length(piece) > LONGEST * free:
            places.insert(k + 1, 0.5 * (places[k] + places[k + 1]))
        else:
            k += 1
    inner = {round(p, 12) for p in places} | set(splits)
    return np.array(sorted({0.0, 1.0} | inner))


def _parameter(curve: Curve, distance: float, end: float) -> float:
    """Parameter at a straight distance from one end of a curve."""
    start = curve.at(end)
    low, high = end, 0.5
    for _ in range(60):
        place = 0.5 * (low + high)
        low, high = (place, high) if np.hypot(*(curve.at(place) - start)) < distance else (low, place)
    return low


def _side(
    plan: Arrangement,
    half: HalfEdge,
    sizes: Mapping[int, Sizes],
    cuts: Mapping[int, Real],
    numbers: Mapping[int, list[int]],
    clear: Clearance,
) -> Side:
    curve, place, number = plan.curve(half), cuts[half.edge], numbers[half.edge]
    if half.backward:
        place, number = 1.0 - place[::-1], number[::-1]
    wanted = _width(half, sizes)
    bare = Side(half, curve, place, list(number), np.zeros(len(place)))
    width = [
        min(wanted, SHARE * clear(curve.at(t), bare.inwards(k))) if 0 < k < len(place) - 1 else wanted
        for k, t in enumerate(place)
    ]
    return Side(half, curve, place, list(number), np.array(width))


def _lay(cells: Cells, sides: list[Side], corners: list[Corner], reach: Mapping[int, float], face: int) -> list[int]:
    """Lay the strip of one cycle; return the ring of its inner points.

    `corners[k]` lies between `sides[k]` and the next one.
    """
    inner: list[dict[int, int]] = [{} for _ in sides]
    fans: list[list[int]] = []
    for k, corner in enumerate(corners):
        before, after = sides[k], sides[(k + 1) % len(sides)]
        into, out = inner[k], inner[(k + 1) % len(sides)]
        n = len(before.place) - 1
        point = cells.points[after.number[0]]
        if corner.angle < CONVEX:
            into[n - 1] = out[1] = cells.add(_kite_tip(before, after))
            _quad(cells, (after.number[0], after.number[1], out[1], before.number[n - 1]), face)
            fans.append([])
        elif corner.angle <= REENTRANT:
            width = min(before.width[-2:].min(), after.width[:2].min())
            normal = before.inwards(n) + after.inwards(0)
            normal /= np.hypot(*normal)
            into[n] = out[0] = cells.add(point + width / np.sin(0.5 * corner.angle) * normal)
            fans.append([])
        else:
            fans.append(_fan(cells, before, after, corner, reach[corner.node], (into, out), face))
    ring: list[int] = []
    for k, side in enumerate(sides):
        ends = sorted(inner[k])
        for i in range(ends[0] + 1, ends[-1]):
            inner[k][i] = cells.add(side.curve.at(side.place[i]) + side.width[i] * side.inwards(i))
        order = sorted(inner[k])
        for i, j in zip(order, order[1:], strict=False):
            _quad(cells, (side.number[i], side.number[j], inner[k][j], inner[k][i]), face)
            _parallel(cells, side, i, (inner[k][i], inner[k][j]))
        for number in (*(inner[k][i] for i in order), *fans[k]):
            if not ring or ring[-1] != number:
                ring.append(number)
    if len(ring) > 1 and ring[0] == ring[-1]:
        ring.pop()
    return ring


def _kite_tip(before: Side, after: Side) -> Real:
    """Where the inner lines of two sides meet inside a convex corner: over the feet at their first cuts."""
    a, b = before.curve.at(before.place[-2]), after.curve.at(after.place[1])
    lines = np.column_stack([before.inwards(len(before.place) - 2), -after.inwards(1)])
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
    width = min(before.width[-1], after.width[0], reach)
    start = before.inwards(len(before.place) - 1)

    def at(share: float, distance: float) -> int:
        c, s = np.cos(-turn * share), np.sin(-turn * share)
        return cells.add(point + distance * np.array([c * start[0] - s * start[1], s * start[0] + c * start[1]]))

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
    """Let the inner line of a strip follow a curved border, its ends where they are."""
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
