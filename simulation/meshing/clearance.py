"""Free distances between borders, and lengths along them."""

import numpy as np
from scipy.spatial import cKDTree

from analysis.arrays import Real
from analysis.geometry.curves import Curve
from simulation.meshing.arrangement import Arrangement

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
