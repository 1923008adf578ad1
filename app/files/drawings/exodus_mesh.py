"""Meshes of Exodus II, as Cubit, Coreform and the programs of SEACAS write them.

An Exodus file is a netCDF file of agreed names (Schoof and Yarberry, SAND92-2137): points ``coordx``,
``coordy``, ``coordz``, or ``coord``; blocks of cells ``connect1``, ``connect2`` ... whose attribute
``elem_type`` names the kind of cell; side sets ``elem_ss1`` and ``side_ss1``, which number edges of cells.
meshio reads neither the names of blocks nor side sets, of which patches and the outline are made, and needs
netCDF's library; hence the file is read here: with scipy where it is a classic netCDF file, with h5py where it
is netCDF-4.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Whole

ENDINGS = (".e", ".exo", ".ex2", ".g")
CLASSIC, OF_HDF5, OF_64_BITS = (b"CDF\x01", b"CDF\x02"), b"\x89HDF", b"CDF\x05"
CELLS = {
    ("QUAD", 4): "quad",
    ("QUAD", 8): "quad8",
    ("QUAD", 9): "quad9",
    ("TRI", 3): "triangle",
    ("TRI", 6): "triangle6",
    ("BAR", 2): "line",
    ("BAR", 3): "line3",
    ("SPHERE", 1): "vertex",
}
"""Meshio's names of cells by Exodus' family and points of a cell; corners and midpoints come in the same order."""
FAMILIES = {"TRUSS": "BAR", "BEAM": "BAR", "EDGE": "BAR", "ROD": "BAR", "CIRCLE": "SPHERE", "POINT": "SPHERE"}
FACES = 2
"""Sides of a shell before its edges: its two faces."""


@dataclass(frozen=True)
class CellBlock:
    """Cells of one type (as meshio calls it) by their points, (M, n), counted from 0."""

    type: str
    data: Whole


@dataclass(frozen=True)
class ExodusMesh:
    """A mesh with the attributes of ``meshio.Mesh`` that `app.files.drawings.mesh_reader` reads.

    Attributes
    ----------
    points : (N, 2 or 3) ndarray
    cells : list of CellBlock
        Blocks of the file, and an additional one of lines for each side set.
    cell_sets : mapping
        Rows of every block that belong to a group, by its name: the name and the number of a block; the name of a
        side set, or ``side 4`` for the one of number 4.
    """

    points: NDArray[np.float64]
    cells: list[CellBlock]
    cell_sets: Mapping[str, list[Whole]]
    field_data: Mapping[str, Any] = field(default_factory=dict)
    cell_data: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class _Variables:
    """Variables of the file by name, and the types of cells by block."""

    values: Mapping[str, NDArray[Any]]
    types: Mapping[str, str]

    def integers(self, name: str) -> Whole:
        return np.asarray(self.values[name]).astype(np.int64)

    def names(self, name: str, count: int) -> list[str]:
        """Return names of blocks or sets; empty ones where the file has none."""
        if name not in self.values:
            return [""] * count
        rows = [b"".join(np.asarray(row, dtype="S1")) for row in self.values[name]]
        return [row.split(b"\0")[0].decode("utf-8", "replace").strip() for row in rows]

    def numbered(self, stem: str) -> list[int]:
        """Return the numbers in the names of variables with this stem, ascending."""
        found = (re.fullmatch(rf"{stem}(\d+)", name) for name in self.values)
        return sorted(int(one[1]) for one in found if one)


def read(path: Path) -> ExodusMesh:
    """Read a mesh.

    Raises
    ------
    ValueError, KeyError
        For what is no mesh of Exodus.
    """
    file = _variables(path)
    if not (numbers := file.numbered("connect")):
        raise ValueError("it has no blocks of cells")
    points = _points(file)
    blocks, families = [], []
    for number in numbers:
        rows = np.atleast_2d(file.integers(f"connect{number}")) - 1
        if rows.min(initial=0) < 0 or rows.max(initial=0) >= len(points):
            raise ValueError(f"cells of block {number} name points beyond its {len(points)}")
        family = re.sub(r"\d+$", "", file.types.get(f"connect{number}", "").strip().upper())
        blocks.append(_block(family, rows))
        families.append(family)
    groups = _of_blocks(file, blocks)
    cells = list(blocks)
    for name, lines in _side_sets(file, blocks, families, solid=points.shape[1] == 3):
        groups[name] = [*(np.array([], dtype=int) for _ in cells), np.arange(len(lines))]
        cells.append(CellBlock("line", lines))
    return ExodusMesh(points, cells, groups)


def _variables(path: Path) -> _Variables:
    head = path.read_bytes()[:4]
    if head == OF_64_BITS:
        raise ValueError("netCDF of 64-bit data (CDF-5) is not read; write it as netCDF-4, or by nccopy -k nc4")
    if head == OF_HDF5:
        import h5py

        with h5py.File(path) as file:
            sets = {name: one for name, one in file.items() if isinstance(one, h5py.Dataset) and one.shape}
            texts = {name: one.attrs["elem_type"] for name, one in sets.items() if "elem_type" in one.attrs}
            return _Variables({name: one[()] for name, one in sets.items() if _used(name)}, _texts(texts))
    if head not in CLASSIC:
        raise ValueError("it is no netCDF file")
    from scipy.io import netcdf_file

    with netcdf_file(path, mmap=False) as file:
        texts = {name: one.elem_type for name, one in file.variables.items() if hasattr(one, "elem_type")}
        values = {name: np.array(one.data) for name, one in file.variables.items() if _used(name)}
        return _Variables(values, _texts(texts))


def _used(name: str) -> bool:
    """Tell a variable of the mesh from results over time, which may be large."""
    return re.fullmatch(r"coord[xyz]?|connect\d+|(elem|side)_ss\d+|(eb|ss)_(names|prop1)", name) is not None


def _texts(attributes: Mapping[str, Any]) -> dict[str, str]:
    flat = {name: np.asarray(one).ravel()[0] if np.ndim(one) else one for name, one in attributes.items()}
    return {
        name: one.decode("ascii", "replace") if isinstance(one, bytes) else str(one) for name, one in flat.items()
    }


def _points(file: _Variables) -> NDArray[np.float64]:
    if "coord" in file.values:
        return np.asarray(file.values["coord"], dtype=float).T
    axes = [file.values[name] for name in ("coordx", "coordy", "coordz") if name in file.values]
    return np.column_stack([np.asarray(one, dtype=float) for one in axes])


def _block(family: str, rows: Whole) -> CellBlock:
    count = rows.shape[1]
    usual = FAMILIES.get(family, family)
    if "SHELL" in usual:  # SHELL4 and TRISHELL3, and SHELL3 of some programs
        usual = "TRI" if count in (3, 6, 7) else "QUAD"
    elif usual.startswith("TRI"):
        usual = "TRI"
    if (usual, count) == ("TRI", 7):  # with a point in the middle, which no edge needs
        rows, count = rows[:, :6], 6
    return CellBlock(CELLS.get((usual, count), f"{family or 'unknown'}{count}"), rows)


def _of_blocks(file: _Variables, blocks: list[CellBlock]) -> dict[str, list[Whole]]:
    """Rows of every block under its name and under its number; blocks of one name are one group."""
    groups: dict[str, list[Whole]] = {}
    ids, names = _ids(file, "eb_prop1", len(blocks)), file.names("eb_names", len(blocks))
    for k, (number, name) in enumerate(zip(ids, names, strict=False)):
        for group in dict.fromkeys([str(number), name]):
            if group:
                rows = groups.setdefault(group, [np.array([], dtype=int) for _ in blocks])
                rows[k] = np.arange(len(blocks[k].data))
    return groups


def _ids(file: _Variables, name: str, count: int) -> list[int]:
    found: list[int] = file.integers(name).tolist() if name in file.values else []
    return found if len(found) == count else list(range(1, count + 1))


def _side_sets(
    file: _Variables, blocks: list[CellBlock], families: list[str], *, solid: bool
) -> Iterator[tuple[str, Whole]]:
    """Yield the name of every side set and the ends of its edges, (M, 2); faces of shells are left out.

    Sides are numbered as in ``ex_get_side_set_node_list`` of Exodus' library: shells, and triangles in space, have
    two faces before their edges.
    """
    numbers = file.numbered("elem_ss")
    names, ids = file.names("ss_names", len(numbers)), _ids(file, "ss_prop1", len(numbers))
    first = np.cumsum([0, *(len(one.data) for one in blocks)])
    for k, number in enumerate(numbers):
        elements, sides = file.integers(f"elem_ss{number}") - 1, file.integers(f"side_ss{number}") - 1
        if elements.shape != sides.shape or elements.min(initial=0) < 0 or elements.max(initial=-1) >= first[-1]:
            raise ValueError(f"side set {ids[k]} names cells beyond its {first[-1]}")
        lines = []
        for element, side in zip(elements.tolist(), sides.tolist(), strict=True):
            j = int(np.searchsorted(first, element, side="right")) - 1
            corners = {"t": 3, "q": 4}.get(blocks[j].type[0], 0)
            shell = "SHELL" in families[j] or (solid and corners == 3)
            edge = side - FACES if shell else side
            if 0 <= edge < corners:
                row = blocks[j].data[element - first[j]]
                lines.append((row[edge], row[(edge + 1) % corners]))
        if lines:
            yield names[k] if k < len(names) and names[k] else f"side {ids[k]}", np.array(lines)
