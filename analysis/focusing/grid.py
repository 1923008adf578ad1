"""The grid on which the field of a panel is evaluated."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Mask, Real
from analysis.experiment import Plate
from analysis.focusing.panel import Panel
from analysis.geometry.loop import Loop

POINTS_ALONG_CELL = 8
"""Points along each side of a cell, to compute the part of it on the plate."""


@dataclass(frozen=True)
class Grid:
    """Midpoints of equal cells over the box around a plate; those off the plate are left out.

    Attributes
    ----------
    points : (K, 2) ndarray
        m.
    area : (K,) ndarray
        Of each cell on the plate, m2; their sum is the plate's area.
    target : (K,) ndarray
        Share of each cell the target covers: the target shape φ(x, y) of paper eq. (1), 1 inside and 0
        outside, so that a target cutting through cells keeps its true area.
    length : (float, float)
        Of the plate: of the box around it, m.
    center : (float, float)
        Of the target, m.
    spots : (S, 2) ndarray, optional
        Centres of the target's parts, m, where it has several.
    """

    points: Real
    area: Real
    target: Real
    length: tuple[float, float]
    center: tuple[float, float]
    spots: Real | None = None

    def __post_init__(self) -> None:
        count = len(self.area)
        if self.points.shape != (count, 2) or self.target.shape != (count,):
            raise ValueError(
                f"points {self.points.shape}, area {self.area.shape} and target {self.target.shape} "
                "must be (K, 2), (K,) and (K,)"
            )
        if not self.target.any():
            raise ValueError("the target covers no cell of the grid")

    @classmethod
    def of(cls, panel: Panel) -> Self:
        """Grid of a panel, x slowest."""
        plate = panel.plate
        lengths = (plate.length_x, plate.length_y)
        middles = [
            plate.bounds[0][axis] + (np.arange(count) + 0.5) / count * lengths[axis]
            for axis, count in enumerate(panel.grid)
        ]
        points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 2)
        loops, cell = panel.target_loops, (lengths[0] / panel.grid[0], lengths[1] / panel.grid[1])
        # Parts do not overlap, so their shares add up; corners may touch.
        target = (
            _rectangle(panel)
            if panel.target.plain
            else np.minimum(sum(_share(loop.contains, (loop,), points, cell) for loop in loops), 1.0)
        )
        area = np.full(len(points), lengths[0] * lengths[1] / len(points))
        if plate.outline is not None or plate.hole:
            points, area, target = _cut(plate, points, area, target, panel.grid)
        spots = np.array([loop.centroid for loop in loops])
        return cls(points, area, target, lengths, panel.target_center, spots)

    @property
    def centers(self) -> Real:
        """Centres (S, 2) of the target's parts, m."""
        return np.array([self.center]) if self.spots is None else self.spots

    @property
    def target_share(self) -> float:
        """Area of the target over area of the plate."""
        return float(self.area @ self.target / self.area.sum())


def _rectangle(panel: Panel) -> Real:
    """Share (K,) of the cells that one rectangle along the plate's sides covers, exactly."""
    cover = []
    (low_corner, high_corner), plate = panel.target_loops[0].bounds, panel.plate
    lengths = (plate.length_x, plate.length_y)
    for axis, count in enumerate(panel.grid):
        edges = np.linspace(0.0, 1.0, count + 1)
        low, high = (
            (corner[axis] - plate.bounds[0][axis]) / lengths[axis] for corner in (low_corner, high_corner)
        )
        overlap = np.minimum(edges[1:], high) - np.maximum(edges[:-1], low)
        cover.append(np.clip(np.round(overlap * count, 9), 0.0, 1.0))
    return np.asarray(np.outer(*cover).ravel())


def _cut(plate: Plate, points: Real, area: Real, target: Real, count: tuple[int, int]) -> tuple[Real, Real, Real]:
    """Leave out points off the plate; the parts of their cells on it are added to the nearest cell kept."""
    from scipy.spatial import cKDTree

    borders = (plate.loop, *plate.hole_loops)
    share = _share(plate.contains, borders, points, (plate.length_x / count[0], plate.length_y / count[1]))
    kept = plate.contains(points)
    if not kept.any():
        raise ValueError(f"no point of a grid of {count[0]} by {count[1]} lies on the plate; take a finer one")
    covered = target * area  # the target lies on the plate
    slivers = np.flatnonzero(~kept & (share > 0.0))
    nearest = cKDTree(points[kept]).query(points[slivers])[1]
    found, aimed = (share * area)[kept], covered[kept]
    np.add.at(found, nearest, (share * area)[slivers])
    np.add.at(aimed, nearest, covered[slivers])
    edge = np.abs(found / area[kept] - 1.0) > 1e-9
    found[edge] *= 1.0 + (plate.area - found.sum()) / found[edge].sum()
    return points[kept], found, np.minimum(aimed / found, 1.0)


def _share(
    contains: Callable[[Real], Mask], borders: Sequence[Loop], points: Real, cell: tuple[float, float]
) -> Real:
    """Share (K,) of the cells about `points` (K, 2) that lies within a region of these `borders`."""
    inside = contains(points)
    away = np.min([loop.distance(points) for loop in borders], axis=0)
    cut = np.flatnonzero(away <= 0.51 * np.hypot(*cell))
    steps = (np.arange(POINTS_ALONG_CELL) + 0.5) / POINTS_ALONG_CELL - 0.5
    fine = np.stack(np.meshgrid(steps * cell[0], steps * cell[1]), axis=-1).reshape(-1, 2)
    share = inside.astype(float)
    samples = (points[cut, None] + fine).reshape(-1, 2)
    share[cut] = contains(samples).reshape(len(cut), -1).mean(axis=1)
    return share
