"""The scalar space every displacement component is built on, and its elementary integrals."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix

from simulation.mesh import MeshLines, MeshRecipe

REACH = 0.010
"""How far around a block that is moved elements stretch at least, where there is room, m: four times as far as a
sensor can be off its place."""
MOST_STRETCH = 0.75
"""How much of their width elements around such a block may lose, at most."""
Rectangle = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Integrals:
    """Integrals of products of shape functions N and their derivatives over one region, all (n, n).

    The first letter belongs to the row, the second to the column: ``x0`` is that of N_i,x N_j.
    """

    xx: csr_matrix
    yy: csr_matrix
    xy: csr_matrix
    x0: csr_matrix
    y0: csr_matrix
    m: csr_matrix


@dataclass(frozen=True)
class ShapeSpace:
    """Hierarchical quadrilaterals on a tensor mesh of a rectangle.

    Attributes
    ----------
    basis : skfem.CellBasis
        With quadrature that is exact for products of shape functions.
    x, y : MeshLines
    recipe : MeshRecipe
    """

    basis: skfem.CellBasis
    x: MeshLines
    y: MeshLines
    recipe: MeshRecipe

    @classmethod
    def on(cls, x: MeshLines, y: MeshLines, recipe: MeshRecipe) -> "ShapeSpace":
        """Build the space on the tensor mesh of two sets of lines."""
        mesh = skfem.MeshQuad.init_tensor(x.position, y.position)
        basis = skfem.CellBasis(mesh, skfem.ElementQuadP(recipe.degree), intorder=recipe.quadrature_order)
        return cls(basis, x, y, recipe)

    @property
    def size(self) -> int:
        """Number of shape functions, before any thinning."""
        return int(self.basis.N)

    @property
    def centers(self) -> NDArray[np.float64]:
        """Midpoints of the elements, (2, elements), m."""
        mesh = self.basis.mesh
        return np.asarray(mesh.p[:, mesh.t].mean(axis=1))

    def inside(self, region: Rectangle, margin: float = 0.0) -> NDArray[np.bool_]:
        """Which elements lie in a rectangle widened by `margin` m."""
        (x0, x1), (y0, y1) = region
        x, y = self.centers
        return np.asarray((x > x0 - margin) & (x < x1 + margin) & (y > y0 - margin) & (y < y1 + margin))

    def integrals(self, elements: NDArray[np.bool_] | None = None) -> Integrals:
        """Integrate over all or some elements."""

        def product(row: str, column: str) -> csr_matrix:
            return self.product(row, column, elements)

        return Integrals(
            xx=product("x", "x"),
            yy=product("y", "y"),
            xy=product("x", "y"),
            x0=product("x", "0"),
            y0=product("y", "0"),
            m=product("0", "0"),
        )

    def product(
        self,
        row: str,
        column: str,
        elements: NDArray[np.bool_] | None = None,
        weight: NDArray[np.float64] | None = None,
    ) -> csr_matrix:
        """Integral of weight times N_i (or its derivative by ``row``) times N_j (by ``column``), (n, n).

        Most products of hierarchical functions are orthogonal on rectangles: what is rounding noise
        is dropped, for it would fill the factors of a sparse solver.

        Parameters
        ----------
        row, column : str
            ``x`` or ``y`` for that derivative, ``0`` for the function itself.
        elements : (elements,) bool ndarray, optional
            All unless given.
        weight : (elements, quadrature points) ndarray, optional
            At the points `quadrature_points` of all elements.
        """
        chosen = np.flatnonzero(np.ones(self.basis.nelems, bool) if elements is None else elements)
        measure = self.basis.dx[chosen] if weight is None else self.basis.dx[chosen] * weight[chosen]
        left, right = self.at_quadrature(row, chosen), self.at_quadrature(column, chosen)
        blocks = (left * measure[:, None]) @ right.transpose(0, 2, 1)
        return _scatter(blocks, np.asarray(self.basis.element_dofs)[:, chosen].T, self.size)

    def at_quadrature(self, derivative: str, chosen: NDArray[np.int_]) -> NDArray[np.float64]:
        """Shape functions, or their derivatives by ``x`` or ``y``, (elements, functions, quadrature points)."""
        if derivative == "0":
            return np.stack([np.asarray(function[0])[chosen] for function in self.basis.basis], axis=1)
        axis = "xy".index(derivative)
        return np.stack([np.asarray(function[0].grad)[axis, chosen] for function in self.basis.basis], axis=1)

    def shifted(
        self, elements: NDArray[np.bool_], dx: float, dy: float, others: Sequence[NDArray[np.bool_]] = ()
    ) -> "ShapeSpace":
        """Move a block of elements by (dx, dy) m; `others` are blocks that stay as they are.

        The elements around it stretch alike, up to `REACH` or as far as there is room: functions and their numbers
        stay, and what is integrated depends smoothly on the block's place. ValueError if it would not fit.
        """
        mesh = self.basis.mesh
        own, rest = self._extent(elements), [self._extent(other) for other in others]
        share, stretch = np.ones(mesh.p.shape[1]), 0.0
        for axis, (lines, way) in enumerate(zip((self.x.position, self.y.position), (dx, dy), strict=True)):
            low, high = own[:, axis]
            ends = np.array([wall[:, axis] for wall in rest if _apart(own, wall) == axis]).ravel()
            stops = np.concatenate([lines[[0, -1]], lines[(lines <= low - REACH) | (lines >= high + REACH)], ends])
            first, last = stops[stops <= low].max(), stops[stops >= high].min()
            stretch += abs(way) / max(min(low - first, last - high), 1e-12)
            share = share * np.interp(mesh.p[axis], [first, low, high, last], [0.0, 1.0, 1.0, 0.0])
        if stretch > MOST_STRETCH:
            raise ValueError(f"a block moved by ({dx:g}, {dy:g}) m has not the room around it")
        basis = skfem.CellBasis(
            skfem.MeshQuad(mesh.p + share * np.array([[dx], [dy]]), mesh.t),
            skfem.ElementQuadP(self.recipe.degree),
            intorder=self.recipe.quadrature_order,
        )
        return replace(self, basis=basis)

    def _extent(self, elements: NDArray[np.bool_]) -> NDArray[np.float64]:
        """Least and largest x and y of some elements, (2, 2), one axis a column."""
        corners = self.basis.mesh.p[:, self.basis.mesh.t[:, elements]].reshape(2, -1)
        return np.array([corners.min(axis=1), corners.max(axis=1)])

    @property
    def quadrature_points(self) -> NDArray[np.float64]:
        """Where weights are given, (2, elements, quadrature points), m."""
        return np.asarray(self.basis.global_coordinates())

    def dilatation(self, elements: NDArray[np.bool_]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Integrals of N,x and N,y over some elements, (n,) each, m."""
        chosen = np.flatnonzero(elements)
        index = np.asarray(self.basis.element_dofs)[:, chosen]
        sums = np.zeros((2, self.size))
        for function, dofs in zip(self.basis.basis, index, strict=True):
            moments = np.einsum("deq,eq->de", np.asarray(function[0].grad)[:, chosen], self.basis.dx[chosen])
            for total, moment in zip(sums, moments, strict=True):
                np.add.at(total, dofs, moment)
        return sums[0], sums[1]

    def values(self, points: NDArray[np.float64]) -> csr_matrix:
        """Shape functions at points (K, 2) in m: (K, n)."""
        return csr_matrix(self.basis.probes(np.ascontiguousarray(points.T)))

    def slopes(self, points: NDArray[np.float64]) -> tuple[csr_matrix, csr_matrix]:
        """Differentiate the shape functions by x and by y at points (K, 2) in m: (K, n) each, 1/m."""
        basis = self.basis
        places = np.ascontiguousarray(points.T)
        cells = basis.mesh.element_finder(mapping=basis.mapping)(*places)
        local = basis.mapping.invF(places[:, :, None], tind=cells)
        index = np.asarray(basis.element_dofs)[:, cells]
        rows = np.broadcast_to(np.arange(len(points)), index.shape).ravel()
        grads = np.stack(
            [
                np.asarray(basis.elem.gbasis(basis.mapping, local, k, tind=cells)[0].grad)[:, :, 0]
                for k in range(basis.Nbfun)
            ]
        )
        return (
            csr_matrix((grads[:, 0].ravel(), (rows, index.ravel())), shape=(len(points), self.size)),
            csr_matrix((grads[:, 1].ravel(), (rows, index.ravel())), shape=(len(points), self.size)),
        )

    def on_edges(self, edges: Sequence[str]) -> NDArray[np.bool_]:
        """Which functions live on the given edges (``left``, ``right``, ``bottom``, ``top``)."""
        low = self.x.position[0], self.y.position[0]
        high = self.x.position[-1], self.y.position[-1]
        place = {"left": (0, low[0]), "right": (0, high[0]), "bottom": (1, low[1]), "top": (1, high[1])}
        chosen = np.zeros(self.size, bool)
        for edge in edges:
            axis, position = place[edge]
            facets = self.basis.mesh.facets_satisfying(
                lambda p, axis=axis, position=position: np.abs(p[axis] - position) < 1e-9  # type: ignore[misc]
            )
            chosen[self.basis.get_dofs(facets).all()] = True
        return chosen

    def degrees(self) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Degree of every element's functions along x and y, (functions, elements) each."""
        p = self.recipe.degree
        bubbles = np.arange(2, p + 1)
        flat = np.ones(p - 1, int)
        first = np.concatenate([np.ones(4, int), bubbles, flat, bubbles, flat, np.repeat(bubbles, p - 1)])
        second = np.concatenate([np.ones(4, int), flat, bubbles, flat, bubbles, np.tile(bubbles, p - 1)])
        mesh = self.basis.mesh
        step = np.abs(mesh.p[:, mesh.t[1]] - mesh.p[:, mesh.t[0]])
        along_x = step[0] > step[1]  # whether the reference element's first axis is the plate's x
        return (
            np.where(along_x, first[:, None], second[:, None]),
            np.where(along_x, second[:, None], first[:, None]),
        )

    def up_to(self, degree_x: NDArray[np.int_], degree_y: NDArray[np.int_]) -> NDArray[np.bool_]:
        """Which functions some element admits, given each element's highest degree along x and y."""
        along_x, along_y = self.degrees()
        admitted = (along_x <= np.maximum(degree_x, 1)) & (along_y <= np.maximum(degree_y, 1))
        kept = np.zeros(self.size, bool)
        kept[self.basis.element_dofs[admitted]] = True
        return kept


def _apart(one: NDArray[np.float64], other: NDArray[np.float64]) -> int:
    """Return the axis along which two extents are further apart: there one is the other's wall."""
    return int(np.maximum(other[0] - one[1], one[0] - other[1]).argmax())


def _scatter(blocks: NDArray[np.float64], index: NDArray[np.int_], size: int) -> csr_matrix:
    """Sum element matrices (elements, b, b) into an (n, n) matrix, rounding noise left out."""
    scale = np.abs(blocks).max(axis=(1, 2), keepdims=True)
    element, row, column = np.nonzero(np.abs(blocks) > 1e-13 * scale)
    entries = (blocks[element, row, column], (index[element, row], index[element, column]))
    return csr_matrix(coo_matrix(entries, shape=(size, size)))
