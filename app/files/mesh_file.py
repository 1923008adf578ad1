"""Meshes of Gmsh, Abaqus, Nastran, Exodus and VTK named in a declaration, turned into the numbers they hold."""

import re
import tempfile
from collections.abc import Callable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from analysis.declared import Declared, FileName
from app.files.exodus_mesh import ENDINGS as EXODUS
from app.files.isolation import run_isolated
from app.files.parsed_text import parse_json

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
NEEDS = "reading meshes needs the extra meshes: pip install 'flexura[meshes]'"
LARGEST_MESH_FILE = 20_000_000
"""Bytes of a file."""
READER = "app.files.mesh_reader"


class MeshFile(Declared):
    """A mesh in a file: ``[plate.mesh]`` with the key ``file``.

    `groups` gives names to groups that the file calls otherwise, such as the numbers of Nastran's properties.
    """

    file: Annotated[FileName, Field(min_length=3, description="a mesh's file, such as plate.msh")]
    unit: Literal["mm", "cm", "m", "in"] = "m"
    groups: Annotated[dict[str, str], Field(default_factory=dict, max_length=1000)]


def mesh_of_file(path: Path, unit: float, names: Mapping[str, str]) -> dict[str, Any]:
    """Numbers of a mesh, as `analysis.foreign_mesh.ForeignMesh` takes them.

    A process of its own reads the file, in bounded time and memory: meshio sets memory aside for the largest
    number of a point, and a damaged file may say any.

    Parameters
    ----------
    path : Path
        Of an ending in `app.files.mesh_reader.LIBRARY`, in any version.
    unit : float
        Length of one unit of the file, m.
    names : mapping
        Other names of groups (identifiers of patches), and what each stands for.

    Returns
    -------
    dict
        Points, m; cells and curves by their points, surfaces by their cells, all counted from 0.

    Raises
    ------
    ImportError
        Where meshio is not installed, but for Exodus.
    ValueError
        For what is no plane mesh of triangles and quadrilaterals, or is not read in time.
    """
    if path.suffix.lower() not in EXODUS and find_spec("meshio") is None:
        raise ImportError(NEEDS)
    size = path.stat().st_size if path.is_file() else -1
    if size < 0:
        raise ValueError("there is no such file beside the declaration")
    if size > LARGEST_MESH_FILE:
        raise ValueError(f"{size} bytes; allowed at most {LARGEST_MESH_FILE}")
    with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
        numbers = Path(folder) / "mesh.json"
        run_isolated(READER, [str(path.resolve()), str(numbers)], size)
        mesh: dict[str, Any] = parse_json(numbers.read_bytes())
    keep = str if path.suffix.lower() == GMSH else _plain  # other names are mistakes there
    known = {keep(name): stands for name, stands in names.items()}
    return {
        **mesh,
        "points": [[unit * x, unit * y] for x, y in mesh["points"]],
        "surface": _renamed(_called(mesh["surface"], keep), known, every=keep is str),
        "curve": _renamed(_called(mesh["curve"], keep), known, every=keep is str),
    }


def _called(groups: Mapping[str, list[Any]], keep: Callable[[str], str]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for name, members in groups.items():
        found.setdefault(keep(name), []).extend(members)
    return found


GMSH = ".msh"
OF_A_PLATE = re.compile(r"(patch|zone|hole|support)[ _-]?(\d+)|outline|plate", re.IGNORECASE)


def _plain(name: str) -> str:
    """Return ``patch 1`` for PATCH_1: Abaqus knows no small letters."""
    found = OF_A_PLATE.fullmatch(name.strip())
    if found is None:
        return name.strip().casefold()
    return f"{found[1].lower()} {found[2]}" if found[1] else found[0].lower()


def _renamed(
    groups: Mapping[str, list[Any]], names: Mapping[str, str], *, every: bool = True
) -> dict[str, list[Any]]:
    """Give groups the names used in the declaration, and join those of one name; of a plate's alone, or of all."""
    together: dict[str, set[Any]] = {}
    for name, members in groups.items():
        if not (every or name in names or OF_A_PLATE.fullmatch(name)):
            continue
        together.setdefault(names.get(name, name), set()).update(
            tuple(member) if isinstance(member, list) else member for member in members
        )
    return {name: sorted(members) for name, members in together.items()}
