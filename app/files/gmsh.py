"""Meshes of Gmsh named in a declaration, turned into the numbers they hold."""

from collections.abc import Mapping
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
    groups = {(int(dimension), int(tag)): name for name, (tag, dimension) in raw.field_data.items()}
    tags = raw.cell_data.get("gmsh:physical", [np.zeros(len(block.data), int) for block in raw.cells])
    cells: dict[int, dict[frozenset[int], list[int]]] = {4: {}, 3: {}}
    midsides: dict[tuple[int, int], int] = {}
    surfaces: dict[str, set[frozenset[int]]] = {}
    curves: dict[str, set[tuple[int, int]]] = {}
    for block, tag in zip(raw.cells, tags, strict=True):
        if block.type in LINES:
            for row, which in zip(block.data.tolist(), tag, strict=True):
                if (1, int(which)) in groups:
                    curves.setdefault(groups[1, int(which)], set()).add((row[0], row[1]))
        elif block.type in CORNERS:
            count = CORNERS[block.type]
            for row, which in zip(block.data.tolist(), tag, strict=True):
                cell = frozenset(row[:count])
                cells[count][cell] = row[:count]
                for k in range(count if len(row) > count else 0):
                    a, b = row[k], row[(k + 1) % count]
                    midsides[min(a, b), max(a, b)] = row[count + k]
                if (2, int(which)) in groups:
                    surfaces.setdefault(groups[2, int(which)], set()).add(cell)
        elif block.type != "vertex":
            allowed = ", ".join((*CORNERS, *LINES, "vertex"))
            raise ValueError(f"cells of type {block.type} make no plate; allowed {allowed}")
    for name, by_block in raw.cell_sets.items():  # of format 4 all groups of a cell, where its tags hold one
        dimensions = {int(dimension) for known, (_, dimension) in raw.field_data.items() if known == name}
        for block, rows in zip(raw.cells, by_block, strict=True):
            for row in block.data[rows].tolist() if len(rows) else ():
                if 1 in dimensions and block.type in LINES:
                    curves.setdefault(name, set()).add((row[0], row[1]))
                elif 2 in dimensions and block.type in CORNERS:
                    surfaces.setdefault(name, set()).add(frozenset(row[: CORNERS[block.type]]))
    if not any(cells.values()):
        raise ValueError("no triangles and no quadrilaterals")
    order = {cell: k for k, cell in enumerate([*cells[4], *cells[3]])}
    return {
        "points": [[float(x), float(y)] for x, y in unit * raw.points[:, :2]],
        "quads": list(cells[4].values()),
        "triangles": list(cells[3].values()),
        "midsides": [[*ends, middle] for ends, middle in sorted(midsides.items())],
        "surface": {names.get(name, name): sorted(order[one] for one in own) for name, own in surfaces.items()},
        "curve": {names.get(name, name): sorted(own) for name, own in curves.items()},
    }


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
    except (meshio.ReadError, OSError, ValueError, KeyError, IndexError, AssertionError) as error:
        raise ValueError(f"no Gmsh mesh that can be read ({error})") from error
    points: NDArray[np.float64] = raw.points
    if len(points) > MOST_POINTS:
        raise ValueError(f"{len(points)} points; allowed at most {MOST_POINTS}: a few hundred are enough")
    if not np.isfinite(points).all():
        raise ValueError("holds a number that is not finite")
    return raw
