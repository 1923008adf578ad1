"""Meshes of other programs, with patches, zones and edges as physical groups."""

from collections.abc import Sequence

import numpy as np

from analysis.arrays import Real, Whole
from analysis.declaration.plate import ForeignMesh
from analysis.geometry.loop import GeometryError, at
from simulation.meshing.mesher import LEAST_RATIO, Border, jacobian_ratio
from simulation.meshing.plate_mesh import CURVE_DEGREE, BorderEdges, PlateMesh, edges_of
from simulation.shell.shape_functions import lobatto

PLATE = "plate"
"""Group of the cells in no patch and no zone."""


def foreign_mesh(
    declared: ForeignMesh,
    borders: Sequence[Border],
    cuts: Sequence[tuple[float, float]] = (),
    *,
    tolerance: float = 1e-4,
) -> PlateMesh:
    """Mesh of a plate from triangles and quadrilaterals, straight or quadratic.

    Every border of a patch or zone needs a physical surface of its name. A physical curve with a border's name is
    compared with that border. A group ``plate`` may hold the rest.

    Parameters
    ----------
    borders : sequence of Border
        Borders of the declared plate.
    cuts : sequence of (float, float)
        Ends of supported edges, m: corners of cells must be there.
    tolerance : float
        Largest distance of an edge from its border, m.

    Raises
    ------
    GeometryError
        For unknown or missing groups, cells with undefined points, inverted cells, and a mesh that does not fit
        the borders.
    """
    _check_numbers(declared)
    _check_groups(declared, borders)
    every = np.array(declared.points)
    quads, triangles = _turned_alike(declared, every)
    used = np.unique(np.concatenate([quads.ravel(), triangles.ravel()]))
    number = np.full(len(every), -1)
    number[used] = np.arange(used.size)
    points, quads, triangles = every[used], number[quads], number[triangles]
    edges = edges_of(quads, triangles)
    bow = np.zeros((len(edges), CURVE_DEGREE - 1, 2))
    midsides = {frozenset(ends): middle for *ends, middle in declared.midsides}
    for k, (a, b) in enumerate(edges):
        middle = midsides.get(frozenset((int(used[a]), int(used[b]))))
        if middle is not None:
            away = every[middle] - 0.5 * (points[a] + points[b])
            if np.hypot(*away) > 1e-9 * np.hypot(*(points[a] - points[b])):
                bow[k, 0] = away / lobatto(2, 0.0)[0][0]
    inside = {border.name: np.full(len(quads) + len(triangles), border.kind == "outline") for border in borders}
    for name, cells in declared.surface.items():
        if name != PLATE:
            inside[name][list(cells)] = True
    mesh = PlateMesh(points, quads, triangles, edges, bow, inside, {})
    ratio = jacobian_ratio(mesh)
    if ratio.min() < LEAST_RATIO:
        place = mesh.centers[ratio.argmin()]
        raise GeometryError(f"the mesh's cell at {at(place)} is turned over, or nearly so", place)
    found = _borders(mesh, borders, tolerance)
    named = {key: {(int(number[a]), int(number[b])) for a, b in pairs} for key, pairs in declared.curve.items()}
    _check_lines(mesh, found, named)
    for place in cuts:
        if np.hypot(*(points - place).T).min() > tolerance:
            raise GeometryError(f"the mesh has no point at {at(place)}, where a support begins or ends", place)
    return PlateMesh(points, quads, triangles, edges, bow, inside, found)


def _check_numbers(declared: ForeignMesh) -> None:
    """GeometryError for undefined points and missing cells."""
    points, cells = len(declared.points), len(declared.quads) + len(declared.triangles)
    edges = [*declared.midsides, *(pair for pairs in declared.curve.values() for pair in pairs)]
    for what, count, rows in (
        ("point", points, (*declared.quads, *declared.triangles, *edges)),
        ("cell", cells, declared.surface.values()),
    ):
        largest = max((max(row) for row in rows if row), default=-1)
        if largest >= count:
            raise GeometryError(f"the mesh names {what} {largest}; allowed 0 to {count - 1}")
    if not cells:
        raise GeometryError("the mesh has neither triangles nor quadrilaterals")


def _check_groups(declared: ForeignMesh, borders: Sequence[Border]) -> None:
    inner = [border.name for border in borders if border.kind == "inner"]
    for groups, known, what in (
        (declared.surface, [PLATE, *inner], "surface"),
        (declared.curve, [border.name for border in borders], "curve"),
    ):
        unknown = sorted(set(groups) - set(known))
        if unknown:
            raise GeometryError(f"physical {what} {unknown[0]!r} is unknown; this plate has {', '.join(known)}")
    missing = [name for name in inner if name not in declared.surface]
    if missing:
        has = ", ".join(sorted(declared.surface)) or "none"
        raise GeometryError(f"physical surface {missing[0]!r} is missing; the mesh has {has}")


def _turned_alike(declared: ForeignMesh, points: Real) -> tuple[Whole, Whole]:
    """Quadrilaterals and triangles, counter-clockwise.

    Surfaces may have their normals upwards or downwards. A cell inverted within its surface lies over its
    neighbours: with all cells counter-clockwise, both then run along an edge in the same direction.

    Raises
    ------
    GeometryError
        For inverted cells, and cells without area.
    """
    cells = [[*corners] for corners in (*declared.quads, *declared.triangles)]
    area = np.array([_area(points[corners]) for corners in cells])
    turned = [corners if own >= 0.0 else corners[::-1] for corners, own in zip(cells, area, strict=True)]
    along: dict[tuple[int, int], int] = {}
    wrong = {*np.flatnonzero(area == 0.0).tolist()}
    for k, corners in enumerate(turned):
        for ends in zip(corners, [*corners[1:], corners[0]], strict=True):
            other = along.setdefault(ends, k)
            wrong |= {other, k} if other != k else set()
    if wrong:
        usual = np.sign(np.sign(area[[*wrong]]).sum())
        cell = min(wrong, key=lambda k: (np.sign(area[k]) == usual, k))
        place = points[cells[cell]].mean(axis=0)
        raise GeometryError(f"a cell of the mesh at {at(place)} is turned over, or lies over another one", place)
    count = len(declared.quads)
    return np.reshape(turned[:count], (-1, 4)).astype(int), np.reshape(turned[count:], (-1, 3)).astype(int)


def _area(corners: Real) -> float:
    """Area of a polygon (N, 2), positive if its corners are counter-clockwise."""
    x, y = corners.T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _borders(mesh: PlateMesh, borders: Sequence[Border], tolerance: float) -> dict[str, BorderEdges]:
    """Edges along every border: boundary edges for outline and holes, edges between its cells and others else."""
    sharing = _sharing(mesh, borders)
    if sharing[-1].max() > 2:
        place = mesh.points[mesh.edges[sharing[-1].argmax()]].mean(axis=0)
        raise GeometryError(f"more than two cells of the mesh share the edge at {at(place)}", place)
    outer = [border for border in borders if border.kind != "inner"]
    found = _outer_borders(mesh, np.flatnonzero(sharing[-1] == 1), outer, tolerance)
    for border, cells in zip(borders, sharing, strict=False):
        if border.kind == "inner":
            found[border.name] = _inner_border(mesh, np.flatnonzero(cells == 1), border, tolerance)
    for border in borders:
        covered = float(np.abs(np.diff(_places(mesh, found[border.name].edge, border), axis=1)).sum())
        if abs(covered - len(border.loop.curves)) > 0.01:
            raise GeometryError(
                f"the mesh follows {covered / len(border.loop.curves):.0%} of {border.name!r}; allowed all of it",
                border.loop.curves[0].at(0.0),
            )
    return found


def _sharing(mesh: PlateMesh, borders: Sequence[Border]) -> Whole:
    """Count the cells at every edge, (borders + 1, edges): those inside each border, then all."""
    cells = [*zip(mesh.quad_edges, range(len(mesh.quads)), strict=True)]
    cells += [*zip(mesh.triangle_edges, range(len(mesh.quads), mesh.cells), strict=True)]
    sharing = np.zeros((len(borders) + 1, len(mesh.edges)), int)
    for edges, cell in cells:
        sharing[-1, edges] += 1
        for k, border in enumerate(borders):
            sharing[k, edges] += int(mesh.inside[border.name][cell])
    return sharing


def _outer_borders(
    mesh: PlateMesh, rim: Whole, outer: Sequence[Border], tolerance: float
) -> dict[str, BorderEdges]:
    """Divide the boundary edges `rim` among outline and holes; GeometryError for one that is near none of them."""
    middle = _along(mesh, rim, 0.0)
    away = np.array([border.loop.nearest(middle).distance for border in outer])
    if away.min(axis=0).max() > tolerance:
        place = middle[away.min(axis=0).argmax()]
        raise GeometryError(
            f"the mesh ends at {at(place)}, {1e3 * away.min(axis=0).max():.3g} mm away from the edge of "
            f"the plate; allowed {1e3 * tolerance:g} mm",
            place,
        )
    return {border.name: _spans(mesh, rim[away.argmin(axis=0) == k], border) for k, border in enumerate(outer)}


def _inner_border(mesh: PlateMesh, own: Whole, border: Border, tolerance: float) -> BorderEdges:
    """Edges around the cells of a patch or zone; GeometryError where one is away from the declared border."""
    far = border.loop.nearest(_along(mesh, own, 0.0)).distance
    if far.max(initial=0.0) > tolerance:
        place = _along(mesh, own, 0.0)[far.argmax()]
        raise GeometryError(
            f"physical surface {border.name!r} ends at {at(place)}, {1e3 * far.max():.3g} mm away "
            f"from its declared border; allowed {1e3 * tolerance:g} mm",
            place,
        )
    return _spans(mesh, own, border)


def _along(mesh: PlateMesh, edges: Whole, s: float) -> Real:
    """Points (K, 2) on edges at s in [-1, 1]."""
    a, b = np.moveaxis(mesh.points[mesh.edges[edges]], 1, 0)
    bent = np.einsum("c,kcd->kd", lobatto(CURVE_DEGREE, s)[0], mesh.bow[edges])
    return np.asarray(0.5 * (1.0 - s) * a + 0.5 * (1.0 + s) * b + bent)


def _spans(mesh: PlateMesh, edges: Whole, border: Border) -> BorderEdges:
    """Part of its border along every edge; of an edge along several curves, the part on that of its middle."""
    middle = border.loop.nearest(_along(mesh, edges, 0.0)).curve.astype(int)
    return BorderEdges(edges, middle, (_places(mesh, edges, border) - middle[:, None]).clip(0.0, 1.0))


def _places(mesh: PlateMesh, edges: Whole, border: Border) -> Real:
    """Where edges begin and end, (K, 2), in curves along the border's loop: 2.5 is half-way along its third curve.

    Points between two curves belong to both; so what counts is the way from the middle of the edge.
    """
    count = len(border.loop.curves)
    middle, *ends = (
        found.curve + found.t for found in (border.loop.nearest(_along(mesh, edges, s)) for s in (0.0, -1.0, 1.0))
    )
    half = 0.5 * count
    return np.stack([middle + (end - middle + half) % count - half for end in ends], axis=1)


def _check_lines(mesh: PlateMesh, found: dict[str, BorderEdges], lines: dict[str, set[tuple[int, int]]]) -> None:
    """Compare physical curves with the borders of the same name."""
    for group, pairs in lines.items():
        own = {(int(a), int(b)) for a, b in mesh.edges[found[group].edge]}
        wrong = [pair for pair in pairs if (min(pair), max(pair)) not in own]
        if wrong:
            place = mesh.points[list(wrong[0])].mean(axis=0)
            raise GeometryError(f"physical curve {group!r} leaves its border at {at(place)}", place)
