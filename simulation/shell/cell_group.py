"""All quadrilaterals, or all triangles, of a space: functions and points of quadrature on every cell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from analysis.arrays import Real, Whole
from simulation.meshing.plate_mesh import PlateMesh
from simulation.shell.cells import (
    QUAD_EDGES,
    TRIANGLE_EDGES,
    ShapeTable,
    quad_functions,
    quad_rule,
    triangle_functions,
    triangle_rule,
)
from simulation.shell.mapping import map_cells

CURVED_ORDER = 4
"""Increase of the order of quadrature for the Jacobian of curved cells."""


@dataclass(frozen=True)
class CellGroup:
    """All quadrilaterals, or all triangles, of a space.

    Attributes
    ----------
    functions : (C, N) ndarray of int
        Functions of the space on every cell.
    sign : (C, N) ndarray
        -1 where a function of odd degree has the opposite direction on its edge to that of the reference cell.
    table : ShapeTable
        Of the reference cell, at the Q points of quadrature.
    places : (C, Q, 2) ndarray
        Points of quadrature, m.
    dx : (C, Q) ndarray
        Their areas (quadrature weight times Jacobian), m2.
    inverse : (C, Q, 2, 2) ndarray
        Derivatives of the reference coordinates (row) by x and y, 1/m.
    """

    functions: Whole
    sign: Real
    table: ShapeTable
    places: Real
    dx: Real
    inverse: Real

    @cached_property
    def values(self) -> Real:
        """Functions at the points, (C, N, Q)."""
        return np.asarray(self.sign[:, :, None] * self.table.value)

    @cached_property
    def slopes(self) -> Real:
        """Derivatives by x and y, (2, C, N, Q), 1/m."""
        found = np.einsum("anq,cqad->dcnq", self.table.slope, self.inverse, optimize=True)
        return np.asarray(found * self.sign[:, :, None])

    def factor(self, letter: str, chosen: Whole | slice) -> Real:
        """Functions (``0``) or their derivatives (``x``, ``y``) on some cells, (C', N, Q)."""
        return self.values[chosen] if letter == "0" else self.slopes["xy".index(letter), chosen]


def cell_group(mesh: PlateMesh, degree: int, *, triangles: bool) -> CellGroup:
    """Return the functions on all quadrilaterals, or all triangles, at their points of quadrature.

    Parameters
    ----------
    degree : int
        Of the functions.

    Raises
    ------
    ValueError
        For an inverted cell, with the place.
    """
    order = 2 * degree + (CURVED_ORDER if mesh.bow.any() else 0)
    places, weights = (triangle_rule if triangles else quad_rule)(order)
    cells = mesh.triangles if triangles else mesh.quads
    edges = mesh.triangle_edges if triangles else mesh.quad_edges
    pairs = TRIANGLE_EDGES if triangles else QUAD_EDGES
    table = (triangle_functions if triangles else quad_functions)(degree, places)
    number = np.arange(len(cells))
    each = (degree - 1) * (degree - 2) // 2 if triangles else (degree - 1) ** 2
    first = len(mesh.points) + len(mesh.edges) * (degree - 1)
    if triangles:
        first += len(mesh.quads) * (degree - 1) ** 2
    on_edges = len(mesh.points) + edges[:, :, None] * (degree - 1) + np.arange(degree - 1)
    functions = np.hstack(
        [
            cells,
            on_edges.reshape(len(cells), len(pairs) * (degree - 1)),
            first + number[:, None] * each + np.arange(each),
        ]
    )
    sign = np.ones(functions.shape)
    odd = np.arange(2, degree + 1) % 2 == 1
    for k, (a, b) in enumerate(pairs):
        start = len(pairs) + k * (degree - 1)
        sign[:, start : start + degree - 1] = np.where((cells[:, a] > cells[:, b])[:, None] & odd, -1.0, 1.0)
    count, q = len(cells), places.shape[1]
    x = np.zeros((count, q, 2))
    jacobian = np.zeros((count, q, 2, 2))
    if count:
        x, jacobian = map_cells(mesh, places, triangles)
    det = np.linalg.det(jacobian)
    turned = (det <= 0.0).any(axis=1)
    if turned.any():
        place = mesh.points[cells[turned][0]].mean(axis=0)
        raise ValueError(f"a cell of the mesh near ({place[0]:.5g}, {place[1]:.5g}) m is turned over")
    inverse = np.asarray(np.linalg.inv(jacobian) if count else jacobian, float)
    return CellGroup(functions, sign, table, x, np.asarray(det * weights, float), inverse)
