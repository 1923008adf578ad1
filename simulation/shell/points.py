"""Forces, masses, springs and sensors at points: means over small discs.

The deflection of a Mindlin plate under a point force grows without bound as the mesh is refined, so everything
that acts at a point needs a radius.
"""

from collections.abc import Iterator, Sequence

from scipy.sparse import csr_matrix

from analysis.channel import Footprint
from analysis.declaration.plate import Plate
from simulation.shell.footprints import footprint_points
from simulation.shell.rigidity import W
from simulation.shell.space import ShapeSpace

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
