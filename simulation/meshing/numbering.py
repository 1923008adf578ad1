"""Assembly of strips and triangles to a mesh: numbers of points, cells and edges, and curved edges."""

from collections.abc import Mapping, Sequence

import numpy as np

from analysis.arrays import Whole
from simulation.meshing.arrangement import Arrangement, Face
from simulation.meshing.cells import Cells
from simulation.meshing.grading import part_of
from simulation.meshing.plate_mesh import CURVE_DEGREE, BorderEdges, PlateMesh, edges_of
from simulation.shell.lobatto import bow_coefficients


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
