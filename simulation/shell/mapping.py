"""Mapping of reference cells to the plate: points, derivatives, and the inverse."""

import numpy as np

from analysis.arrays import Real, Whole
from analysis.geometry.relations import TOUCH
from simulation.meshing.plate_mesh import CURVE_DEGREE, PlateMesh
from simulation.shell.shape_functions import QUAD_EDGES, TRIANGLE_EDGES, quad_functions, triangle_functions


def geometry_of(mesh: PlateMesh, triangles: bool) -> Real:
    """Coefficients (C, N, 2) of every cell's corners and edges in the functions of `CURVE_DEGREE`."""
    cells = mesh.triangles if triangles else mesh.quads
    edges = mesh.triangle_edges if triangles else mesh.quad_edges
    pairs = TRIANGLE_EDGES if triangles else QUAD_EDGES
    odd = np.arange(2, CURVE_DEGREE + 1) % 2 == 1
    parts = [mesh.points[cells]]
    for k, (a, b) in enumerate(pairs):
        against = (cells[:, a] > cells[:, b])[:, None, None] & odd[:, None]
        parts.append(np.where(against, -1.0, 1.0) * mesh.bow[edges[:, k]])
    return np.concatenate(parts, axis=1)


def map_cells(mesh: PlateMesh, places: Real, triangles: bool) -> tuple[Real, Real]:
    """Map the same reference points to all cells of one shape.

    Parameters
    ----------
    places : (2, Q) ndarray
        Reference coordinates.
    triangles : bool
        Whether the cells are triangles; else quadrilaterals.

    Returns
    -------
    x : (C, Q, 2) ndarray, m
    jacobian : (C, Q, 2, 2) ndarray, m
        Derivatives of x, on the third axis, by the reference coordinates, on the last.
    """
    shape = geometry_of(mesh, triangles)
    count = 3 + 3 * (CURVE_DEGREE - 1) if triangles else 4 * CURVE_DEGREE
    table = (triangle_functions if triangles else quad_functions)(CURVE_DEGREE, places)
    x = np.einsum("cnd,nq->cqd", shape, table.value[:count], optimize=True)
    jacobian = np.einsum("cnd,anq->cqda", shape, table.slope[:, :count], optimize=True)
    return x, jacobian


def map_places(mesh: PlateMesh, number: Whole, places: Real, triangles: bool) -> tuple[Real, Real]:
    """Map one reference point to each of K cells of one shape.

    Parameters
    ----------
    number : (K,) ndarray of int
        Of the cells, among those of their kind.
    places : (2, K) ndarray
        Reference coordinates.
    triangles : bool
        Whether the cells are triangles; else quadrilaterals.

    Returns
    -------
    x : (K, 2) ndarray, m
    jacobian : (K, 2, 2) ndarray, m
        Derivatives of x, on the middle axis, by the reference coordinates, on the last.
    """
    shape = geometry_of(mesh, triangles)[number]
    count = 3 + 3 * (CURVE_DEGREE - 1) if triangles else 4 * CURVE_DEGREE
    table = (triangle_functions if triangles else quad_functions)(CURVE_DEGREE, places)
    x = np.einsum("knd,nk->kd", shape, table.value[:count])
    return x, np.einsum("knd,ank->kda", shape, table.slope[:, :count])


def boxes_of(mesh: PlateMesh, triangles: bool) -> tuple[Real, Real]:
    """Corners (C, 2) of boxes round all cells of one shape, with a margin for points on edges."""
    side = np.linspace(-1.0, 1.0, 9)
    if triangles:
        t = 0.5 * (side + 1.0)
        around = np.hstack([[t, 0 * t], [0 * t, t], [t, 1 - t]])
    else:
        around = np.hstack(
            [[side, 0 * side + end] for end in (-1, 1)] + [[0 * side + end, side] for end in (-1, 1)]
        )
    if not len(mesh.triangles if triangles else mesh.quads):
        return np.zeros((0, 2)), np.zeros((0, 2))
    x = map_cells(mesh, around, triangles)[0]
    low, high = x.min(axis=1), x.max(axis=1)
    margin = 0.02 * (high - low).max(axis=1, keepdims=True)
    return low - margin, high + margin


def inverse_of(mesh: PlateMesh, number: Whole, points: Real, triangles: bool) -> tuple[Real, Real]:
    """Return reference coordinates of points in given cells, and their distance outside the cells.

    Parameters
    ----------
    number : (K,) ndarray of int
        Of a cell for each point, among those of its kind.
    points : (K, 2) ndarray, m
    triangles : bool
        Whether the cells are triangles; else quadrilaterals.

    Returns
    -------
    place : (K, 2) ndarray
        Reference coordinates.
    off : (K,) ndarray
        0 within the cell and where it touches the point; else in reference coordinates, above 1 where no place was
        found.
    """
    place = np.full((len(points), 2), 1.0 / 3.0) if triangles else np.zeros((len(points), 2))
    for _ in range(8):
        x, jacobian = map_places(mesh, number, place.T, triangles)
        (a, b), (c, d) = np.moveaxis(jacobian, 0, -1)
        det = a * d - b * c
        det = np.where(np.abs(det) > 1e-300, det, 1.0)  # far outside a curved cell it may vanish
        miss_x, miss_y = (points - x).T
        step = np.stack([d * miss_x - b * miss_y, a * miss_y - c * miss_x], axis=1) / det[:, None]
        place = np.clip(place + step, -1.3, 1.3)
    x, jacobian = map_places(mesh, number, place.T, triangles)
    away = np.hypot(*(points - x).T) / np.maximum(np.abs(points).max(), 1e-12)
    if triangles:
        off = np.maximum(0.0, np.maximum(-place.min(axis=1), place.sum(axis=1) - 1.0))
        inner = np.maximum(place, 0.0)
        inner /= np.maximum(inner.sum(axis=1, keepdims=True), 1.0)
    else:
        off = np.maximum(0.0, np.abs(place).max(axis=1) - 1.0)
        inner = np.clip(place, -1.0, 1.0)
    outside = np.hypot(*np.einsum("qad,qd->aq", jacobian, place - inner))
    off[outside <= TOUCH] = 0.0  # a cell may be thinner than a thousand times this
    return place, np.asarray(off + np.where(away > 1e-7, 1.0 + away, 0.0))
