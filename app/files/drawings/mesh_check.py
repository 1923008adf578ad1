"""Whether a declared plate can be meshed, found out when its declaration is read.

Otherwise borders that touch, a mesh that does not fit, or a plate too large for any computer would be found only
when the twin is built, after the campaign, when its declaration cannot be changed any more.
"""

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.files.bad_file import Misplaced

if TYPE_CHECKING:
    from analysis.declaration.plate import Plate
    from analysis.declaration.transducers import Patch
    from simulation.meshing.plate_mesh import MeshRecipe

BANDS = ("sweep.band", "protocol.band", "filters.edges")
"""Where an experiment, a campaign and a panel declare the frequencies they need."""
MOST_CELLS = 5000
"""Triangles of a plate: its model then takes 8 GB."""


def mesh_fault(
    source: Path, table: Mapping[str, Any], declared: object
) -> tuple[str, str, Misplaced | None] | None:
    """Mesh a declared plate, or compare its mesh with outline, holes, zones, patches and supports.

    A declaration that passed is remembered by an empty file in the cache folder: meshing it takes longer than
    reading the rest.

    Parameters
    ----------
    source : Path
        File of the declaration.
    table : mapping
        Its keys and values, with the mesh itself.
    declared : object
        What was made of them: an experiment or a panel, with ``plate`` and ``patch``, or other settings.

    Returns
    -------
    (str, str, Misplaced or None) or None
        The key, what is wrong, and where; None if nothing is.
    """
    plate, patches = getattr(declared, "plate", None), getattr(declared, "patch", ())
    if plate is None:
        return None
    band = _band(declared)
    passed = _passed(plate, patches, band)
    if passed.is_file():
        return None
    from analysis.geometry.loop import GeometryError
    from simulation.shell.shell_plate import mesh_of

    try:
        recipe = None if plate.mesh else _recipe(plate, band)
        mesh_of(plate, patches, recipe)
    except GeometryError as error:
        key = "plate.mesh" if plate.mesh else "plate"
        places = Misplaced(source, table, error.places) if error.places else None
        return key, _with_names(str(error), patches), places
    with suppress(OSError):  # without a cache folder it is meshed again
        passed.parent.mkdir(parents=True, exist_ok=True)
        passed.touch()
    return None


def _passed(plate: "Plate", patches: Sequence["Patch"], band: Any) -> Path:
    """Name the file that says that a declaration passed, by all that its mesh depends on."""
    from app.files.basis_cache import cache_folder
    from simulation.reduction.basis_key import METHOD

    declared = [METHOD, plate.model_dump_json(), *(patch.model_dump_json() for patch in patches), band]
    return cache_folder() / f"meshed-{hashlib.sha256(json.dumps(declared).encode()).hexdigest()}"


def _recipe(plate: "Plate", band: Any) -> "MeshRecipe | None":
    """Sizes of the twin's mesh, None without a band; GeometryError for a plate of too many cells."""
    if band is None:
        return None
    from analysis.declaration.plate_material import material_box
    from analysis.geometry.loop import GeometryError
    from simulation.shell.fineness import Fineness, shortest_wave

    box = material_box(plate.material)
    recipe = Fineness().recipe(plate, box, band)
    cells = plate.area / (0.433 * recipe.bulk(plate.thickness) ** 2)  # equilateral triangles
    if cells > MOST_CELLS:
        wave = shortest_wave(plate, box, band)
        raise GeometryError(
            f"{plate.length_x:g} by {plate.length_y:g} m are {plate.length_x / wave:.0f} by "
            f"{plate.length_y / wave:.0f} of the shortest bending wavelengths, {wave:.2g} m at {band[1]:g} Hz: "
            f"a model of {cells:.0f} cells, allowed {MOST_CELLS}. End the band at "
            f"{band[1] * MOST_CELLS / cells:.2g} Hz"
        )
    return recipe


def _band(declared: object) -> Any:
    """Frequencies that are needed, (low, high) Hz; None where none are declared."""

    def value(path: str) -> Any:
        try:
            return attrgetter(path)(declared)
        except AttributeError:
            return None

    return next(filter(None, map(value, BANDS)), None)


def _with_names(message: str, patches: Sequence["Patch"]) -> str:
    """Call patches by their names instead of their numbers."""
    names = {str(k + 1): patch.id for k, patch in enumerate(patches)}
    return re.sub(r"(?<!')\bpatch (\d+)", lambda found: f"patch {names.get(found[1], found[1])!r}", message)
