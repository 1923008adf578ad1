"""Footprints of transducers and attachments, and rows that give the mean deflection over them.

A rule of seven points is exact for polynomials up to degree 5 (Stroud, Approximate Calculation of Multiple
Integrals, 1971, S2 5-1): a footprint of millimetres is small compared with any bending wavelength.
"""

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.experiment import Attachment, Plate

ANGLES = np.arange(6) * np.pi / 3.0
AROUND = np.sqrt(2.0 / 3.0) * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
WEIGHTS = np.array([0.25, *np.full(6, 0.125)])

INSIDE = 0.9
"""Largest radius of an attachment's disc, as a share of the distance to the nearest edge."""


def attached_disc(plate: Plate, attachment: Attachment) -> Footprint:
    """Disc on which a string or a cable acts: as declared, reduced if the plate's edges are too near.

    A disc is needed because the point compliance of a Mindlin plate is infinite: the effect of a point mass would
    grow with mesh refinement.
    """
    point = np.array([attachment.point])
    room = min(float(loop.distance(point)[0]) for loop in (plate.loop, *plate.hole_loops))
    radius = 0.5 * plate.thickness if attachment.radius is None else attachment.radius
    return Footprint(attachment.point, min(radius, INSIDE * room))


def footprint_points(footprints: Sequence[Footprint]) -> tuple[Real, Real]:
    """Points (Q, 2), m, and the matrix (S, Q) that averages a field's values there over each footprint."""
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
