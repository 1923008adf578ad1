"""Hierarchical shape functions: of one variable, of the reference quadrilateral and of the reference triangle.

Functions are in this order: one of each corner, those of each edge by degree, those of the interior by degree.
Along an edge both cells have the same trace, the function `lobatto` of the edge's coordinate (Szabo and Babuska,
Finite Element Analysis, 1991, sections 6.2 and 6.3).

Those of one variable on [-1, 1] are integrated Legendre polynomials.

Mapping of reference cells to the plate: points, derivatives, and the inverse.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss, legval
from numpy.typing import ArrayLike

from analysis.arrays import Real, Whole
from analysis.geometry.relations import TOUCH
from simulation.meshing.plate_mesh import CURVE_DEGREE, PlateMesh

QUAD_EDGES = ((0, 1), (1, 2), (3, 2), (0, 3))
"""Edges of a quadrilateral in the direction of the reference cell, by their corners."""
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))
"""The same of a triangle."""
TABULATED = 19
"""Largest order of the rules for triangles of few points; above it Gauss' and Jacobi's rules are multiplied."""


@dataclass(frozen=True)
class ShapeTable:
    """Functions of a reference cell at points.

    Attributes
    ----------
    value : (N, Q) ndarray
    slope : (2, N, Q) ndarray
        Derivatives by the two coordinates.
    """

    value: Real
    slope: Real


def quad_functions(degree: int, places: Real) -> ShapeTable:
    """Functions of the quadrilateral [-1, 1]**2 at places (2, Q), (degree + 1)**2 of them."""
    (x, dx), (y, dy) = (_ends_and_inside(degree, s) for s in places)
    pairs = [(0, 0), (1, 0), (1, 1), (0, 1)]  # corners
    inside = range(2, degree + 1)
    pairs += (
        [(k, 0) for k in inside] + [(1, k) for k in inside] + [(k, 1) for k in inside] + [(0, k) for k in inside]
    )
    pairs += [(i, j) for i in inside for j in inside]
    i, j = np.array(pairs).T
    return ShapeTable(x[i] * y[j], np.stack([dx[i] * y[j], x[i] * dy[j]]))


@cache
def _polynomials(degree: int) -> tuple[Polynomial, ...]:
    """l_2 .. l_degree."""
    found = []
    for k in range(2, degree + 1):
        legendre = Legendre.basis(k) - Legendre.basis(k - 2)
        found.append(legendre.convert(kind=Polynomial) / np.sqrt(2.0 * (2 * k - 1)))
    return tuple(found)


@cache
def _kernels(degree: int) -> tuple[Polynomial, ...]:
    """l_k over 1 - s**2."""
    return tuple(polynomial // Polynomial([1.0, 0.0, -1.0]) for polynomial in _polynomials(degree))


def lobatto(degree: int, s: ArrayLike) -> tuple[Real, Real]:
    """l_2 .. l_degree and their derivatives at s (...), (degree - 1, ...) each."""
    places = np.asarray(s, float)
    return _tabulated(_polynomials(degree), places)


def kernels(degree: int, s: ArrayLike) -> tuple[Real, Real]:
    """Kernels of l_2 .. l_degree and their derivatives at s (...), (degree - 1, ...) each."""
    places = np.asarray(s, float)
    return _tabulated(_kernels(degree), places)


def _tabulated(rows: tuple[Polynomial, ...], places: Real) -> tuple[Real, Real]:
    shape = (len(rows), *places.shape)
    value, slope = np.zeros(shape, np.float64), np.zeros(shape, np.float64)
    for k, polynomial in enumerate(rows):
        value[k], slope[k] = polynomial(places), polynomial.deriv()(places)
    return value, slope


def bow_coefficients(path: Callable[[Real], Real], degree: int) -> Real:
    """Coefficients (degree - 1, 2) of l_2 .. l_degree for the difference of a path over [0, 1] from its chord.

    The difference is projected by least squares with weight 1/(1 - s**2), for which the l_k are orthogonal; both
    ends are exact.
    """
    t, projection = _projection(degree)
    ends = path(np.array([0.0, 1.0]))
    bow = path(t) - (ends[0] + t[:, None] * (ends[1] - ends[0]))
    found = projection @ bow
    return np.asarray(np.where(np.abs(found) < 1e-14 * max(np.abs(ends).max(), 1e-30), 0.0, found))


@cache
def _projection(degree: int) -> tuple[Real, Real]:
    """Parameters (Q,) in [0, 1] at which a bow is taken, and the matrix (degree - 1, Q) that projects it."""
    nodes, weights = leggauss(degree + 6)
    root = np.sqrt(weights / (1.0 - nodes**2))
    matrix = lobatto(degree, nodes)[0]
    return 0.5 * (nodes + 1.0), np.asarray(np.linalg.pinv((root * matrix).T) * root, float)


def triangle_functions(degree: int, places: Real) -> ShapeTable:
    """Functions of the triangle (0, 0), (1, 0), (0, 1) at places (2, Q), (degree + 1)(degree + 2)/2 of them."""
    share = np.array([1.0 - places[0] - places[1], places[0], places[1]])
    slopes = np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    one = np.ones(places.shape[1])
    value = list(share)
    slope = [np.outer(row, one) for row in slopes]
    for a, b in TRIANGLE_EDGES:
        bubble = 4.0 * share[a] * share[b]
        by = 4.0 * (np.outer(slopes[a], share[b]) + np.outer(slopes[b], share[a]))
        rows, rates = kernels(degree, share[b] - share[a])
        for row, rate in zip(rows, rates, strict=True):
            value.append(bubble * row)
            slope.append(by * row + np.outer(slopes[b] - slopes[a], bubble * rate))
    bubble = share.prod(axis=0)
    by = np.sum([np.outer(slopes[k], share[k - 1] * share[k - 2]) for k in range(3)], axis=0)
    s, t = share[1] - share[0], 2.0 * share[2] - 1.0
    for total in range(degree - 2):
        for i in range(total + 1):
            p, dp = _legendre(i, s)
            q, dq = _legendre(total - i, t)
            scale = 27.0 * np.sqrt((2 * i + 1.0) * (2 * (total - i) + 1.0)) / (total + 3.0)
            value.append(scale * bubble * p * q)
            rate = np.outer(slopes[1] - slopes[0], dp * q) + np.outer(2.0 * slopes[2], p * dq)
            slope.append(scale * (by * p * q + bubble * rate))
    return ShapeTable(np.array(value), np.stack(slope, axis=1))


def _ends_and_inside(degree: int, s: Real) -> tuple[Real, Real]:
    """Return (1 - s)/2, (1 + s)/2, l_2 .. l_degree and their derivatives, (degree + 1, Q) each."""
    value, slope = lobatto(degree, s)
    half = np.full_like(s, 0.5)
    return np.vstack([0.5 * (1 - s), 0.5 * (1 + s), value]), np.vstack([-half, half, slope])


def _legendre(k: int, s: Real) -> tuple[Real, Real]:
    series = np.zeros(k + 1)
    series[k] = 1.0
    return np.asarray(legval(s, series)), np.asarray(np.polynomial.legendre.Legendre(series).deriv()(s))


@cache
def quad_rule(order: int) -> tuple[Real, Real]:
    """Gauss points (2, Q) and weights (Q,) on [-1, 1]**2, exact for polynomials of `order` in each coordinate."""
    nodes, weights = leggauss(order // 2 + 1)
    x, y = np.meshgrid(nodes, nodes, indexing="ij")
    return np.array([x.ravel(), y.ravel()]), np.outer(weights, weights).ravel()


@cache
def triangle_rule(order: int) -> tuple[Real, Real]:
    """Points (2, Q) and weights (Q,) on the unit triangle, exact for polynomials up to `order`."""
    if order <= TABULATED:
        from skfem.quadrature import get_quadrature
        from skfem.refdom import RefTri

        places, weights = get_quadrature(RefTri, order)
        return np.asarray(places), np.asarray(weights)
    from scipy.special import roots_jacobi

    a, weights_a = leggauss(order // 2 + 1)
    b, weights_b = roots_jacobi(order // 2 + 1, 1.0, 0.0)
    y = 0.5 * (1.0 + b)
    x = 0.5 * np.outer(1.0 - y, 1.0 + a)
    return np.stack([x.ravel(), np.repeat(y, len(a))]), np.outer(weights_b, weights_a).ravel() / 8.0


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
