"""Meshes made elsewhere: Gmsh's files, with patches, zones and edges as physical groups."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.geometry.fault import GeometryError, at
from simulation.meshing.mesher import LEAST_RATIO, Border
from simulation.meshing.plate_mesh import CURVE_DEGREE, BorderEdges, PlateMesh, edges_of
from simulation.meshing.quality import jacobian_ratio
from simulation.shell.lobatto import lobatto

Real = NDArray[np.float64]
Whole = NDArray[np.int_]

PLATE = "plate"
"""Group of what belongs to no patch and no zone."""
SURFACES = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
LINES = ("line", "line3")
NEAR = 0.98
"""Where on an edge, between -1 and 1, its curve is looked up: at a corner two curves are equally near."""


@dataclass(frozen=True)
class Gmsh:
    """What a file holds: points (K, 2), m; cells by their points, midside nodes included; groups by name."""

    points: Real
    triangles: Whole
    quads: Whole
    midsides: dict[tuple[int, int], int]
    """By the two points of an edge, ascending."""
    surfaces: dict[str, set[frozenset[int]]]
    """Corners of the cells of each group."""
    lines: dict[str, set[tuple[int, int]]]


def foreign_mesh(
    path: Path, borders: Sequence[Border], *, unit: float = 1.0, tolerance: float = 1e-4
) -> PlateMesh:
    """Read a mesh of triangles and quadrilaterals, straight or quadratic.

    Every border of a patch or zone needs a physical surface of its name. A physical curve of a border's name is
    held against it. A group ``plate`` may hold the rest.

    Parameters
    ----------
    path : Path
        Of Gmsh, any version that meshio reads.
    borders : sequence of Border
        What the plate is declared to be.
    unit : float
        Length of one unit of the file, m.
    tolerance : float
        Largest distance of an edge from its border, m.

    Raises
    ------
    ImportError
        Where meshio is not installed.
    ValueError
        For a file that cannot be read, and groups that are unknown or missing.
    GeometryError
        For cells that are turned over, and a mesh that does not fit the borders.
    """
    read = _read(path, unit)
    _check_groups(read, borders)
    quads, triangles = _turned_alike(read)
    used = np.unique(np.concatenate([quads.ravel(), triangles.ravel()]))
    number = np.full(len(read.points), -1)
    number[used] = np.arange(used.size)
    points, quads, triangles = read.points[used], number[quads], number[triangles]
    edges = edges_of(quads, triangles)
    bow = np.zeros((len(edges), CURVE_DEGREE - 1, 2))
    for k, (a, b) in enumerate(edges):
        middle = read.midsides.get((int(min(used[a], used[b])), int(max(used[a], used[b]))))
        if middle is not None:
            away = read.points[middle] - 0.5 * (points[a] + points[b])
            if np.hypot(*away) > 1e-9 * np.hypot(*(points[a] - points[b])):
                bow[k, 0] = away / lobatto(2, 0.0)[0][0]
    cells = [frozenset(int(used[k]) for k in cell) for cell in (*quads, *triangles)]
    inside = {
        border.name: np.array(
            [border.kind == "outline" or cell in read.surfaces.get(border.name, ()) for cell in cells]
        )
        for border in borders
    }
    mesh = PlateMesh(points, quads, triangles, edges, bow, inside, {})
    ratio = jacobian_ratio(mesh)
    if ratio.min() < LEAST_RATIO:
        place = mesh.centers[ratio.argmin()]
        raise GeometryError(f"{path.name}: the cell at {at(place)} is turned over, or nearly so", place)
    found = _borders(mesh, borders, path.name, tolerance)
    named = {key: {(int(number[a]), int(number[b])) for a, b in pairs} for key, pairs in read.lines.items()}
    _check_lines(mesh, found, named, path.name)
    return PlateMesh(points, quads, triangles, edges, bow, inside, found)


def _read(path: Path, unit: float) -> Gmsh:
    import meshio

    try:
        raw = meshio.gmsh.read(path)
    except (meshio.ReadError, OSError, ValueError, KeyError, IndexError, AssertionError) as error:
        raise ValueError(f"{path.name}: no Gmsh mesh that can be read ({error})") from error
    height = raw.points[:, 2:]
    if height.size and np.ptp(height) > 1e-6 * np.ptp(raw.points):
        raise ValueError(
            f"{path.name}: points differ in z; the mesh of a plate is plane, its curvature is declared"
        )
    names = {(int(dimension), int(tag)): name for name, (tag, dimension) in raw.field_data.items()}
    tags = raw.cell_data.get("gmsh:physical", [np.zeros(len(block.data), int) for block in raw.cells])
    corners: dict[int, dict[frozenset[int], Whole]] = {3: {}, 4: {}}
    midsides: dict[tuple[int, int], int] = {}
    surfaces: dict[str, set[frozenset[int]]] = {}
    lines: dict[str, set[tuple[int, int]]] = {}
    for block, tag in zip(raw.cells, tags, strict=True):
        if block.type in LINES:
            for row, which in zip(block.data, tag, strict=True):
                name = names.get((1, int(which)))
                if name is not None:
                    lines.setdefault(name, set()).add((int(row[0]), int(row[1])))
        elif block.type in SURFACES:
            count = SURFACES[block.type]
            for row, which in zip(block.data, tag, strict=True):
                cell = frozenset(int(k) for k in row[:count])
                corners[count][cell] = row[:count]
                for k in range(count if len(row) > count else 0):
                    a, b = int(row[k]), int(row[(k + 1) % count])
                    midsides[min(a, b), max(a, b)] = int(row[count + k])
                name = names.get((2, int(which)))
                if name is not None:
                    surfaces.setdefault(name, set()).add(cell)
        elif block.type != "vertex":
            allowed = ", ".join((*SURFACES, *LINES, "vertex"))
            raise ValueError(f"{path.name}: cells of type {block.type} make no plate; allowed {allowed}")
    triangles, quads = (np.array(list(corners[n].values()), int).reshape(-1, n) for n in (3, 4))
    if not triangles.size + quads.size:
        raise ValueError(f"{path.name}: no triangles and no quadrilaterals")
    return Gmsh(unit * raw.points[:, :2], triangles, quads, midsides, surfaces, lines)


def _check_groups(read: Gmsh, borders: Sequence[Border]) -> None:
    inner = [border.name for border in borders if border.kind == "inner"]
    for groups, known, what in (
        (read.surfaces, [PLATE, *inner], "surface"),
        (read.lines, [border.name for border in borders], "curve"),
    ):
        unknown = sorted(set(groups) - set(known))
        if unknown:
            raise ValueError(f"physical {what} {unknown[0]!r} is unknown; this plate has {', '.join(known)}")
    missing = [name for name in inner if name not in read.surfaces]
    if missing:
        has = ", ".join(sorted(read.surfaces)) or "none"
        raise ValueError(f"physical surface {missing[0]!r} is missing; the mesh has {has}")


def _turned_alike(read: Gmsh) -> tuple[Whole, Whole]:
    """Quadrilaterals and triangles, counter-clockwise; GeometryError where some are turned over."""
    areas = []
    for cells in (read.quads, read.triangles):
        x, y = np.moveaxis(read.points[cells], -1, 0)
        areas.append(0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1))
    area = np.concatenate(areas)
    if (area < 0.0).all():  # a surface seen from below
        return read.quads[:, ::-1], read.triangles[:, ::-1]
    if not (area > 0.0).all():
        rare = area <= 0.0 if (area > 0.0).sum() >= (area < 0.0).sum() else area >= 0.0
        cell = int(np.flatnonzero(rare)[0])
        all_cells = [*read.quads, *read.triangles]
        place = read.points[all_cells[cell]].mean(axis=0)
        raise GeometryError(
            f"{int(rare.sum())} cells of the mesh are turned over; the first at {at(place)}", place
        )
    return read.quads, read.triangles


def _borders(mesh: PlateMesh, borders: Sequence[Border], name: str, tolerance: float) -> dict[str, BorderEdges]:
    """Edges along every border: of the rim for outline and holes, between its cells and others for the rest."""
    cells = [*zip(mesh.quad_edges, range(len(mesh.quads)), strict=True)]
    cells += [*zip(mesh.triangle_edges, range(len(mesh.quads), mesh.cells), strict=True)]
    sharing = np.zeros((len(borders) + 1, len(mesh.edges)), int)
    for edges, cell in cells:
        sharing[-1, edges] += 1
        for k, border in enumerate(borders):
            sharing[k, edges] += int(mesh.inside[border.name][cell])
    rim = np.flatnonzero(sharing[-1] == 1)
    if sharing[-1].max() > 2:
        place = mesh.points[mesh.edges[sharing[-1].argmax()]].mean(axis=0)
        raise GeometryError(f"{name}: more than two cells share the edge at {at(place)}", place)
    outer = [border for border in borders if border.kind != "inner"]
    middle = _along(mesh, rim, 0.0)
    away = np.array([border.loop.nearest(middle).distance for border in outer])
    if away.min(axis=0).max() > tolerance:
        place = middle[away.min(axis=0).argmax()]
        raise GeometryError(
            f"{name}: the mesh ends at {at(place)}, {1e3 * away.min(axis=0).max():.3g} mm away from the edge of "
            f"the plate; allowed {1e3 * tolerance:g} mm",
            place,
        )
    found = {border.name: _spans(mesh, rim[away.argmin(axis=0) == k], border) for k, border in enumerate(outer)}
    for k, border in enumerate(borders):
        if border.kind != "inner":
            continue
        own = np.flatnonzero(sharing[k] == 1)
        far = border.loop.nearest(_along(mesh, own, 0.0)).distance
        if far.max() > tolerance:
            place = _along(mesh, own, 0.0)[far.argmax()]
            raise GeometryError(
                f"{name}: physical surface {border.name!r} ends at {at(place)}, {1e3 * far.max():.3g} mm away "
                f"from its declared border; allowed {1e3 * tolerance:g} mm",
                place,
            )
        found[border.name] = _spans(mesh, own, border)
    return found


def _along(mesh: PlateMesh, edges: Whole, s: float) -> Real:
    """Points (K, 2) on edges at s in [-1, 1]."""
    a, b = np.moveaxis(mesh.points[mesh.edges[edges]], 1, 0)
    bent = np.einsum("c,kcd->kd", lobatto(CURVE_DEGREE, s)[0], mesh.bow[edges])
    return np.asarray(0.5 * (1.0 - s) * a + 0.5 * (1.0 + s) * b + bent)


def _spans(mesh: PlateMesh, edges: Whole, border: Border) -> BorderEdges:
    middle, *ends = (border.loop.nearest(_along(mesh, edges, s)) for s in (0.0, -NEAR, NEAR))
    span = np.stack([middle.t + (end.t - middle.t) / NEAR for end in ends], axis=1).clip(0.0, 1.0)
    return BorderEdges(edges, middle.curve.astype(int), span)


def _check_lines(
    mesh: PlateMesh, found: dict[str, BorderEdges], lines: dict[str, set[tuple[int, int]]], name: str
) -> None:
    """Hold physical curves against the borders whose names they have."""
    for group, pairs in lines.items():
        own = {(int(a), int(b)) for a, b in mesh.edges[found[group].edge]}
        wrong = [pair for pair in pairs if (min(pair), max(pair)) not in own]
        if wrong:
            place = mesh.points[list(wrong[0])].mean(axis=0)
            raise GeometryError(f"{name}: physical curve {group!r} leaves its border at {at(place)}", place)
