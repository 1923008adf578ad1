"""Elementary energies of a shell over one region, each linear in one modulus, with a weight over the region.

In-plane strain energy has four parts, one for each of Q11, Q22, Q12 and Q66 of an orthotropic layer; the
membrane, bending and coupling energies of a shell are the same four of other fields.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csr_matrix

from simulation.shape_space import ShapeSpace

Real = NDArray[np.float64]
Mask = NDArray[np.bool_]
Modulus = Literal["q11", "q22", "q12", "q66"]
MODULI: tuple[Modulus, ...] = ("q11", "q22", "q12", "q66")

Blocks = tuple[tuple[csr_matrix, csr_matrix], tuple[csr_matrix, csr_matrix]]
"""Of two components of motion along x and y, each over the functions of a `ShapeSpace`."""


def plane_form(
    space: ShapeSpace, modulus: Modulus, weight: Real | None = None, elements: Mask | None = None
) -> Blocks:
    """Integral of weight times the product of two in-plane strains that `modulus` multiplies."""
    nothing = csr_matrix((space.size, space.size))
    if modulus == "q11":
        return ((space.product("x", "x", elements, weight), nothing), (nothing, nothing))
    if modulus == "q22":
        return ((nothing, nothing), (nothing, space.product("y", "y", elements, weight)))
    if modulus == "q12":
        cross = space.product("x", "y", elements, weight)
        return ((nothing, cross), (csr_matrix(cross.T), nothing))
    cross = space.product("y", "x", elements, weight)
    return (
        (space.product("y", "y", elements, weight), cross),
        (csr_matrix(cross.T), space.product("x", "x", elements, weight)),
    )


def weighted_sum(parts: list[Blocks]) -> Blocks:
    """Sum of blocks."""
    (a, b), (c, d) = parts[0]
    for (e, f), (g, h) in parts[1:]:
        a, b, c, d = a + e, b + f, c + g, d + h
    return ((a, b), (c, d))


@dataclass(frozen=True)
class ShearForm:
    """Transverse shear energy (w,x + thx)**2 + (w,y + thy)**2 over a region: blocks of w, thx and thy."""

    ww: csr_matrix
    wx: csr_matrix
    wy: csr_matrix
    tt: csr_matrix

    @classmethod
    def of(cls, space: ShapeSpace, weight: Real | None = None, elements: Mask | None = None) -> "ShearForm":
        """Integrate with a weight over a region."""
        return cls(
            ww=space.product("x", "x", elements, weight) + space.product("y", "y", elements, weight),
            wx=space.product("x", "0", elements, weight),
            wy=space.product("y", "0", elements, weight),
            tt=space.product("0", "0", elements, weight),
        )


def shell_matrix(
    membrane: Blocks, coupling: Blocks | None, bending: Blocks, shear: ShearForm | None
) -> csr_matrix:
    """(5 n, 5 n) matrix over u, v, w, thx, thy; coupling is that of (u, v) with (thx, thy)."""
    (a11, a12), (a21, a22) = membrane
    (d11, d12), (d21, d22) = bending
    rows = [
        [a11, a12, None, None, None],
        [a21, a22, None, None, None],
        [None, None, csr_matrix(a11.shape), None, None],
        [None, None, None, d11, d12],
        [None, None, None, d21, d22],
    ]
    if shear is not None:
        rows[2][2] = shear.ww
        rows[2][3], rows[2][4] = shear.wx, shear.wy
        rows[3][2], rows[4][2] = csr_matrix(shear.wx.T), csr_matrix(shear.wy.T)
        rows[3][3], rows[4][4] = d11 + shear.tt, d22 + shear.tt
    if coupling is not None:
        for i in range(2):
            for j in range(2):
                rows[i][3 + j] = coupling[i][j]
                rows[3 + j][i] = csr_matrix(coupling[i][j].T)
    return csr_matrix(bmat(rows))
