"""Hierarchical functions of one variable on [-1, 1]: integrated Legendre polynomials.

l_k vanishes at both ends and is of degree k >= 2; derivatives of two of them are orthogonal (Szabo and Babuska,
Finite Element Analysis, 1991, eq. 3.13). l_k(s) = (1 - s**2) kernel_k(s); kernels make edge functions of
triangles.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss
from numpy.typing import ArrayLike

from analysis.arrays import Real


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
