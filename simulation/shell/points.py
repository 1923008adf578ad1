"""Forces, masses, springs and sensors at points, as means over small discs; footprints of transducers.

The deflection of a Mindlin plate under a point force grows without bound as the mesh is refined, so everything
that acts at a point needs a radius.

A rule of seven points is exact for polynomials up to degree 5 (Stroud, Approximate Calculation of Multiple
Integrals, 1971, S2 5-1): a footprint of millimetres is small compared with any bending wavelength.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.sparse import csr_array, csr_matrix

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.experiment import Attachment, Plate
from simulation.shell.rigidity import W
from simulation.shell.space import ShapeSpace

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


SUPPORT_STIFFNESS = 1e3
"""Stiffness of a simple support at a point, in bending stiffnesses at 10 GPa over its radius squared."""


def footprint_rows(space: ShapeSpace, footprints: Sequence[Footprint]) -> csr_matrix:
    """Matrix (K, N) that gives the mean of a field over the disc of each footprint."""
    points, average = footprint_points(footprints)
    return csr_matrix(average @ space.values(points))


def point_springs(
    space: ShapeSpace, plate: Plate, *, damping: bool = False
) -> Iterator[tuple[int, csr_matrix, float]]:
    """Springs of supports at points that hold the deflection, or their dashpots.

    Their discs are borders of the mesh: what a disc does to a mesh with larger cells depends on these, up to 1 %
    of a response. Clamped discs are held function by function, see `simulation.shell.edges.held_functions`.

    Parameters
    ----------
    space : ShapeSpace
        Of N functions.
    damping : bool
        Whether to yield the dashpots instead.

    Yields
    ------
    field : int
    row : (1, N) csr_matrix
        Mean of the field over the support's disc.
    stiffness : float
        N/m; of dashpots N s/m.
    """
    for name, (support, disc) in plate.supported_discs().items():
        if support.point is None or support.kind == "clamped":
            continue
        if support.kind == "elastic":
            value = support.damping if damping else support.stiffness
        else:
            value = 0.0 if damping else SUPPORT_STIFFNESS * 1e10 * plate.thickness**3 / 12.0 / support.radius**2
        if value:
            yield W, _mean(space, name, Footprint(support.point, support.radius), disc.area), value


def _mean(space: ShapeSpace, name: str, footprint: Footprint, area: float) -> csr_matrix:
    """Mean of every function over a support's disc, (1, N): exact where the mesh follows its border."""
    cells = space.mesh.inside.get(name)
    if cells is None:
        return footprint_rows(space, [footprint])
    return csr_matrix(space.moments("0", None, cells) / area)


def spring_discs(plate: Plate) -> list[Footprint]:
    """Discs on which springs and dashpots of supports act."""
    found = [support for support, _ in plate.supported_discs().values() if support.kind != "clamped"]
    return [Footprint(one.point, one.radius) for one in found if one.point is not None]
