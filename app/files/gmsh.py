"""Meshes of Gmsh named in a declaration, turned into the numbers they hold."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from analysis.declared import Declared
from analysis.foreign_mesh import MOST_POINTS

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254}
NEEDS = "reading meshes needs the extra meshes: pip install 'flexura[meshes]'"
LARGEST = 20_000_000
"""Bytes of a file."""
CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
LINES = ("line", "line3")


class MeshFile(Declared):
    """A mesh in a file: ``[plate.mesh]`` with the key ``file``."""

    file: Annotated[str, Field(min_length=5, max_length=255, description="a .msh file of Gmsh")]
    unit: Literal["mm", "cm", "m", "in"] = "m"


def mesh_of_file(path: Path, unit: float, names: Mapping[str, str]) -> dict[str, Any]:
    """Numbers of a Gmsh mesh, as `analysis.foreign_mesh.ForeignMesh` takes them.

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
        For what is no plane mesh of triangles and quadrilaterals.
    """
    raw = _read(path)
    height = raw.points[:, 2:]
    if height.size and np.ptp(height) > 1e-6 * np.ptp(raw.points):
        raise ValueError("points differ in z; the mesh of a plate is plane, its curvature is declared")
    cells: dict[int, dict[frozenset[int], list[int]]] = {4: {}, 3: {}}
    midsides: dict[tuple[int, int], int] = {}
    for block in raw.cells:
        if block.type in CORNERS:
            count = CORNERS[block.type]
            for row in block.data.tolist():
                cells[count][frozenset(row[:count])] = row[:count]
                for k in range(count if len(row) > count else 0):
                    a, b = row[k], row[(k + 1) % count]
                    midsides[min(a, b), max(a, b)] = row[count + k]
        elif block.type not in (*LINES, "vertex"):
            allowed = ", ".join((*CORNERS, *LINES, "vertex"))
            raise ValueError(f"cells of type {block.type} make no plate; allowed {allowed}")
    surfaces: dict[str, set[frozenset[int]]] = {}
    curves: dict[str, set[tuple[int, int]]] = {}
    for name, kind, row in _grouped(raw):
        if kind in CORNERS:
            surfaces.setdefault(names.get(name, name), set()).add(frozenset(row[: CORNERS[kind]]))
        else:
            curves.setdefault(names.get(name, name), set()).add((row[0], row[1]))
    if not any(cells.values()):
        raise ValueError("no triangles and no quadrilaterals")
    order = {cell: k for k, cell in enumerate([*cells[4], *cells[3]])}
    return {
        "points": [[float(x), float(y)] for x, y in unit * raw.points[:, :2]],
        "quads": list(cells[4].values()),
        "triangles": list(cells[3].values()),
        "midsides": [[*ends, middle] for ends, middle in sorted(midsides.items())],
        "surface": {name: sorted(order[one] for one in own) for name, own in surfaces.items()},
        "curve": {name: sorted(own) for name, own in curves.items()},
    }


def _grouped(raw: Any) -> Iterator[tuple[str, str, list[int]]]:
    """Name of a physical surface or curve, and type and points of one of its cells.

    Format 4.1 tells all groups of a cell (`cell_sets`), others one tag a cell.
    """
    tags = raw.cell_data.get("gmsh:physical", [])
    for name, (tag, dimension) in raw.field_data.items():
        rows = raw.cell_sets.get(name) or [np.flatnonzero(one == tag) for one in tags]
        kinds = {1: LINES, 2: tuple(CORNERS)}.get(int(dimension), ())
        for block, chosen in zip(raw.cells, rows, strict=False):  # none where no cell is tagged
            if block.type in kinds:
                for row in block.data[chosen].tolist():
                    yield name, block.type, row


def _read(path: Path) -> Any:
    """Let meshio read a file; ValueError for what it cannot."""
    size = path.stat().st_size if path.is_file() else -1
    if size < 0:
        raise ValueError("there is no such file beside the declaration")
    if size > LARGEST:
        raise ValueError(f"{size} bytes; allowed at most {LARGEST}")
    import meshio  # an extra

    try:
        raw = meshio.gmsh.read(path)
    except Exception as error:  # a damaged mesh leads the library into whatever there is
        raise ValueError(f"no Gmsh mesh that can be read ({error})") from error
    points: NDArray[np.float64] = raw.points
    if points.ndim != 2:
        raise ValueError("no Gmsh mesh that can be read (it holds no points)")
    if len(points) > MOST_POINTS:
        raise ValueError(f"{len(points)} points; allowed at most {MOST_POINTS}: a few hundred are enough")
    if not np.isfinite(points).all():
        raise ValueError("holds a number that is not finite")
    return raw
