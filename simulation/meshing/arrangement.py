"""Borders of a plate as a planar graph: where they cross, nodes, edges, and the faces between them.

Borders may cross, touch along a common line or lie on each other (patches on both faces): every edge has a list of
the borders that it is part of, every face one of the borders that enclose it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.geometry.loop import Curve, GeometryError, Loop, at, turning

MERGED_DISTANCE = 1e-7
"""Points closer than this are merged, m."""
CHORD = np.deg2rad(4.0)
"""Largest turn of a curve per side of its polyline, rad."""
TANGENT_SINE = 1e-4
"""Sine of the angle below which curves count as tangent, not crossing."""


@dataclass(frozen=True)
class EdgeOrigin:
    """Part of a border that an edge coincides with.

    Attributes
    ----------
    border : int
    curve : int
        Of the border's loop.
    first, last : float
        Parameters of the curve at the edge's start and end: descending where the edge runs against the border.
    """

    border: int
    curve: int
    first: float
    last: float

    @property
    def forward(self) -> bool:
        """Whether the edge has the direction of its border, whose inside is on its left."""
        return self.last > self.first


@dataclass(frozen=True)
class Edge:
    """A smooth curve between two nodes, without a node in between."""

    start: int
    end: int
    curve: Curve
    origins: tuple[EdgeOrigin, ...]


@dataclass(frozen=True)
class HalfEdge:
    """One side of an edge, the one to its left; backward if it runs from the edge's end to its start."""

    edge: int
    backward: bool


@dataclass(frozen=True)
class Face:
    """A connected part of the plane between borders.

    Attributes
    ----------
    cycles : tuple of tuples of HalfEdge
        Its boundaries, the face to the left: the outer one first.
    inside : frozenset of int
        Borders that enclose it.
    """

    cycles: tuple[tuple[HalfEdge, ...], ...]
    inside: frozenset[int]


@dataclass(frozen=True)
class Arrangement:
    """Nodes (N, 2) [m], edges and bounded faces."""

    nodes: Real
    edges: tuple[Edge, ...]
    faces: tuple[Face, ...]

    @classmethod
    def of(cls, borders: Sequence[Loop], extra_nodes: Sequence[tuple[float, float]] = ()) -> "Arrangement":
        """Cut borders at each other and at `extra_nodes` that lie on them, and find the faces."""
        nodes, edges = _edges(borders, cuts_of(borders, np.asarray(extra_nodes, float).reshape(-1, 2)))
        return cls(nodes, edges, _faces(nodes, edges, borders))

    def curve(self, half: HalfEdge) -> Curve:
        """Curve of a half-edge, in its direction."""
        curve = self.edges[half.edge].curve
        return curve.part(1.0, 0.0) if half.backward else curve

    def start(self, half: HalfEdge) -> int:
        """Node at which a half-edge begins."""
        edge = self.edges[half.edge]
        return edge.end if half.backward else edge.start


def direction(curve: Curve) -> Real:
    """Return the unit tangent at a curve's start, (2,)."""
    step = curve.derivative(0.0)
    if np.hypot(*step) < 1e-9:
        step = curve.at(1e-3) - curve.at(0.0)
    return np.asarray(step / np.hypot(*step))


def _edges(borders: Sequence[Loop], cuts: list[list[list[float]]]) -> tuple[Real, tuple[Edge, ...]]:
    """Nodes and edges; coincident pieces become one edge with several origins."""
    nodes: list[Real] = []

    def node(point: Real) -> int:
        if nodes:
            away = np.hypot(*(np.array(nodes) - point).T)
            if away.min() < 2.0 * MERGED_DISTANCE:
                return int(away.argmin())
        nodes.append(point)
        return len(nodes) - 1

    edges: list[Edge] = []
    for b, loop in enumerate(borders):
        for c, curve in enumerate(loop.curves):
            places = sorted(cuts[b][c])
            for first, last in pairwise(places):
                piece = curve.part(first, last)
                start, end = node(piece.at(0.0)), node(piece.at(1.0))
                if start == end and np.hypot(*(piece.at(0.5) - piece.at(0.0))) < 2.0 * MERGED_DISTANCE:
                    continue
                middle = piece.at(0.5)
                known = next(
                    (
                        k
                        for k, edge in enumerate(edges)
                        if {edge.start, edge.end} == {start, end}
                        and np.hypot(*(edge.curve.at(0.5) - middle)) < 10.0 * MERGED_DISTANCE
                    ),
                    None,
                )
                if known is None:
                    edges.append(Edge(start, end, piece, (EdgeOrigin(b, c, first, last),)))
                    continue
                old = edges[known]
                way = (first, last) if old.start == start else (last, first)
                edges[known] = Edge(old.start, old.end, old.curve, (*old.origins, EdgeOrigin(b, c, *way)))
    return np.array(nodes), tuple(edges)


def _faces(nodes: Real, edges: tuple[Edge, ...], borders: Sequence[Loop]) -> tuple[Face, ...]:
    """Trace every half-edge round its face; clockwise boundaries are holes of the face around them."""
    follows = _next(nodes, edges)
    seen: set[HalfEdge] = set()
    outer: list[tuple[tuple[HalfEdge, ...], Real, float]] = []
    inner: list[tuple[tuple[HalfEdge, ...], Real]] = []
    for first in follows:
        if first in seen:
            continue
        walk = [first]
        while follows[walk[-1]] != first:
            walk.append(follows[walk[-1]])
        seen.update(walk)
        polygon = np.vstack([_walk(edges, half) for half in walk])
        x, y = polygon.T
        area = 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        if area > 0.0:
            outer.append((tuple(walk), polygon, area))
        else:
            inner.append((tuple(walk), polygon))
    found: list[list[tuple[HalfEdge, ...]]] = [[cycle] for cycle, _, _ in outer]
    for cycle, polygon in inner:
        around = [
            (area, k)
            for k, (other, shape, area) in enumerate(outer)
            if not {half.edge for half in cycle} & {half.edge for half in other} and _within(polygon, shape)
        ]
        if around:
            found[min(around)[1]].append(cycle)
    return tuple(Face(tuple(cycles), _enclosing(edges, cycles[0][0], borders)) for cycles in found)


def _next(nodes: Real, edges: tuple[Edge, ...]) -> dict[HalfEdge, HalfEdge]:
    """Return the half-edge that follows each one round the face on its left."""
    leaving: dict[int, list[tuple[float, HalfEdge]]] = {k: [] for k in range(len(nodes))}
    for k, edge in enumerate(edges):
        for backward, node in ((False, edge.start), (True, edge.end)):
            way = direction(edge.curve.part(1.0, 0.0) if backward else edge.curve)
            leaving[node].append((float(np.arctan2(way[1], way[0])), HalfEdge(k, backward)))
    follows = {}
    for node, star in leaving.items():
        star.sort(key=lambda entry: entry[0])
        for (angle, half), (before, other) in zip(star, star[-1:] + star[:-1], strict=True):
            if len(star) > 1 and abs(angle - before) < 1e-3 and half != other:
                x, y = nodes[node]
                raise GeometryError(
                    f"two borders touch without crossing at {at((x, y))}; move one of them by a millimetre", (x, y)
                )
            follows[HalfEdge(half.edge, not half.backward)] = other
    return follows


def _walk(edges: tuple[Edge, ...], half: HalfEdge) -> Real:
    points = polyline(edges[half.edge].curve)[1]
    return points[:0:-1] if half.backward else points[:-1]


def _within(polygon: Real, shape: Real) -> bool:
    """Whether a polygon lies inside another: most of its points do."""
    return bool(np.mean(inside(polygon, shape, np.roll(shape, -1, axis=0))) > 0.5)


def _enclosing(edges: tuple[Edge, ...], half: HalfEdge, borders: Sequence[Loop]) -> frozenset[int]:
    """Borders that enclose what lies to the left of a half-edge."""
    edge = edges[half.edge]
    sides = {origin.border: origin.forward != half.backward for origin in edge.origins}
    middle = edge.curve.at(0.5)[None]
    return frozenset(
        b for b, loop in enumerate(borders) if (sides[b] if b in sides else bool(loop.contains(middle)[0]))
    )


CONVEX, REENTRANT = np.deg2rad(140.0), np.deg2rad(220.0)
"""Angles inside a face below and above which a corner gets cells of its own."""


@dataclass(frozen=True)
class Corner:
    """The angle of a face at a node, from one half-edge to the next, rad."""

    node: int
    before: HalfEdge
    after: HalfEdge
    angle: float


def corners_of(plan: Arrangement, face: Face) -> list[list[Corner]]:
    """Angles of a face, cycle by cycle, each between a half-edge and the next."""
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


def polyline(curve: Curve) -> tuple[Real, Real]:
    """Parameters (k,) and points (k, 2) along a curve."""
    t = np.linspace(0.0, 1.0, 1 + max(1, int(np.ceil(turning(curve) / CHORD))))
    return t, curve.at(t)


def cuts_of(borders: Sequence[Loop], extra: Real) -> list[list[list[float]]]:
    """Parameters at which every curve of every border is cut, ends included."""
    curves = [(b, c, curve) for b, loop in enumerate(borders) for c, curve in enumerate(loop.curves)]
    cuts = [[[0.0, 1.0] for _ in loop.curves] for loop in borders]
    lines = [polyline(curve) for _, _, curve in curves]
    ends = np.array([curve.at(0.0) for _, _, curve in curves])
    for (b, c, curve), line in zip(curves, lines, strict=True):
        cuts[b][c] += _passing(curve, line, np.vstack([ends, extra]))
    for (one, line), (other, line_2) in combinations(zip(curves, lines, strict=True), 2):
        for t, s in _crossings(one[2], line, other[2], line_2):
            cuts[one[0]][one[1]].append(t)
            cuts[other[0]][other[1]].append(s)
    return cuts


def _passing(curve: Curve, line: tuple[Real, Real], points: Real) -> list[float]:
    """Parameters at which a curve runs through some of the points, its ends left out."""
    t, along = line
    step = np.diff(along, axis=0)
    away = points[:, None] - along[:-1]
    length = np.maximum((step**2).sum(axis=1), 1e-30)
    share = np.clip((away * step).sum(axis=2) / length, 0.0, 1.0)
    distance = np.hypot(*np.moveaxis(away - share[..., None] * step, -1, 0))
    reach = 2.0 * CHORD * np.sqrt(length.max()) + MERGED_DISTANCE if len(t) > 2 else MERGED_DISTANCE
    found = []
    for k in np.flatnonzero(distance.min(axis=1) < reach):
        i = int(distance[k].argmin())
        place = float(t[i] + share[k, i] * (t[i + 1] - t[i]))
        for _ in range(12):
            slope, miss = curve.derivative(place), curve.at(place) - points[k]
            place = float(np.clip(place - slope @ miss / (slope @ slope), 0.0, 1.0))
        ends = np.array([points[k] - curve.at(0.0), points[k] - curve.at(1.0)])
        if (
            np.hypot(*(curve.at(place) - points[k])) < MERGED_DISTANCE
            and np.hypot(*ends.T).min() > MERGED_DISTANCE
        ):
            found.append(place)
    return found


def _crossings(
    one: Curve, line: tuple[Real, Real], other: Curve, line_2: tuple[Real, Real]
) -> list[tuple[float, float]]:
    """Parameters (t, s) at which two curves cross, common ends left out."""
    (t, p), (s, q) = line, line_2
    margin = 0.02 * (np.ptp(p, axis=0).max() + np.ptp(q, axis=0).max()) + MERGED_DISTANCE
    if (p.min(axis=0) > q.max(axis=0) + margin).any() or (q.min(axis=0) > p.max(axis=0) + margin).any():
        return []
    a, b = np.diff(p, axis=0)[:, None], np.diff(q, axis=0)[None]
    gap = q[None, :-1] - p[:-1, None]
    det = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    oblique = np.abs(det) > 1e-9 * np.hypot(*np.moveaxis(a, -1, 0)) * np.hypot(*np.moveaxis(b, -1, 0))
    safe = np.where(oblique, det, 1.0)
    x = (gap[..., 0] * b[..., 1] - gap[..., 1] * b[..., 0]) / safe
    y = (gap[..., 0] * a[..., 1] - gap[..., 1] * a[..., 0]) / safe
    near = oblique & (x > -0.05) & (x < 1.05) & (y > -0.05) & (y < 1.05)
    found: list[tuple[float, float]] = []
    for i, j in zip(*np.nonzero(near), strict=True):
        place = np.array([t[i] + x[i, j] * (t[i + 1] - t[i]), s[j] + y[i, j] * (s[j + 1] - s[j])])
        for _ in range(8):
            slopes = np.column_stack([one.derivative(place[0]), -other.derivative(place[1])])
            if abs(np.linalg.det(slopes)) < TANGENT_SINE * np.prod(np.hypot(*slopes)):
                break  # the curves coincide
            place = np.clip(place - np.linalg.solve(slopes, one.at(place[0]) - other.at(place[1])), 0.0, 1.0)
        else:
            meet = one.at(place[0])
            if np.hypot(*(meet - other.at(place[1]))) > MERGED_DISTANCE:
                continue
            if not any(np.hypot(*(meet - one.at(known))) < MERGED_DISTANCE for known, _ in found):
                found.append((float(place[0]), float(place[1])))
    return found


def inside(places: Real, start: Real, end: Real) -> NDArray[np.bool_]:
    """Which places lie within closed rings of sides: a ray crosses them an odd number of times.

    Parameters
    ----------
    places : (K, 2) ndarray, m
    start, end : (S, 2) ndarray, m
        Ends of the sides, of all rings.

    Returns
    -------
    (K,) ndarray of bool
    """
    x, y = places.T[..., None]
    rises = (start[:, 1] > y) != (end[:, 1] > y)
    slope = np.where(rises, end[:, 1] - start[:, 1], 1.0)
    crossing = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / slope
    return np.asarray((rises & (x < crossing)).sum(axis=1) % 2 == 1)
