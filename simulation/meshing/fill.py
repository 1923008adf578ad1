"""Delaunay triangles in the part of a face without strips, with points graded by distance from its border."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from analysis.arrays import Real, Whole
from simulation.meshing.arrangement import inside

LEAST_ANGLE = np.deg2rad(10.0)
SMOOTHINGS = 5
SIZE_LEVEL_RATIO = 1.42
"""Points of one size level are used for sizes from the level over this to the level times this."""
PAIRS_AT_ONCE = 400_000
"""Number of pairs of places and sides computed at a time."""


@dataclass(frozen=True)
class Fill:
    """Triangles within rings.

    Attributes
    ----------
    points : (K, 2) ndarray
        Of the rings, then new ones.
    triangles : (T, 3) ndarray of int
        Counter-clockwise.
    missing, thin : list of (int, int)
        Sides of the rings, by their points, that are no side of a triangle; and those that are the longest side of
        a flat triangle.
    """

    points: Real
    triangles: Whole
    missing: list[tuple[int, int]]
    thin: list[tuple[int, int]]


def crossing_sides(points: Real, rings: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Sides of rings, by their points, that cross another side or run the wrong way round."""
    sides = _sides(rings)
    start, end = points[sides[:, 0]], points[sides[:, 1]]
    step = end - start
    found = np.zeros(len(sides), bool)
    for k in range(len(sides)):
        to_start, to_end = start - start[k], end - start[k]
        one = (step[k, 0] * to_start[:, 1] - step[k, 1] * to_start[:, 0]) * (
            step[k, 0] * to_end[:, 1] - step[k, 1] * to_end[:, 0]
        )
        back, forth = start[k] - start, end[k] - start
        two = (step[:, 0] * back[:, 1] - step[:, 1] * back[:, 0]) * (
            step[:, 0] * forth[:, 1] - step[:, 1] * forth[:, 0]
        )
        found[k] = ((one < 0.0) & (two < 0.0)).any()
    first = 0
    for ring, way in zip(rings, [1.0] + [-1.0] * len(rings), strict=False):
        x, y = points[list(ring)].T
        if way * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) <= 0.0:
            found[first : first + len(ring)] = True
        first += len(ring)
    return [(int(a), int(b)) for a, b in sides[found]]


def fill(points: Real, rings: Sequence[Sequence[int]], spacing: float, growth: float) -> Fill:
    """Triangulate the region inside rings of points.

    Parameters
    ----------
    points : (K, 2) ndarray, m
    rings : sequence of sequence of int
        Numbers of points: the outer ring first, then holes.
    spacing : float
        Largest distance of points inside, m.
    growth : float
        Increase of the spacing per distance from the border, m/m.

    Returns
    -------
    Fill
        Points, triangles, and their faults.
    """
    sides = _sides(rings)
    start, end = points[sides[:, 0]], points[sides[:, 1]]
    free = _graded(start, end, spacing, growth)
    whole = np.vstack([points, free])
    triangles = _triangles(whole, start, end)
    for _ in range(SMOOTHINGS if len(free) and not _missing(triangles, sides) else 0):
        smooth = np.vstack([points, _smoothed(whole, triangles, len(points))])
        tried = _triangles(smooth, start, end)
        if _missing(tried, sides):
            break
        whole, triangles = smooth, tried
    return Fill(whole, triangles, _missing(triangles, sides), _thin(whole, triangles, sides))


def _sides(rings: Sequence[Sequence[int]]) -> Whole:
    return np.array([(a, b) for ring in rings for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)])


def _distance(places: Real, start: Real, end: Real) -> Real:
    """Distance of places (K, 2) from sides (S, 2), (K, S)."""
    (dx, dy), length = (end - start).T, np.maximum(((end - start) ** 2).sum(axis=1), 1e-30)
    x, y = places[:, :1] - start[:, 0], places[:, 1:] - start[:, 1]
    t = ((x * dx + y * dy) / length).clip(0.0, 1.0)
    return np.asarray(np.sqrt((x - t * dx) ** 2 + (y - t * dy) ** 2))


def _graded(start: Real, end: Real, spacing: float, growth: float) -> Real:
    """Place points (K, 2) with the local spacing: that of the sides, growing with the distance from them."""
    length = np.sqrt(((end - start) ** 2).sum(axis=1))
    low, high = start.min(axis=0), start.max(axis=0)
    found = []
    level = min(spacing, float(length.min()))
    while True:
        step = np.array([level, level * np.sqrt(0.75)])
        origin = 0.5 * (low + high)
        count = np.ceil((high - low) / step).astype(int) + 1
        if level < spacing:
            near = length < SIZE_LEVEL_RATIO * level  # finer points only beside short sides
            i, j = _beside(0.5 * (start[near] + end[near]) - origin, step, growth)
        else:
            i, j = (grid.ravel() for grid in np.mgrid[-count[0] : count[0] + 1, -count[1] : count[1] + 1])
        grid = origin + np.stack([i + 0.5 * (j % 2), j], axis=1) * step
        grid = grid[((grid > low) & (grid < high)).all(axis=1)]
        rows = max(1, PAIRS_AT_ONCE // len(start))
        for first in range(0, len(grid), rows):
            part = grid[first : first + rows]
            part = part[inside(part, start, end)]
            away = _distance(part, start, end)
            wanted = np.minimum(spacing, (length + growth * away).min(axis=1, initial=np.inf))
            upper = np.inf if level >= spacing else SIZE_LEVEL_RATIO * level
            chosen = (wanted >= level / SIZE_LEVEL_RATIO) & (wanted < upper)
            chosen &= away.min(axis=1, initial=np.inf) > 0.6 * np.minimum(wanted, level)
            found.append(np.column_stack([part[chosen], wanted[chosen]]))
        if level >= spacing:
            break
        level = min(2.0 * level, spacing) if level * SIZE_LEVEL_RATIO < spacing else spacing
    return _apart(np.vstack(found) if found else np.zeros((0, 3)))


def _beside(middles: Real, step: Real, growth: float) -> tuple[Whole, Whole]:
    """Columns and rows of a triangular grid near the middles of sides."""
    reach = int(np.ceil(SIZE_LEVEL_RATIO * (0.5 + 1.0 / growth))) + 1
    around = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).T
    nearest = np.round(middles / step).astype(int)
    i, j = (nearest[:, None] + around).reshape(-1, 2).T
    wide = int(np.ptp(j)) + 1
    one = np.unique((i - i.min()) * wide + (j - j.min()))  # much quicker than of pairs
    return one // wide + i.min(), one % wide + j.min()


def _apart(candidates: Real) -> Real:
    """Select from points with sizes (K, 3) those (K', 2) far enough from all points before them."""
    if not len(candidates):
        return np.zeros((0, 2))
    kept: list[int] = []
    near = cKDTree(candidates[:, :2]).query_ball_point(candidates[:, :2], 0.72 * candidates[:, 2])
    blocked = np.zeros(len(candidates), bool)
    for k, others in enumerate(near):
        if not blocked[k]:
            kept.append(k)
            blocked[others] = True
    return np.asarray(candidates[kept, :2])


def _triangles(points: Real, start: Real, end: Real) -> Whole:
    """Delaunay triangles inside the rings, counter-clockwise."""
    try:
        corners = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    except QhullError:  # all points on one line
        return np.zeros((0, 3), np.int64)
    a, b, c = (points[corners[:, k]] for k in range(3))
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    corners[twice < 0.0] = corners[twice < 0.0][:, [0, 2, 1]]
    longest = np.maximum.reduce([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))])
    kept = (np.abs(twice) > 1e-6 * longest) & inside((a + b + c) / 3.0, start, end)
    return np.asarray(corners[kept])


def _smoothed(points: Real, triangles: Whole, fixed: int) -> Real:
    """Free points moved to the area-weighted mean of the centroids of their triangles."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.abs((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    middle = (a + b + c) / 3.0
    total, weight = np.zeros_like(points), np.zeros(len(points))
    for k in range(3):
        np.add.at(total, triangles[:, k], area[:, None] * middle)
        np.add.at(weight, triangles[:, k], area)
    moved = np.where(weight[:, None] > 0.0, total / np.maximum(weight, 1e-30)[:, None], points)
    return np.asarray(moved[fixed:])


def _missing(triangles: Whole, sides: Whole) -> list[tuple[int, int]]:
    """Sides that are no side of a triangle, ascending."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    edges = {(int(a), int(b)) for a, b in pairs}
    wanted = ((int(a), int(b)) for a, b in np.sort(sides, axis=1))
    return [pair for pair in wanted if pair not in edges]


def _thin(points: Real, triangles: Whole, sides: Whole) -> list[tuple[int, int]]:
    """Sides that are the longest side of a flat triangle, ascending.

    Triangles on a short base or in a sharp corner are thin too, but halving that side does not improve them.
    """
    wanted = {(int(a), int(b)) for a, b in np.sort(sides, axis=1)}
    found = set()
    for corners in triangles[_least_angle(points, triangles) < LEAST_ANGLE]:
        pairs = [(corners[k], corners[(k + 1) % 3]) for k in range(3)]
        own = [(int(min(a, b)), int(max(a, b))) for a, b in pairs]
        extent = [float(((points[a] - points[b]) ** 2).sum()) for a, b in own]
        longest = own[int(np.argmax(extent))]
        shared = [pair for pair in own if pair in wanted]
        if longest in wanted and not (len(shared) > 1 and own[int(np.argmin(extent))] not in wanted):
            found.add(longest)
    return sorted(found)


def _least_angle(points: Real, triangles: Whole) -> Real:
    corners = points[triangles]
    angles = []
    for k in range(3):
        one, two = corners[:, k - 1] - corners[:, k], corners[:, k - 2] - corners[:, k]
        cross = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        angles.append(np.arctan2(cross, (one * two).sum(axis=1)))
    return np.asarray(np.min(angles, axis=0))
