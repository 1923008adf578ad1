"""Lines that the mesh of a declared plate follows, and the mesh itself."""

from collections.abc import Sequence

from analysis.experiment import Patch, Plate
from simulation.meshing.foreign import foreign_mesh
from simulation.meshing.mesher import Border, mesh_plate
from simulation.meshing.plate_mesh import PlateMesh
from simulation.meshing.recipe import MeshRecipe


def borders_of(plate: Plate, patches: Sequence[Patch]) -> list[Border]:
    """Borders of outline, holes, zones, patches, and discs of supports at points.

    A mesh from another program has a disc only where a support is clamped.
    """
    borders = [Border("outline", plate.loop, "outline")]
    borders += [Border(f"hole {k + 1}", loop, "hole") for k, loop in enumerate(plate.hole_loops)]
    borders += [Border(f"zone {k + 1}", loop) for k, loop in enumerate(plate.zone_loops)]
    borders += [Border(f"patch {k + 1}", patch.loop) for k, patch in enumerate(patches)]
    borders += [
        Border(name, disc)
        for name, (support, disc) in plate.supported_discs().items()
        if plate.mesh is None or support.kind == "clamped"
    ]
    return borders


def mesh_of(plate: Plate, patches: Sequence[Patch], recipe: MeshRecipe | None = None) -> PlateMesh:
    """Mesh a plate and its patches, or take the mesh that it declares.

    Parameters
    ----------
    recipe : MeshRecipe, optional
        Not used where the plate declares a mesh.

    Raises
    ------
    GeometryError
        If no good mesh is found, or a declared one does not fit, with the place.
    """
    loops = (plate.loop, *plate.hole_loops)
    cuts = [
        (float(x), float(y))
        for held in plate.supported_edges()
        for curve, first, last in held.pieces
        for x, y in loops[held.loop].curves[curve].at([first, last])
    ]
    borders = borders_of(plate, patches)
    if plate.mesh is not None:
        return foreign_mesh(plate.mesh, borders, cuts)
    return mesh_plate(borders, plate.thickness, recipe, cuts)
