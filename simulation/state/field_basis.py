"""Smooth fields over a plate as Legendre polynomials, from their values at Gauss points."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.polynomial.legendre import leggauss, legval
from numpy.typing import NDArray

from analysis.arrays import Real

POINTS_ALONG_SIDE = 6
"""Number of Gauss points along each side at which fields are sampled."""


def polynomials(degree: int) -> list[tuple[int, int]]:
    """Degrees along xi and zeta of all products up to a total degree; the constant comes first."""
    return [(total - j, j) for total in range(degree + 1) for j in range(total + 1)]


def polynomial(degrees: tuple[int, int], xi: Real, zeta: Real) -> Real:
    """Product of two Legendre polynomials at points.

    Parameters
    ----------
    degrees : (int, int)
        Along xi and zeta.
    xi, zeta : (Q,) ndarray
        -1 to 1.

    Returns
    -------
    (Q,) ndarray
    """
    first, second = (np.eye(d + 1)[d] for d in degrees)
    return np.asarray(legval(xi, first) * legval(zeta, second))


@dataclass(frozen=True)
class FieldBasis:
    """Sampling points of fields, and the projection of sampled values onto polynomials.

    Attributes
    ----------
    xi, zeta : (Q,) ndarray
        Gauss points of the plate, from -1 to 1.
    projection : (terms, Q) ndarray
        Values at the points -> coefficients, least squares over the plate.
    """

    xi: Real
    zeta: Real
    projection: Real

    def coefficients(self, field: NDArray[Any]) -> NDArray[Any]:
        """Coefficients (terms,) of a field (Q,); exactly zero for a uniform field, which saves work later."""
        found = np.asarray(self.projection @ field)
        if (field == field[0]).all():
            found[1:] = 0.0
        return found


@cache
def field_basis(degree: int) -> FieldBasis:
    """Fields up to a total degree."""
    nodes, weights = leggauss(POINTS_ALONG_SIDE)
    xi, zeta = (grid.ravel() for grid in np.meshgrid(nodes, nodes, indexing="ij"))
    weight = np.outer(weights, weights).ravel()
    rows = []
    for degrees in polynomials(degree):
        norm = (2 * degrees[0] + 1) * (2 * degrees[1] + 1) / 4.0
        rows.append(norm * weight * polynomial(degrees, xi, zeta))
    return FieldBasis(xi, zeta, np.array(rows))
