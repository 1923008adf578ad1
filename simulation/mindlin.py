"""Assembly of a laminated Reissner-Mindlin shell with piezo patches.

Five fields: mid-plane displacements u, v, w (m) and the rotations thx, thy (rad) of the normal
towards +x and +y, so that a point at height z moves by (u + z thx, v + z thy, w). Curvatures are
(thx,x, thy,y, thx,y + thy,x), transverse shear strains (w,x + thx, w,y + thy).
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csr_matrix

from analysis.experiment import Patch, Plate
from simulation.laminate import SHEAR_FACTOR, Elasticity, Layer, patch_layer
from simulation.mesh import MeshRecipe, mesh_lines
from simulation.piezo_material import PIEZO_MATERIALS, PiezoMaterial
from simulation.shape_space import Integrals, Rectangle, ShapeSpace
from simulation.shell_model import ShellModel, elimination_order
from simulation.thinning import thinned

FIELDS = ("u", "v", "w", "thx", "thy")
EDGES = ("left", "right", "bottom", "top")

Supports = Mapping[str, Sequence[str]]
"""Fields held at zero on each edge of the plate."""

CLAMPED: Supports = dict.fromkeys(EDGES, FIELDS)


def assemble(
    plate: Plate,
    patches: Sequence[Patch] = (),
    *,
    recipe: MeshRecipe | None = None,
    supports: Supports | None = None,
    materials: Mapping[str, PiezoMaterial] = PIEZO_MATERIALS,
) -> ShellModel:
    """Matrices of a plate with patches, in the form that is affine in the plate's moduli.

    Parameters
    ----------
    plate : Plate
    patches : sequence of Patch
        Voltages and charges keep this order.
    recipe : MeshRecipe, optional
        The converged recipe unless given.
    supports : mapping from edge to fields, optional
        Overrides what ``plate.boundary`` says.
    materials : mapping
        Piezo material of each ``Patch.material``.

    Returns
    -------
    ShellModel
    """
    recipe = recipe or MeshRecipe()
    regions = [(patch.span(0), patch.span(1)) for patch in patches]
    space = ShapeSpace.on(
        mesh_lines(plate.length_x, [r[0] for r in regions], recipe),
        mesh_lines(plate.length_y, [r[1] for r in regions], recipe),
        recipe,
    )
    if supports is None:
        supports = CLAMPED if plate.boundary == "clamped" else {}
    kept = _unknowns(space, regions, supports)
    layer = Layer(plate.thickness)
    whole = space.integrals()
    mass = inertia(whole, layer, plate.density)
    stiffness_patch = csr_matrix(mass.shape)
    coupling, capacitance = [], []
    for patch, region in zip(patches, regions, strict=True):
        ceramic = materials[patch.material]
        on_top = patch_layer(plate.thickness, patch.thickness, patch.side)
        covered = space.inside(region)
        local = space.integrals(covered)
        stiffness_patch = stiffness_patch + stiffness(local, on_top, Elasticity.isotropic(*ceramic.stiffness))
        mass = mass + inertia(local, on_top, ceramic.density)
        coupling.append(ceramic.e31 * _mean_height_dilatation(space, covered, on_top))
        capacitance.append(ceramic.permittivity * patch.size[0] * patch.size[1] / patch.thickness)
    stiffness_1 = stiffness(whole, layer, Elasticity.isotropic(1.0, 0.0))
    stiffness_2 = stiffness(whole, layer, Elasticity.isotropic(0.0, 1.0))
    select = np.flatnonzero(kept)
    pattern = abs(stiffness_1) + abs(stiffness_2) + abs(stiffness_patch) + abs(mass)
    select = select[elimination_order(_restricted(pattern, select))]
    return ShellModel(
        space=space,
        unknowns=select,
        stiffness_1=_restricted(stiffness_1, select),
        stiffness_2=_restricted(stiffness_2, select),
        stiffness_patch=_restricted(stiffness_patch, select),
        mass=_restricted(mass, select),
        coupling=np.array(coupling).reshape(len(patches), 5 * space.size).T[select],
        capacitance=np.array(capacitance),
    )


def stiffness(integrals: Integrals, layer: Layer, material: Elasticity) -> csr_matrix:
    """Stiffness of one layer over one region, all five fields, (5 n, 5 n).

    Reissner-Mindlin shell: membrane, coupling and bending integrals of the layer multiply the
    same in-plane form; the shear factor multiplies the transverse shear.
    """
    i = integrals
    plane = [
        [material.q11 * i.xx + material.q66 * i.yy, material.q12 * i.xy + material.q66 * i.xy.T],
        [material.q12 * i.xy.T + material.q66 * i.xy, material.q11 * i.yy + material.q66 * i.xx],
    ]
    a, b, d = layer.moments
    s = SHEAR_FACTOR * material.g * layer.thickness
    (pxx, pxy), (pyx, pyy) = plane
    return csr_matrix(
        bmat(
            [
                [a * pxx, a * pxy, None, b * pxx, b * pxy],
                [a * pyx, a * pyy, None, b * pyx, b * pyy],
                [None, None, s * (i.xx + i.yy), s * i.x0, s * i.y0],
                [b * pxx, b * pxy, s * i.x0.T, d * pxx + s * i.m, d * pxy],
                [b * pyx, b * pyy, s * i.y0.T, d * pyx, d * pyy + s * i.m],
            ]
        )
    )


def inertia(integrals: Integrals, layer: Layer, density: float) -> csr_matrix:
    """Mass of one layer over one region with rotary inertia and offset first moment, (5 n, 5 n)."""
    m0, m1, m2 = (density * moment * integrals.m for moment in layer.moments)
    return csr_matrix(
        bmat(
            [
                [m0, None, None, m1, None],
                [None, m0, None, None, m1],
                [None, None, m0, None, None],
                [m1, None, None, m2, None],
                [None, m1, None, None, m2],
            ]
        )
    )


def _mean_height_dilatation(space: ShapeSpace, elements: NDArray[np.bool_], layer: Layer) -> NDArray[np.float64]:
    """Integral over some elements of the in-plane dilatation at a layer's mid-height, (5 n,), m2."""
    dx, dy = space.dilatation(elements)
    return np.concatenate([dx, dy, np.zeros(space.size), layer.height * dx, layer.height * dy])


def _restricted(matrix: csr_matrix, select: NDArray[np.int_]) -> csr_matrix:
    smaller = csr_matrix(matrix[select][:, select])
    smaller.eliminate_zeros()
    return csr_matrix(0.5 * (smaller + smaller.T))


def _unknowns(space: ShapeSpace, regions: Sequence[Rectangle], supports: Supports) -> NDArray[np.bool_]:
    """Which functions of which field are unknowns, (5 n,)."""
    kept = np.ones((5, space.size), bool)
    if space.recipe.thinned:
        membrane, bending = thinned(space, regions)
        kept[:2], kept[2:] = membrane, bending
    for edge, fields in supports.items():
        held = space.on_edges([edge])
        for field in fields:
            kept[FIELDS.index(field)] &= ~held
    return kept.ravel()
