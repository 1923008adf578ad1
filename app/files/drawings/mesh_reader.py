"""Meshes read in a process of its own, which `app.files.drawings.drawing` starts: ``FILE.msh NUMBERS.json``."""

import json
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.declaration.plate import MOST_POINTS
from app.files.drawings import exodus_mesh
from app.files.isolation import hold_memory

LIBRARY = {
    ".msh": ("gmsh", "Gmsh"),
    ".inp": ("abaqus", "Abaqus"),
    ".bdf": ("nastran", "Nastran"),
    ".nas": ("nastran", "Nastran"),
    ".fem": ("nastran", "Nastran"),
    ".vtk": ("vtk", "VTK"),
    ".vtu": ("vtu", "VTK"),
    **dict.fromkeys(exodus_mesh.ENDINGS, ("", "Exodus")),
}
"""Module of meshio, none where it is read by our own, and program by ending."""
CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
LINES = ("line", "line3")
ADDRESS_SPACE = 1_500_000_000
"""Bytes of address space: Python with meshio has 0.2 GB, the largest file it may read takes 1 GB."""


def numbers_of(path: Path) -> dict[str, Any]:
    """Points in the file's unit, cells and curves by their points, surfaces by their cells, counted from 0.

    Raises
    ------
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
            surfaces.setdefault(name, set()).add(frozenset(row[: CORNERS[kind]]))
        else:
            curves.setdefault(name, set()).add((row[0], row[1]))
    if not any(cells.values()):
        raise ValueError("no triangles and no quadrilaterals")
    order = {cell: k for k, cell in enumerate([*cells[4], *cells[3]])}
    return {
        "points": raw.points[:, :2].tolist(),
        "quads": list(cells[4].values()),
        "triangles": list(cells[3].values()),
        "midsides": [[*ends, middle] for ends, middle in sorted(midsides.items())],
        "surface": {name: sorted(order[one] for one in own) for name, own in surfaces.items()},
        "curve": {name: sorted(own) for name, own in curves.items()},
    }


def _grouped(raw: Any) -> Iterator[tuple[str, str, list[int]]]:
    """Name of a surface or curve, and type and points of one of its cells.

    Gmsh's format 4.1 and Abaqus give all groups of a cell (`cell_sets`), others one number a cell.
    """
    if not raw.field_data:
        yield from _of_sets_and_numbers(raw)
        return
    tags = raw.cell_data.get("gmsh:physical", [])
    for name, (tag, dimension) in raw.field_data.items():
        rows = raw.cell_sets.get(name) or [np.flatnonzero(one == tag) for one in tags]
        kinds = {1: LINES, 2: tuple(CORNERS)}.get(int(dimension), ())
        for block, chosen in zip(raw.cells, rows, strict=False):  # none where no cell is tagged
            if block.type in kinds:
                for row in block.data[chosen].tolist():
                    yield name, block.type, row


def _of_sets_and_numbers(raw: Any) -> Iterator[tuple[str, str, list[int]]]:
    """Yield the same of files without Gmsh's names: sets by name, and every whole number of a cell."""
    groups = {name: rows for name, rows in raw.cell_sets.items() if not name.startswith("gmsh:")}
    for numbers in raw.cell_data.values():
        if all(np.asarray(one).dtype.kind in "iu" and np.ndim(one) == 1 for one in numbers):
            for number in np.unique(np.concatenate(numbers)).tolist():
                groups[str(number)] = [np.flatnonzero(one == number) for one in numbers]
    for name, rows in groups.items():
        for block, chosen in zip(raw.cells, rows, strict=False):
            if chosen is not None and block.type in (*CORNERS, *LINES):
                for row in block.data[np.asarray(chosen, dtype=int)].tolist():
                    yield name, block.type, row


def _check_abaqus(path: Path) -> None:
    """Raise ValueError for what meshio would read wrongly: other files named in it, and sets in several parts."""
    seen: set[str] = set()
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        word, *options = (part.strip() for part in line.upper().split(","))
        if word == "*INCLUDE":
            raise ValueError("*INCLUDE: other files are not read; write the whole mesh into one file")
        name = next((one.partition("=")[2].strip() for one in options if one.startswith("ELSET=")), "")
        if word == "*ELSET" and name in seen:
            raise ValueError(f"*ELSET {name} stands in several parts, of which only one is read; join them")
        seen |= {name} if word == "*ELSET" else set()


def _read(path: Path) -> Any:
    """Let meshio read a file; ValueError for what it cannot."""
    if path.suffix.lower() not in LIBRARY:
        raise ValueError(f"ending {path.suffix!r} is none of a mesh; allowed: {', '.join(LIBRARY)}")
    module, program = LIBRARY[path.suffix.lower()]
    if module == "abaqus":
        _check_abaqus(path)
    try:
        raw = import_module(f"meshio.{module}").read(path) if module else exodus_mesh.read(path)
    except MemoryError:
        raise
    except SystemExit as error:  # how meshio ends at some damage
        raise ValueError(f"no {program} mesh that can be read") from error
    except Exception as error:  # a damaged mesh leads the library into whatever there is
        raise ValueError(f"no {program} mesh that can be read ({error})") from error
    points: NDArray[np.float64] = np.asarray(raw.points, dtype=float)
    if points.ndim != 2:
        raise ValueError(f"no {program} mesh that can be read (it holds no points)")
    if len(points) > MOST_POINTS:
        raise ValueError(f"{len(points)} points; allowed at most {MOST_POINTS}: a few hundred are enough")
    if not np.isfinite(points).all():
        raise ValueError("holds a number that is not finite")
    return raw


if __name__ == "__main__":
    try:
        hold_memory(ADDRESS_SPACE)
        Path(sys.argv[2]).write_text(json.dumps(numbers_of(Path(sys.argv[1]))), encoding="utf-8")
    except MemoryError:
        sys.exit(
            f"needs more than {ADDRESS_SPACE / 1e9} GB of memory: "
            "damaged, or its points have numbers far too large"
        )
    except Exception as error:  # noqa: BLE001 (reported to the parent process)
        sys.exit(" ".join(str(error).split()) or type(error).__name__)
