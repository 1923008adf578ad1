"""Forces, masses, springs and sensors at points: means over small discs.

The deflection of a Mindlin plate under a point force grows without bound as the mesh is refined: what acts at a
point needs a radius.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from analysis.plate import Plate
from simulation.shell.rigidity import THX, THY, W
from simulation.shell.space import ShapeSpace

Real = NDArray[np.float64]

RINGS = ((0.0, 1, 0.25), (float(np.sqrt(2.0 / 3.0)), 6, 0.125))
"""Radius over the disc's, number of places and weight of each: exact for cubics (Stroud, S2 3-1)."""
HELD = 1e3
"""Stiffness of a point support that holds, in bending stiffnesses at 10 GPa over its radius squared."""


def disc_means(space: ShapeSpace, points: Real, radius: float) -> csr_matrix:
    """Matrix (K, N) that gives the mean of a field over discs round points (K, 2), m; radius 0: the value."""
    points = np.asarray(points, float).reshape(-1, 2)
    if not radius:
        return space.values(points)
    total = csr_matrix((len(points), space.size))
    for share, count, weight in RINGS:
        for angle in 2 * np.pi * np.arange(count) / count:
            step = radius * share * np.array([np.cos(angle), np.sin(angle)])
            total = total + weight * space.values(points + step)
    return csr_matrix(total)


def point_springs(space: ShapeSpace, plate: Plate) -> Iterator[tuple[int, csr_matrix, float]]:
    """Field, row (1, N) and stiffness of every spring that stands for a support at a point."""
    for support in plate.supported_points():
        mean = disc_means(space, np.array([support.point]), support.radius)
        if support.kind == "elastic":
            yield W, mean, support.stiffness
            continue
        bending = 1e10 * plate.thickness**3 / 12.0
        yield W, mean, HELD * bending / support.radius**2
        if support.kind == "clamped":
            yield THX, mean, HELD * bending
            yield THY, mean, HELD * bending
