"""Forces, masses, springs and sensors at points: means over small discs.

The deflection of a Mindlin plate under a point force grows without bound as the mesh is refined, so everything
that acts at a point needs a radius.
"""

from collections.abc import Iterator, Sequence

from scipy.sparse import csr_matrix

from analysis.channel import Footprint
from analysis.plate import Plate
from simulation.shell.footprints import footprint_points
from simulation.shell.rigidity import THX, THY, W
from simulation.shell.space import ShapeSpace

HELD = 1e3
"""Stiffness of a rigid point support, in bending stiffnesses at 10 GPa over its radius squared."""


def footprint_rows(space: ShapeSpace, footprints: Sequence[Footprint]) -> csr_matrix:
    """Matrix (K, N) that gives the mean of a field over the disc of each footprint."""
    points, average = footprint_points(footprints)
    return csr_matrix(csr_matrix(average) @ space.values(points))


def point_springs(
    space: ShapeSpace, plate: Plate, *, damping: bool = False
) -> Iterator[tuple[int, csr_matrix, float]]:
    """Springs of supports at points, or their dashpots.

    Parameters
    ----------
    space : ShapeSpace
        Of N functions.
    plate : Plate
    damping : bool
        Whether to yield the dashpots instead.

    Yields
    ------
    field : int
    row : (1, N) csr_matrix
        Mean of the field over the support's disc.
    stiffness : float
        N/m of a deflection, N m of a rotation; of dashpots N s/m.
    """
    for support in plate.supported_points():
        if support.point is None:
            continue
        mean = footprint_rows(space, [Footprint(support.point, support.radius)])
        if support.kind == "elastic":
            value = support.damping if damping else support.stiffness
            if value:
                yield W, mean, value
        if support.kind == "elastic" or damping:
            continue
        bending = 1e10 * plate.thickness**3 / 12.0
        yield W, mean, HELD * bending / support.radius**2
        if support.kind == "clamped":
            yield THX, mean, HELD * bending
            yield THY, mean, HELD * bending


def dashpot_discs(plate: Plate) -> list[Footprint]:
    """Discs on which dashpots act."""
    found = [support for support in plate.supported_points() if support.damping]
    return [Footprint(one.point, one.radius) for one in found if one.point is not None]
