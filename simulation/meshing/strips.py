"""Strips of quadrilaterals along both sides of every border, and the rings around the rest of each face.

A strip joins the pieces of an edge to nodes a strip's width inside the face. Where the border turns, strips of
both sides meet: at a convex corner in one kite between the feet of the two inner lines, at a re-entrant one in
kites that fan out from the corner.
"""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from analysis.arrays import Real
from analysis.geometry.curves import turning
from simulation.meshing.arrangement import CONVEX, REENTRANT, Corner, HalfEdge
from simulation.meshing.cells import Cells, Foot, Repairs
from simulation.meshing.sides import Cutter, Side

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
