"""Hierarchical shape functions: of one variable, of the reference quadrilateral and of the reference triangle.

Functions are in this order: one of each corner, those of each edge by degree, those of the interior by degree.
Along an edge both cells have the same trace, the function `lobatto` of the edge's coordinate (Szabo and Babuska,
Finite Element Analysis, 1991, sections 6.2 and 6.3).

Those of one variable on [-1, 1] are integrated Legendre polynomials.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss, legval
from numpy.typing import ArrayLike

from analysis.arrays import Real

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
