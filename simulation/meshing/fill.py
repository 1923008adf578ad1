"""Triangles for what the strips leave of a face: Delaunay's, of points graded with the distance from the border."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

Real = NDArray[np.float64]
Whole = NDArray[np.int_]

LEAST_ANGLE = np.deg2rad(10.0)
SMOOTHINGS = 6


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
        Sides of the rings, by their points, that are no side of a triangle, and those that are the longest
        side of a flat triangle.
    """

    points: Real
    triangles: Whole
    missing: list[tuple[int, int]]
    thin: list[tuple[int, int]]


def fill(points: Real, rings: Sequence[Sequence[int]], spacing: float, growth: float) -> Fill:
    """Triangulate the region inside rings of `points` (K, 2): the outer ring first, then holes."""
    sides = np.array([(a, b) for ring in rings for a, b in zip(ring, (*ring[1:], ring[0]), strict=True)])
    start, end = points[sides[:, 0]], points[sides[:, 1]]
    length = np.hypot(*(end - start).T)

    def size(places: Real) -> Real:
        return np.minimum(spacing, (length + growth * _distance(places, start, end)).min(axis=1))

    free = _graded(start, end, length, spacing, size)
    triangles = _triangles(np.vstack([points, free]), start, end)
    for _ in range(SMOOTHINGS if len(free) else 0):
        free = _smoothed(np.vstack([points, free]), triangles, len(points))
        triangles = _triangles(np.vstack([points, free]), start, end)
    whole = np.vstack([points, free])
    return Fill(whole, triangles, *_faults(whole, triangles, sides))


def _distance(places: Real, start: Real, end: Real) -> Real:
    """Distance of places (K, 2) from sides (S, 2), (K, S)."""
    step = end - start
    away = places[:, None] - start
    t = np.clip((away * step).sum(axis=2) / np.maximum((step**2).sum(axis=1), 1e-30), 0.0, 1.0)
    return np.asarray(np.sqrt(((away - t[..., None] * step) ** 2).sum(axis=2)))


def _inside(places: Real, start: Real, end: Real) -> NDArray[np.bool_]:
    """Which places lie within the rings: a ray crosses their sides an odd number of times."""
    x, y = places.T[..., None]
    rises = (start[:, 1] > y) != (end[:, 1] > y)
    slope = np.where(rises, end[:, 1] - start[:, 1], 1.0)
    crossing = start[:, 0] + (y - start[:, 1]) * (end[:, 0] - start[:, 0]) / slope
    return np.asarray((rises & (x < crossing)).sum(axis=1) % 2 == 1)


def _graded(start: Real, end: Real, length: Real, spacing: float, size: object) -> Real:
    """New points (K, 2), apart by about the size wanted there."""
    low, high = start.min(axis=0), start.max(axis=0)
    found: list[Real] = []
    level = min(spacing, float(length.min()))
    while True:
        step = np.array([level, level * np.sqrt(0.75)])
        count = np.floor((high - low) / step).astype(int) + 2
        i, j = (grid.ravel() for grid in np.meshgrid(np.arange(count[0] + 1), np.arange(count[1])))
        grid = 0.5 * (low + high) + (np.column_stack([i + 0.5 * (j % 2), j]) - 0.5 * (count - 1)) * step
        grid = grid[_inside(grid, start, end)]
        if len(grid):
            wanted = size(grid)  # type: ignore[operator]
            upper = np.inf if level >= spacing else 1.42 * level
            chosen = (wanted >= level / 1.42) & (wanted < upper)
            clear = _distance(grid, start, end).min(axis=1) > 0.6 * np.minimum(wanted, level)
            found += [np.column_stack([grid[chosen & clear], wanted[chosen & clear]])]
        if level >= spacing:
            break
        level = min(2.0 * level, spacing) if level * 1.42 < spacing else spacing
    candidates = np.vstack(found) if found else np.zeros((0, 3))
    kept: list[int] = []
    tree = cKDTree(candidates[:, :2]) if len(candidates) else None
    blocked = np.zeros(len(candidates), bool)
    for k in range(len(candidates)):
        if not blocked[k] and tree is not None:
            kept.append(k)
            blocked[tree.query_ball_point(candidates[k, :2], 0.72 * candidates[k, 2])] = True
    return np.asarray(candidates[kept, :2])


def _triangles(points: Real, start: Real, end: Real) -> Whole:
    """Delaunay triangles inside the rings, counter-clockwise."""
    corners = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    a, b, c = (points[corners[:, k]] for k in range(3))
    twice = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    corners[twice < 0.0] = corners[twice < 0.0][:, [0, 2, 1]]
    longest = np.maximum.reduce([((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))])
    kept = (np.abs(twice) > 1e-6 * longest) & _inside((a + b + c) / 3.0, start, end)
    return corners[kept]


def _smoothed(points: Real, triangles: Whole, fixed: int) -> Real:
    """Free points moved to the mean of the middles of the triangles round them, weighted by area."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.abs((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    middle = (a + b + c) / 3.0
    total, weight = np.zeros_like(points), np.zeros(len(points))
    for k in range(3):
        np.add.at(total, triangles[:, k], area[:, None] * middle)
        np.add.at(weight, triangles[:, k], area)
    moved = np.where(weight[:, None] > 0.0, total / np.maximum(weight, 1e-30)[:, None], points)
    return np.asarray(moved[fixed:])


def _faults(
    points: Real, triangles: Whole, sides: Whole
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """``missing`` and ``thin`` of `Fill`."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    edges = {(int(a), int(b)) for a, b in pairs.reshape(-1, 2)}
    by_pair = {(int(min(a, b)), int(max(a, b))): k for k, (a, b) in enumerate(sides)}
    thin = set()
    for rows in pairs[_least_angle(points, triangles) < LEAST_ANGLE]:
        extent = np.hypot(*(points[rows[:, 0]] - points[rows[:, 1]]).T)
        a, b = rows[extent.argmax()]
        if (int(a), int(b)) in by_pair:  # a triangle on a short base is thin too, but halving the base mends nothing
            thin.add((int(a), int(b)))
    return [pair for pair in by_pair if pair not in edges], sorted(thin)


def _least_angle(points: Real, triangles: Whole) -> Real:
    corners = points[triangles]
    angles = []
    for k in range(3):
        one, two = corners[:, k - 1] - corners[:, k], corners[:, k - 2] - corners[:, k]
        cross = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
        angles.append(np.arctan2(cross, (one * two).sum(axis=1)))
    return np.asarray(np.min(angles, axis=0))
