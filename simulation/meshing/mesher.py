"""Mesh of a plate of any outline, with holes, zones of another thickness and patches, finer at its corners.

Strips of quadrilaterals run along every border; triangles fill the rest. Where strips overlap, or triangles are of
poor quality, strips are made narrower or pieces shorter there, and the mesh is made again; where there is no space
for a strip, triangles extend to the border.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Real, Whole
from analysis.geometry.loop import GeometryError, Loop, at
from simulation.meshing.arrangement import Arrangement, Face
from simulation.meshing.fill import Fill, crossing_sides, fill
from simulation.meshing.plate_mesh import (
    CURVE_DEGREE,
    BorderEdges,
    Cap,
    Cells,
    MeshRecipe,
    Path,
    PlateMesh,
    Repairs,
    Stretch,
    edges_of,
)
from simulation.meshing.strips import Cutter, Sizes, strips
from simulation.shell.shape_functions import bow_coefficients, map_cells

MOST_ROUNDS = 24
"""Repairs after which a mesh is given up: a message is better than a search that does not end."""
MOST_CUTS = 250
"""Largest number of halved pieces in all rounds: only nearly coincident borders would need more."""
LEAST_RATIO = 0.01
"""Smallest `jacobian_ratio` of a cell."""
NARROWEST_STRIP = 0.06
"""Share of the desired width below which a strip is left out."""


@dataclass(frozen=True)
class Border:
    """A closed line that the mesh follows.

    Attributes
    ----------
    name : str
        Key of its cells and edges in the mesh.
    loop : Loop
    kind : str
        ``outline``, ``hole`` or ``inner``: patches and zones.
    """

    name: str
    loop: Loop
    kind: str = "inner"


@dataclass
class MeshFault:
    """A place of poor mesh quality, and possible remedies."""

    place: Real
    face: int
    piece: tuple[int, int] | None
    """Points of the piece of a border that can be halved."""
    points: tuple[int, ...]
    """Ends of strips that can be made narrower."""
    narrow: bool
    """Whether to narrow strips rather than to halve pieces."""


def mesh_plate(
    borders: Sequence[Border],
    thickness: float,
    recipe: MeshRecipe | None = None,
    cuts: Sequence[tuple[float, float]] = (),
) -> PlateMesh:
    """Mesh the area inside the outline and outside the holes.

    Parameters
    ----------
    borders : sequence of Border
        One of them the outline.
    thickness : float
        Of the plate, m.
    cuts : sequence of points
        Points on borders where an edge must end, m: ends of supports.

    Raises
    ------
    GeometryError
        If no good mesh was found, with the place and the borders there.
    """
    recipe = recipe or MeshRecipe()
    try:
        plan = Arrangement.of([border.loop for border in borders], cuts)
    except GeometryError as error:
        raise GeometryError(f"{_nearest(borders, error.places[0])}: {error}", *error.places) from error
    outline = {k for k, border in enumerate(borders) if border.kind == "outline"}
    holes = {k for k, border in enumerate(borders) if border.kind == "hole"}
    faces = {k: face for k, face in enumerate(plan.faces) if outline <= face.inside and not holes & face.inside}
    cutter = Cutter.of(plan, faces, _sizes(plan, faces, borders, thickness, recipe))
    repairs = Repairs({}, (), frozenset())
    known: dict[bytes, Fill] = {}
    for _ in range(MOST_ROUNDS):
        cells = strips(cutter, repairs)
        triangles, owners, faults = _filled(cells, faces, recipe.bulk(thickness), recipe.growth, known)
        if not faults:
            mesh = _finished(plan, faces, borders, cells, triangles, owners, recipe)
            faults = list(_turned(mesh, cells, triangles, owners))
            if not faults:
                return mesh
        repairs = _repaired(repairs, faults, cells, cutter)
        if sum(map(len, repairs.splits.values())) > MOST_CUTS:
            break
    place = faults[0].place
    raise GeometryError(
        f"no good mesh near {at(place)}: the borders of {_nearest(borders, place)} come too close to each other "
        "there, or meet at too sharp an angle; move one of them by a millimetre",
        place,
    )


def _nearest(borders: Sequence[Border], place: ArrayLike) -> str:
    """Names of the two borders nearest to a place, or of the only one."""
    point = np.asarray(place, float)[None]
    return " and ".join(b.name for b in sorted(borders, key=lambda b: float(b.loop.distance(point)[0]))[:2])


def _sizes(
    plan: Arrangement,
    faces: Mapping[int, Face],
    borders: Sequence[Border],
    thickness: float,
    recipe: MeshRecipe,
) -> dict[int, Sizes]:
    """Sizes of every edge that bounds a meshed face."""
    seen = {(h.edge, h.backward) for face in faces.values() for cycle in face.cycles for h in cycle}
    found = {}
    for k, edge in enumerate(plan.edges):
        left, right = (k, False) in seen, (k, True) in seen
        if not (left or right):
            continue
        inner = any(borders[origin.border].kind == "inner" for origin in edge.origins)
        width = thickness * (recipe.strip if inner else recipe.edge_strip)
        pieces = recipe.pieces if inner and len(edge.origins) == 1 else 1
        found[k] = Sizes(width * left, width * right, recipe.bulk(thickness), recipe.turn, pieces)
    return found


def _filled(
    cells: Cells, faces: Iterable[int], spacing: float, growth: float, known: dict[bytes, Fill]
) -> tuple[Whole, list[int], list[MeshFault]]:
    """Triangles of every face (points appended to `cells`), their faces, and faults.

    `known` holds results of earlier rounds for the same rings.
    """
    triangles, owners = [np.array(cells.wedges, int).reshape(-1, 3)], [*cells.wedge_face]
    faults: list[MeshFault] = []
    places = []
    for face, rings in zip(faces, cells.rings, strict=True):
        own = [number for ring in rings for number in ring]
        count = np.cumsum([0, *map(len, rings)])
        local = [range(first, last) for first, last in pairwise(count)]
        points = np.array([cells.points[number] for number in own])
        places.append((face, own, local, points))
        crossed = crossing_sides(points, local)
        faults += [_fault(cells, face, own[a], own[b], narrow=True) for a, b in crossed]
    for face, own, local, points in places if not faults else ():
        key = points.tobytes() + bytes(len(local))
        if key not in known:
            known[key] = fill(points, local, spacing, growth)
        found = known[key]
        number = np.array([*own, *(cells.add(point) for point in found.points[len(own) :])])
        triangles.append(number[found.triangles])
        owners += [face] * len(found.triangles)
        faults += [_fault(cells, face, own[a], own[b], narrow=False) for a, b in found.missing or found.thin]
    return np.vstack(triangles), owners, faults


def _fault(cells: Cells, face: int, a: int, b: int, *, narrow: bool) -> MeshFault:
    """Fault of the side of a ring."""
    pair = (min(a, b), max(a, b))
    own = next((p for p in ((a, b), (b, a)) if p in cells.on_edge), None)
    place = 0.5 * (cells.points[a] + cells.points[b])
    piece = own or cells.inner.get(pair)
    if piece is not None and own is None:  # halving a piece does not shorten the end of its strip
        side, base = (np.hypot(*(cells.points[i] - cells.points[j])) for i, j in (pair, piece))
        narrow = narrow or bool(side > 1.5 * base)
    return MeshFault(place, face, piece, (a, b), narrow and any(k in cells.foot for k in pair))


def _turned(mesh: PlateMesh, cells: Cells, triangles: Whole, owners: Sequence[int]) -> Iterable[MeshFault]:
    """Faults of inverted or nearly inverted cells of a mesh."""
    for cell in np.flatnonzero(jacobian_ratio(mesh) < LEAST_RATIO).tolist():
        place = mesh.centers[cell]
        quads = len(cells.quads)
        corners = list(cells.quads[cell] if cell < quads else triangles[cell - quads])
        face = cells.quad_face[cell] if cell < quads else owners[cell - quads]
        pairs = [(int(corners[k - 1]), int(corners[k])) for k in range(len(corners))]
        curved = [p for pair in pairs for p in (pair, pair[::-1]) if p in cells.paths]
        piece = next((p for p in curved if p in cells.on_edge), None)
        if piece is None:
            piece = next((cells.inner[min(p), max(p)] for p in curved if (min(p), max(p)) in cells.inner), None)
        yield MeshFault(place, face, piece, tuple(k for k in corners if k in cells.foot), narrow=piece is None)


def _repaired(repairs: Repairs, faults: Sequence[MeshFault], cells: Cells, cutter: Cutter) -> Repairs:
    """Return the changes for the next round."""
    splits, caps, bare = dict(repairs.splits), list(repairs.caps), set(repairs.bare)
    for fault in faults:
        if fault.piece in cells.on_edge and not fault.narrow:
            edge, first, last = cells.on_edge[fault.piece]
            splits[edge] = splits.get(edge, frozenset()) | {round(0.5 * (first + last), 12)}
            continue
        feet = [cells.foot[k] for k in fault.points if k in cells.foot]
        halves = [half for cycle in cutter.faces[fault.face].cycles for half in cycle]
        if not feet:
            bare |= {Stretch(half, 0.0, 1.0) for half in halves}
        for foot in feet:
            if foot.width < NARROWEST_STRIP * max(map(cutter.width, halves)):
                bare |= set(foot.pieces)
            else:
                x, y = cells.points[foot.point]
                caps.append(Cap((float(x), float(y)), 0.5 * foot.width))
    return replace(repairs, splits=splits, caps=tuple(caps), bare=frozenset(bare))


def numbered(
    plan: Arrangement,
    faces: Mapping[int, Face],
    names: Sequence[str],
    cells: Cells,
    triangles: Whole,
    owners: Sequence[int],
) -> PlateMesh:
    """Build the mesh: number points, cells and edges, and fit curved edges.

    Parameters
    ----------
    names : sequence of str
        Of the borders.
    triangles : (T, 3) ndarray of int
        Points of `cells`.
    owners : sequence of int
        Faces of the triangles.
    """
    quads = np.array(cells.quads, int).reshape(-1, 4)
    used, flat = np.unique(np.concatenate([quads.ravel(), triangles.ravel()]), return_inverse=True)
    quads, fans = flat[: quads.size].reshape(-1, 4), flat[quads.size :].reshape(-1, 3)
    number = {int(old): new for new, old in enumerate(used)}
    edges = edges_of(quads, fans)
    place = {(int(a), int(b)): k for k, (a, b) in enumerate(edges)}
    bow = np.zeros((len(edges), CURVE_DEGREE - 1, 2))
    for (a, b), path in cells.paths.items():
        if a not in number or b not in number:
            continue
        one, two = number[a], number[b]
        edge = place.get((min(one, two), max(one, two)))
        if edge is not None:
            bow[edge] = bow_coefficients(path if one < two else part_of(path, 1.0, 0.0), CURVE_DEGREE)
    owner = np.array([*cells.quad_face, *owners], int)
    inside = {
        name: np.isin(owner, [f for f, face in faces.items() if k in face.inside]) for k, name in enumerate(names)
    }
    borders = _border_edges(plan, names, cells, number, place)
    return PlateMesh(np.array(cells.points)[used], quads, fans, edges, bow, inside, borders)


def _border_edges(
    plan: Arrangement,
    names: Sequence[str],
    cells: Cells,
    number: Mapping[int, int],
    place: Mapping[tuple[int, int], int],
) -> dict[str, BorderEdges]:
    rows: dict[str, list[tuple[float, ...]]] = {name: [] for name in names}
    for (a, b), (edge, first, last) in cells.on_edge.items():
        if a not in number or b not in number:
            continue
        one, two = number[a], number[b]
        mesh_edge = place.get((min(one, two), max(one, two)))
        if mesh_edge is None:
            continue
        for origin in plan.edges[edge].origins:
            span = [origin.first + t * (origin.last - origin.first) for t in (first, last)]
            if one > two:
                span.reverse()
            rows[names[origin.border]].append((mesh_edge, origin.curve, *span))
    found = {}
    for name, entries in rows.items():
        table = np.array(entries, float).reshape(-1, 4)
        found[name] = BorderEdges(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2:])
    return found


def _finished(
    plan: Arrangement,
    faces: Mapping[int, Face],
    borders: Sequence[Border],
    cells: Cells,
    triangles: Whole,
    owners: Sequence[int],
    recipe: MeshRecipe,
) -> PlateMesh:
    """Refine the corners and number points, cells and edges."""
    if recipe.grading:
        wanted = {corner for corner, outer in cells.corners.items() if recipe.outer_corners or not outer}
        corners = corners_apart(cells, wanted, set(triangles.ravel().tolist()))
        for _ in range(recipe.levels):
            graded(cells, recipe.grading, corners)
    return numbered(plan, faces, [border.name for border in borders], cells, triangles, owners)


POINTS_ALONG_SIDE = 5
"""Points along a side of a cell at which its Jacobian is evaluated."""


def jacobian_ratio(mesh: PlateMesh) -> Real:
    """Smallest over largest Jacobian of every cell, (cells,): 1 for parallelograms, below 0 for inverted ones."""
    side = np.linspace(-1.0, 1.0, POINTS_ALONG_SIDE)
    square = np.stack(np.meshgrid(side, side), axis=0).reshape(2, -1)
    half = 0.5 * (square + 1.0)
    found = []
    for triangles, places in ((False, square), (True, half[:, half.sum(axis=0) < 1.0 + 1e-9])):
        if len(mesh.triangles if triangles else mesh.quads):
            jacobian = map_cells(mesh, places, triangles)[1]
            det = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
            found.append(det.min(axis=1) / np.maximum(np.abs(det).max(axis=1), 1e-300))
    return np.concatenate(found)


def graded(cells: Cells, share: float, corners: set[int]) -> None:
    """Split every quadrilateral at a corner into three, the smallest next to the corner.

    Parameters
    ----------
    cells : Cells
        Changed in place.
    share : float
        Share of an edge at a corner taken by the smallest cell.
    corners : set of int
        Points; a quadrilateral has one of them at most.
    """
    made: dict[tuple[int, int], int] = {}

    def along(corner: int, other: int) -> int:
        if (corner, other) not in made:
            made[corner, other] = _cut(cells, corner, other, share)
        return made[corner, other]

    quads, owners = [], []
    for quad, face in zip(cells.quads, cells.quad_face, strict=True):
        touched = [k for k in range(4) if quad[k] in corners]
        if not touched:
            quads.append(quad)
            owners.append(face)
            continue
        a, b, c, d = (quad[(touched[0] + k) % 4] for k in range(4))
        one, two = along(a, b), along(a, d)
        p = [cells.points[k] for k in (a, b, c, d)]
        middle = cells.add((1 - share) ** 2 * p[0] + share * (1 - share) * (p[1] + p[3]) + share**2 * p[2])
        quads += [(a, one, middle, two), (one, b, c, middle), (two, middle, c, d)]
        owners += [face] * 3
    cells.quads, cells.quad_face = quads, owners


def corners_apart(cells: Cells, wanted: set[int], triangles: set[int]) -> set[int]:
    """Corners that can be graded: no triangle touches them, and no quadrilateral has two of them.

    Parameters
    ----------
    wanted : set of int
        Points to be graded.
    triangles : set of int
        Points that triangles touch.

    Returns
    -------
    set of int
        Of the points wanted.
    """
    found = wanted - triangles
    for quad in cells.quads:
        touched = found & set(quad)
        if len(touched) > 1:
            found -= touched
    return found


def path_between(cells: Cells, a: int, b: int) -> tuple[Path, bool]:
    """Path along the edge between two points.

    Parameters
    ----------
    a, b : int
        Numbers of the points.

    Returns
    -------
    path : callable
        From parameters (...) in 0 to 1 to points (..., 2), m.
    forward : bool
        Whether it runs from `a` to `b`.
    """
    if (a, b) in cells.paths:
        return cells.paths[a, b], True
    if (b, a) in cells.paths:
        return cells.paths[b, a], False
    start, end = cells.points[a], cells.points[b]
    return (lambda t: np.asarray(start + np.asarray(t, float)[..., None] * (end - start))), True


def part_of(path: Path, first: float, last: float) -> Callable[[Real], Real]:
    """Return the path between two of its parameters.

    Parameters
    ----------
    path : callable
        From parameters (...) in 0 to 1 to points (..., 2), m.
    first, last : float
        Parameters between which it is taken; it is run backwards where `first` is the larger.

    Returns
    -------
    callable
        Of the same kind, again over 0 to 1.
    """
    return lambda t: path(first + np.asarray(t, float) * (last - first))


def _cut(cells: Cells, corner: int, other: int, share: float) -> int:
    """Cut the edge between a corner and another point; return the new point."""
    path, forward = path_between(cells, corner, other)
    new = cells.add(path(np.array(share if forward else 1.0 - share)))
    if (corner, other) in cells.paths or (other, corner) in cells.paths:
        for a, b, first, last in ((corner, new, 0.0, share), (new, other, share, 1.0)):
            ends = (first, last) if forward else (1.0 - first, 1.0 - last)
            cells.paths[a, b] = part_of(path, *ends)
    for pair in ((corner, other), (other, corner)):
        if pair in cells.on_edge:
            edge, first, last = cells.on_edge.pop(pair)
            here, there = (first, last) if pair[0] == corner else (last, first)
            place = here + share * (there - here)
            cells.on_edge[corner, new] = (edge, here, place)
            cells.on_edge[new, other] = (edge, place, there)
    return new
