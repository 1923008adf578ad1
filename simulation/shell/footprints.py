"""Rows that give the mean deflection over the footprints of transducers.

A rule of seven points is exact for polynomials up to degree 5 (Stroud, Approximate Calculation of Multiple
Integrals, 1971, S2 5-1): a footprint of millimetres holds a small part of any bending wave.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.channel import Footprint

Real = NDArray[np.float64]

ANGLES = np.arange(6) * np.pi / 3.0
AROUND = np.sqrt(2.0 / 3.0) * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
WEIGHTS = np.array([0.25, *np.full(6, 0.125)])


def footprint_points(footprints: Sequence[Footprint]) -> tuple[Real, Real]:
    """Points (Q, 2), m, and the matrix (S, Q) that averages what a field is there over each footprint."""
    points: list[Real] = []
    weights: list[Real] = []
    for footprint in footprints:
        middle = np.array([footprint.point], float)
        around = middle + footprint.radius * AROUND if footprint.radius else np.zeros((0, 2))
        points.append(np.vstack([middle, around]))
        weights.append(WEIGHTS if footprint.radius else np.ones(1))
    average = np.zeros((len(weights), sum(map(len, weights))))
    start = 0
    for row, weight in zip(average, weights, strict=True):
        row[start : start + len(weight)] = weight
        start += len(weight)
    return np.vstack([np.zeros((0, 2)), *points]), average
