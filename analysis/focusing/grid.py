"""The grid on which a field is aimed and judged."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.focusing.panel import Panel


@dataclass(frozen=True)
class Grid:
    """Midpoints of equal cells over a rectangular plate.

    Attributes
    ----------
    points : (K, 2) ndarray
        m.
    area : (K,) ndarray
        Of each cell, m2.
    target : (K,) ndarray
        Share of each cell the target covers: the target shape φ(x, y) of paper eq. (1), 1 inside and 0
        outside, so that a target cutting through cells keeps its true area.
    length : (float, float)
        Of the plate, m.
    center : (float, float)
        Of the target, m.
    """

    points: NDArray[np.float64]
    area: NDArray[np.float64]
    target: NDArray[np.float64]
    length: tuple[float, float]
    center: tuple[float, float]

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
        lengths = (panel.plate.length_x, panel.plate.length_y)
        middles, cover = [], []
        for axis, count in enumerate(panel.grid):
            edges = np.linspace(0.0, 1.0, count + 1)
            half = panel.target.size[axis] / 2.0
            low, high = panel.target.center[axis] - half, panel.target.center[axis] + half
            overlap = np.minimum(edges[1:], high) - np.maximum(edges[:-1], low)
            cover.append(np.clip(np.round(overlap * count, 12), 0.0, 1.0))
            middles.append(0.5 * (edges[1:] + edges[:-1]) * lengths[axis])
        points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, 2)
        target = np.outer(*cover).ravel()
        area = np.full(len(points), lengths[0] * lengths[1] / len(points))
        return cls(points, area, target, lengths, panel.target_center)

    @property
    def target_share(self) -> float:
        """Area of the target over area of the plate."""
        return float(self.area @ self.target / self.area.sum())
