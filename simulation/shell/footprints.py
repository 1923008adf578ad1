"""Footprints of transducers and attachments, and rows that give the mean deflection over them.

A rule of seven points is exact for polynomials up to degree 5 (Stroud, Approximate Calculation of Multiple
Integrals, 1971, S2 5-1): a footprint of millimetres is small compared with any bending wavelength.
"""

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.experiment import Attachment, Plate

ANGLES = np.arange(6) * np.pi / 3.0
AROUND = np.sqrt(2.0 / 3.0) * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
WEIGHTS = np.array([0.25, *np.full(6, 0.125)])

LARGEST_RADIUS_SHARE = 0.9
"""Largest radius of an attachment's disc, as a share of the distance to the nearest edge."""
LEAST_RADIUS = 0.25
"""Smallest radius of such a disc, in thicknesses, unless a smaller one is declared."""
TURNS = np.arange(32) * np.pi / 16.0
BESIDE = np.outer([1.02, 1.2, 1.5, 2.0, 3.0], np.exp(1j * TURNS)).ravel().view(float).reshape(-1, 2)
"""Places around a point at which its disc may lie, nearest first, in units of the room that it needs."""


def attached_discs(plate: Plate, attachments: Sequence[Attachment]) -> list[Footprint]:
    """Discs on which strings and cables act: as declared, reduced where the plate's edges are too near.

    A disc is needed because the point compliance of a Mindlin plate is infinite: the effect of a point mass would
    grow with mesh refinement. So that of a point at the edge lies beside it, wholly on the plate.
    """
    declared = [0.5 * plate.thickness if one.radius is None else one.radius for one in attachments]
    least = np.minimum(declared, LEAST_RADIUS * plate.thickness)
    points = np.reshape([one.point for one in attachments], (-1, 2)).astype(float)
    held = _held(plate, points, np.array(declared))
    for n in np.flatnonzero(held < least):  # few: each is looked for at 160 places
        beside = np.vstack([points[n], points[n] + least[n] / LARGEST_RADIUS_SHARE * BESIDE])
        room = _held(plate, beside, declared[n])
        first = int(np.argmax(room >= least[n])) if (room >= least[n]).any() else int(room.argmax())
        points[n], held[n] = beside[first], room[first]
    return [Footprint((float(x), float(y)), float(radius)) for (x, y), radius in zip(points, held, strict=True)]


def _held(plate: Plate, points: Real, radius: Real | float) -> Real:
    """Radius (K,) that a disc of `radius` may have at points (K, 2), m; 0 off the plate."""
    room = np.min([loop.distance(points) for loop in (plate.loop, *plate.hole_loops)], axis=0)
    return np.where(plate.contains(points), np.minimum(radius, LARGEST_RADIUS_SHARE * room), 0.0)


def footprint_points(footprints: Sequence[Footprint]) -> tuple[Real, csr_array]:
    """Points (Q, 2), m, and the sparse matrix (S, Q) that averages a field's values there over each footprint."""
    points: list[Real] = []
    weights: list[Real] = []
    for footprint in footprints:
        middle = np.array([footprint.point], float)
        around = middle + footprint.radius * AROUND if footprint.radius else np.zeros((0, 2))
        points.append(np.vstack([middle, around]))
        weights.append(WEIGHTS if footprint.radius else np.ones(1))
    starts = np.cumsum([0, *map(len, weights)])
    values = np.concatenate([np.zeros(0), *weights])
    # of some thousand places the matrix is nearly all zeros
    average = csr_array((values, np.arange(values.size), starts), shape=(len(weights), values.size))
    return np.vstack([np.zeros((0, 2)), *points]), average
