"""Gmsh's files read by meshio, in a process of its own (`app.files.gmsh` starts it): ``FILE.msh NUMBERS.json``."""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.foreign_mesh import MOST_POINTS
from app.files.isolation import hold_memory

CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
LINES = ("line", "line3")
MEMORY = 1_500_000_000
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
    """Name of a physical surface or curve, and type and points of one of its cells.

    Format 4.1 gives all groups of a cell (`cell_sets`), others one tag a cell.
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
    import meshio  # an extra

    try:
        raw = meshio.gmsh.read(path)
    except MemoryError:
        raise
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


if __name__ == "__main__":
    try:
        hold_memory(MEMORY)
        Path(sys.argv[2]).write_text(json.dumps(numbers_of(Path(sys.argv[1]))), encoding="utf-8")
    except MemoryError:
        sys.exit(f"needs more than {MEMORY / 1e9} GB of memory: damaged, or its points have numbers far too large")
    except Exception as error:  # noqa: BLE001 (reported to the parent process)
        sys.exit(" ".join(str(error).split()) or type(error).__name__)
