"""Plates as solids for CalculiX: hexahedral meshes of 20 nodes, input file, natural frequencies."""

import itertools
import re
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Real, Whole

CORNERS = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
BELOW = ((1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0))
ABOVE = ((1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2))
BETWEEN = ((0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1))
NODES = np.array([*CORNERS, *BELOW, *ABOVE, *BETWEEN])
"""Places of an element's nodes in half elements, in the order of C3D20R."""
MERGED = 1e-8
"""Nodes nearer than this are one, m."""

Place = Callable[[Real, Real], tuple[Real, Real]]


@dataclass(frozen=True)
class Solid:
    """An elastic material.

    Attributes
    ----------
    constants : tuple of float
        E [Pa] and nu; or E1, E2, E3, nu12, nu13, nu23, G12, G13, G23.
    density : float
        kg/m3.
    """

    constants: tuple[float, ...]
    density: float

    def lines(self, name: str) -> list[str]:
        """Cards of CalculiX."""
        kind = "ISO" if len(self.constants) == 2 else "ENGINEERING CONSTANTS"
        values = [f"{value:.10e}" for value in self.constants]
        if kind != "ISO":
            values = [*values[:8], "\n" + values[8]]
        return [f"*MATERIAL, NAME={name}", f"*ELASTIC, TYPE={kind}", ", ".join(values).replace(", \n", ",\n"),
                "*DENSITY", f"{self.density:.10e}", f"*SOLID SECTION, ELSET={name}, MATERIAL={name}"]  # fmt: skip


@dataclass(frozen=True)
class Layer:
    """Part of a block between two heights over the mid-plane, m, of a material; `cells` per unit of refinement."""

    low: float
    high: float
    material: str
    cells: float = 1.0


@dataclass(frozen=True)
class Block:
    """A piece of the plate that is a square in its own coordinates, 0 to 1.

    Attributes
    ----------
    place : callable
        From coordinates (K,), (K,) to x and y, m.
    cells : (float, float)
        Along both, per unit of refinement.
    layers : tuple of Layer
    """

    place: Place
    cells: tuple[float, float]
    layers: tuple[Layer, ...]


def straight(x: tuple[float, float], y: tuple[float, float]) -> Place:
    """Return the map of a block onto a rectangle."""
    return lambda s, t: (x[0] + s * (x[1] - x[0]), y[0] + t * (y[1] - y[0]))


@dataclass(frozen=True)
class Mesh:
    """Nodes (N, 3), m, and by material elements (C, 20)."""

    nodes: Real
    elements: dict[str, Whole]


def meshed(blocks: Sequence[Block], refinement: int, lift: Callable[[Real], Real] | None = None) -> Mesh:
    """Mesh the blocks; neighbours must have the same cells along their common side.

    Parameters
    ----------
    blocks : sequence of Block
    refinement : int
        Factor on all numbers of cells.
    lift : callable, optional
        From places (N, 3) on the flat plate to those on the curved one.

    Returns
    -------
    Mesh
    """
    points: list[Real] = []
    parts: dict[str, list[Whole]] = {}
    first = 0
    for block, layer in [(one, layer) for one in blocks for layer in one.layers]:
        counts = [max(round(refinement * cells), 1) for cells in (*block.cells, layer.cells)]
        axes = [np.linspace(0.0, 1.0, 2 * count + 1) for count in counts]
        s, t, up = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
        points.append(np.stack([*block.place(s, t), layer.low + up * (layer.high - layer.low)], axis=1))
        number = first + np.arange(s.size).reshape([2 * count + 1 for count in counts])
        starts = itertools.product(*(range(0, 2 * count, 2) for count in counts))
        cells = np.array([number[tuple((NODES + start).T)] for start in starts])
        parts.setdefault(layer.material, []).append(cells)
        first += s.size
    return _merged(np.vstack(points), {name: np.vstack(cells) for name, cells in parts.items()}, lift)


def _merged(points: Real, elements: dict[str, Whole], lift: Callable[[Real], Real] | None) -> Mesh:
    """Make one node of equal ones, and leave out those of no element."""
    _, kept, same = np.unique(
        np.round(points / MERGED).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    points, elements = points[kept], {name: same.ravel()[cells] for name, cells in elements.items()}
    used = np.unique(np.concatenate([cells.ravel() for cells in elements.values()]))
    new = np.full(len(points), -1)
    new[used] = np.arange(used.size)
    points = points[used]
    return Mesh(points if lift is None else lift(points), {name: new[cells] for name, cells in elements.items()})


def frequencies(mesh: Mesh, materials: dict[str, Solid], count: int, held: Whole | None = None) -> Real:
    """Lowest natural frequencies by CalculiX, Hz, ascending, rigid motions included.

    Parameters
    ----------
    mesh : Mesh
    materials : dict of str to Solid
    count : int
    held : (H,) ndarray of int, optional
        Nodes that do not move.

    Returns
    -------
    (count,) ndarray

    Raises
    ------
    RuntimeError
        If CalculiX is not installed or gives no eigenvalues.
    """
    with tempfile.TemporaryDirectory() as folder:
        done = solved(Path(folder), mesh, materials, ["*FREQUENCY", f"{count}"], held)
        written = Path(folder) / "plate.dat"
        found = _eigenvalues(written.read_text(encoding="ascii")) if written.is_file() else np.zeros(0)
    if found.size < count:
        raise RuntimeError(f"ccx gave {found.size} of {count} eigenvalues: {done[-2000:]}")
    return np.sort(np.sqrt(np.abs(found[:count]))) / (2.0 * np.pi)


def solved(
    folder: Path, mesh: Mesh, materials: dict[str, Solid], step: Sequence[str], held: Whole | None = None
) -> str:
    """Let CalculiX write its files ``plate.*`` into a folder.

    Parameters
    ----------
    folder : Path
    mesh : Mesh
    materials : dict of str to Solid
    step : sequence of str
        Lines of its input that say what is solved.
    held : (H,) ndarray of int, optional
        Nodes that do not move.

    Returns
    -------
    str
        What it printed.

    Raises
    ------
    RuntimeError
        If CalculiX is not installed.
    """
    solver = shutil.which("ccx")
    if solver is None:
        raise RuntimeError("ccx is not installed: apt-get install calculix-ccx")
    text = ["*NODE, NSET=ALL"]
    text += [f"{k + 1}, {x:.12e}, {y:.12e}, {z:.12e}" for k, (x, y, z) in enumerate(mesh.nodes)]
    number = itertools.count(1)
    for name, cells in mesh.elements.items():
        text.append(f"*ELEMENT, TYPE=C3D20R, ELSET={name}")
        for cell in cells + 1:
            row = [str(next(number)), *map(str, cell)]
            text += [", ".join(row[:11]) + ",", ", ".join(row[11:])]
        text += materials[name].lines(name)
    if held is not None and held.size:
        text += ["*BOUNDARY", *(f"{node + 1}, 1, 3" for node in held)]
    text += ["*STEP", *step, "*END STEP", ""]
    (folder / "plate.inp").write_text("\n".join(text), encoding="ascii")
    return subprocess.run([solver, "plate"], cwd=folder, capture_output=True, text=True, check=False).stdout


def _eigenvalues(text: str) -> Real:
    """Eigenvalues, rad2/s2, of a result file."""
    row = re.compile(r"^\s+\d+((?:\s+[-+]?\d\.\d+E[-+]\d+){4})\s*$", re.MULTILINE)
    return np.array([float(found.split()[0]) for found in row.findall(text)])
