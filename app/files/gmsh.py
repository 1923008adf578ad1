"""Meshes of Gmsh named in a declaration, turned into the numbers they hold."""

import tempfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from analysis.declared import Declared
from app.files.isolation import run_isolated
from app.files.parsed_text import parse_json

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
NEEDS = "reading meshes needs the extra meshes: pip install 'flexura[meshes]'"
LARGEST = 20_000_000
"""Bytes of a file."""
READER = "app.files.gmsh_reader"


class MeshFile(Declared):
    """A mesh in a file: ``[plate.mesh]`` with the key ``file``."""

    file: Annotated[str, Field(min_length=5, max_length=255, description="a .msh file of Gmsh")]
    unit: Literal["mm", "cm", "m", "in"] = "m"


def mesh_of_file(path: Path, unit: float, names: Mapping[str, str]) -> dict[str, Any]:
    """Numbers of a Gmsh mesh, as `analysis.foreign_mesh.ForeignMesh` takes them.

    A process of its own reads the file, in bounded time and memory: meshio sets memory aside for the largest
    number of a point, and a damaged file may say any.

    Parameters
    ----------
    path : Path
        Any version of Gmsh's format that meshio reads.
    unit : float
        Length of one unit of the file, m.
    names : mapping
        Other names of physical groups (identifiers of patches), and what each stands for.

    Returns
    -------
    dict
        Points, m; cells and curves by their points, surfaces by their cells, all counted from 0.

    Raises
    ------
    ImportError
        Where meshio is not installed.
    ValueError
        For what is no plane mesh of triangles and quadrilaterals, or is not read in time.
    """
    if find_spec("meshio") is None:
        raise ImportError(NEEDS)
    size = path.stat().st_size if path.is_file() else -1
    if size < 0:
        raise ValueError("there is no such file beside the declaration")
    if size > LARGEST:
        raise ValueError(f"{size} bytes; allowed at most {LARGEST}")
    with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
        numbers = Path(folder) / "mesh.json"
        run_isolated(READER, [str(path.resolve()), str(numbers)], size)
        mesh: dict[str, Any] = parse_json(numbers.read_bytes())
    return {
        **mesh,
        "points": [[unit * x, unit * y] for x, y in mesh["points"]],
        "surface": _renamed(mesh["surface"], names),
        "curve": _renamed(mesh["curve"], names),
    }


def _renamed(groups: Mapping[str, list[Any]], names: Mapping[str, str]) -> dict[str, list[Any]]:
    """Give groups the names used in the declaration, and join those of one name."""
    together: dict[str, set[Any]] = {}
    for name, members in groups.items():
        together.setdefault(names.get(name, name), set()).update(
            tuple(member) if isinstance(member, list) else member for member in members
        )
    return {name: sorted(members) for name, members in together.items()}
