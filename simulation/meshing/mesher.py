"""Mesh of a plate of any outline, with holes, zones of another thickness and patches.

Strips of quadrilaterals run along every border; triangles fill the rest. A side of what is to be filled that no
good triangle takes is halved, and all is laid again.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.geometry.loop import Loop
from simulation.meshing.arrangement import Arrangement, Face
from simulation.meshing.fill import fill
from simulation.meshing.plate_mesh import CURVE_DEGREE, BorderEdges, PlateMesh, edges_of
from simulation.meshing.recipe import MeshRecipe
from simulation.meshing.strips import Cells, Sizes, strips
from simulation.shell.lobatto import bow_coefficients

Real = NDArray[np.float64]

ROUNDS = 12


@dataclass(frozen=True)
class Border:
    """A closed line that the mesh follows.

    Attributes
    ----------
    name : str
        By which its cells and edges are found in the mesh.
    loop : Loop
    kind : str
        ``outline``, ``hole`` or ``inner``: patches and zones.
    """

    name: str
    loop: Loop
    kind: str = "inner"


def mesh_plate(
    borders: Sequence[Border],
    thickness: float,
    recipe: MeshRecipe | None = None,
    cuts: Sequence[tuple[float, float]] = (),
) -> PlateMesh:
    """Mesh what lies inside the outline and outside the holes.

    Parameters
    ----------
    borders : sequence of Border
        One of them the outline.
    thickness : float
        Of the plate, m.
    recipe : MeshRecipe, optional
    cuts : sequence of points
        On borders, where an edge shall end, m: ends of supports.

    Raises
    ------
    ValueError
        Where no good mesh was found, with the place.
    """
    recipe = recipe or MeshRecipe()
    plan = Arrangement.of([border.loop for border in borders], cuts)
    outline = {k for k, border in enumerate(borders) if border.kind == "outline"}
    holes = {k for k, border in enumerate(borders) if border.kind == "hole"}
    faces = {k: face for k, face in enumerate(plan.faces) if outline <= face.inside and not holes & face.inside}
    sizes = _sizes(plan, faces, borders, thickness, recipe)
    splits: dict[int, frozenset[float]] = {}
    for _ in range(ROUNDS):
        cells = strips(plan, faces, sizes, splits)
        triangles, triangle_face, missing, thin = _filled(cells, faces, recipe, recipe.bulk(thickness))
        halved = [_source(cells, pair) for pair in missing]
        if None in halved:
            x, y = np.mean([cells.points[k] for k in missing[halved.index(None)]], axis=0)
            raise ValueError(
                f"a corner near ({x:.5g}, {y:.5g}) m leaves no room for cells beside it; open it or move it"
            )
        wrong = [source for source in halved or map(partial(_source, cells), thin) if source is not None]
        if not wrong:
            return _finished(plan, faces, borders, cells, triangles, triangle_face, recipe.grading)
        for edge, place in wrong:
            splits[edge] = splits.get(edge, frozenset()) | {place}
    x, y = plan.edges[wrong[0][0]].curve.at(wrong[0][1])
    raise ValueError(
        f"no good mesh near ({x:.5g}, {y:.5g}) m: borders of plate, patches or zones come too close to each other "
        "there, or meet at too sharp an angle; move one of them by a millimetre"
    )


def _sizes(
    plan: Arrangement,
    faces: Mapping[int, Face],
    borders: Sequence[Border],
    thickness: float,
    recipe: MeshRecipe,
) -> dict[int, Sizes]:
    """Sizes of every edge that bounds a meshed face."""
    seen = {half for face in faces.values() for cycle in face.cycles for half in cycle}
    found = {}
    for k, edge in enumerate(plan.edges):
        left, right = (any(h.edge == k and h.backward is back for h in seen) for back in (False, True))
        if not (left or right):
            continue
        inner = any(borders[origin.border].kind == "inner" for origin in edge.origins)
        width = thickness * (recipe.strip if inner else recipe.edge_strip)
        pieces = recipe.pieces if inner and len(edge.origins) == 1 else 1
        found[k] = Sizes(
            width if left else 0.0, width if right else 0.0, recipe.bulk(thickness), pieces
        )
    return found


def _filled(
    cells: Cells, faces: Mapping[int, Face], recipe: MeshRecipe, spacing: float
) -> tuple[list[Real], list[int], list[tuple[int, int]], list[tuple[int, int]]]:
    """Triangles of every face (points appended to `cells`), their faces, and sides that are missing or too long."""
    triangles: list[Real] = []
    owners: list[int] = []
    missing: list[tuple[int, int]] = []
    thin: list[tuple[int, int]] = []
    for face, rings in zip(faces, cells.rings, strict=True):
        known = [number for ring in rings for number in ring]
        local = {number: k for k, number in enumerate(known)}
        found = fill(
            np.array([cells.points[number] for number in known]),
            [[local[number] for number in ring] for ring in rings],
            spacing,
            recipe.growth,
        )
        number = np.array([*known, *(cells.add(point) for point in found.points[len(known) :])])
        triangles += list(number[found.triangles])
        owners += [face] * len(found.triangles)
        missing += [(int(number[a]), int(number[b])) for a, b in found.missing]
        thin += [(int(number[a]), int(number[b])) for a, b in found.thin]
    return triangles, owners, missing, thin


def _source(cells: Cells, pair: tuple[int, int]) -> tuple[int, float] | None:
    """Edge, and the middle of its piece, whose strip ends in the side `pair`; None for a side of a corner."""
    for quad in cells.quads:
        if {quad[2], quad[3]} == set(pair):
            for outer in ((quad[0], quad[1]), (quad[1], quad[0])):
                if outer in cells.on_edge:
                    edge, first, last = cells.on_edge[outer]
                    return edge, round(0.5 * (first + last), 12)
    return None


def _graded(cells: Cells, share: float) -> None:
    """Split every quadrilateral at a corner in three, the smallest next to the corner."""
    made: dict[tuple[int, int], int] = {}

    def along(corner: int, other: int) -> int:
        if (corner, other) not in made:
            path, forward = _path(cells, corner, other)
            place = share if forward else 1.0 - share
            new = cells.add(path(np.array(place)))
            made[corner, other] = new
            for a, b, first, last in ((corner, new, 0.0, share), (new, other, share, 1.0)):
                ends = (first, last) if forward else (1.0 - first, 1.0 - last)
                cells.paths[a, b] = _part(path, *ends)
            for pair in ((corner, other), (other, corner)):
                if pair in cells.on_edge:
                    edge, first, last = cells.on_edge.pop(pair)
                    place = first + (share if pair[0] == corner else 1.0 - share) * (last - first)
                    here, there = (first, last) if pair[0] == corner else (last, first)
                    cells.on_edge[corner, new] = (edge, here, place)
                    cells.on_edge[new, other] = (edge, place, there)
        return made[corner, other]

    quads, owners = [], []
    for quad, face in zip(cells.quads, cells.quad_face, strict=True):
        touched = [k for k in range(4) if quad[k] in cells.corners]
        if not touched:
            quads.append(quad)
            owners.append(face)
            continue
        if len(touched) > 1:
            x, y = np.mean([cells.points[k] for k in quad], axis=0)
            raise ValueError(f"two corners share a cell near ({x:.5g}, {y:.5g}) m: they are too close to each other")
        a, b, c, d = (quad[(touched[0] + k) % 4] for k in range(4))
        one, two = along(a, b), along(a, d)
        p = [cells.points[k] for k in (a, b, c, d)]
        s = share
        mean = (1 - s) ** 2 * p[0] + s * (1 - s) * (p[1] + p[3]) + s * s * p[2]
        middle = cells.add(mean)
        quads += [(a, one, middle, two), (one, b, c, middle), (two, middle, c, d)]
        owners += [face] * 3
    cells.quads, cells.quad_face = quads, owners


def _path(cells: Cells, a: int, b: int) -> tuple[Callable[[Real], Real], bool]:
    """Path along the edge between two points, and whether it runs from the first to the second."""
    if (a, b) in cells.paths:
        return cells.paths[a, b], True
    if (b, a) in cells.paths:
        return cells.paths[b, a], False
    start, end = cells.points[a], cells.points[b]
    return (lambda t: start + np.asarray(t, float)[..., None] * (end - start)), True


def _part(path: Callable[[Real], Real], first: float, last: float) -> Callable[[Real], Real]:
    return lambda t: path(first + np.asarray(t, float) * (last - first))


def _finished(
    plan: Arrangement,
    faces: Mapping[int, Face],
    borders: Sequence[Border],
    cells: Cells,
    triangles: list[Real],
    triangle_face: list[int],
    grading: float,
) -> PlateMesh:
    """Number points, cells and edges, and follow the curves."""
    if grading:
        _graded(cells, grading)
    quads, fans = np.array(cells.quads, int).reshape(-1, 4), np.array(triangles, int).reshape(-1, 3)
    used, flat = np.unique(np.concatenate([quads.ravel(), fans.ravel()]), return_inverse=True)
    quads, fans = flat[: quads.size].reshape(-1, 4), flat[quads.size :].reshape(-1, 3)
    points, number = np.array(cells.points)[used], {int(old): new for new, old in enumerate(used)}
    edges = edges_of(quads, fans)
    place = {(int(a), int(b)): k for k, (a, b) in enumerate(edges)}
    bow = np.zeros((len(edges), CURVE_DEGREE - 1, 2))
    for (a, b), path in cells.paths.items():
        pair = (number.get(a), number.get(b))
        ends = tuple(sorted(pair)) if None not in pair else ()
        if ends in place:
            forward = pair[0] == ends[0]
            bow[place[ends]] = bow_coefficients(path if forward else _part(path, 1.0, 0.0), CURVE_DEGREE)
    owner = np.array([*cells.quad_face, *triangle_face], int)
    inside = {
        border.name: np.isin(owner, [f for f, face in faces.items() if k in face.inside])
        for k, border in enumerate(borders)
    }
    return PlateMesh(points, quads, fans, edges, bow, inside, _border_edges(plan, borders, cells, number, place))


def _border_edges(
    plan: Arrangement,
    borders: Sequence[Border],
    cells: Cells,
    number: Mapping[int, int],
    place: Mapping[tuple[int, int], int],
) -> dict[str, BorderEdges]:
    rows: dict[str, list[tuple[int, int, float, float]]] = {border.name: [] for border in borders}
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
            rows[borders[origin.border].name].append((mesh_edge, origin.curve, *span))
    found = {}
    for name, entries in rows.items():
        table = np.array(entries, float).reshape(-1, 4)
        found[name] = BorderEdges(table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2:])
    return found
