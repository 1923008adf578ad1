"""A mesh in a declaration, compared with the declared plate when the declaration is read.

Otherwise a mesh that does not fit would be found only when the twin is built, after the campaign.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.files.misplaced import Misplaced

KEY = "plate.mesh"


def mesh_fault(source: Path, table: Mapping[str, Any], declared: object) -> tuple[str, Misplaced | None] | None:
    """Compare the mesh of a declared plate, if it has one, with outline, holes, zones, patches and supports.

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
    (str, Misplaced or None) or None
        What is wrong, and where; None if nothing is.
    """
    plate = getattr(declared, "plate", None)
    if plate is None or plate.mesh is None:
        return None
    from analysis.geometry.fault import GeometryError
    from simulation.shell.shell_plate import ShellPlate

    try:
        ShellPlate.of(plate, getattr(declared, "patch", ()), degree=1)
    except GeometryError as error:
        return str(error), Misplaced(source, table, error.places) if error.places else None
    return None
