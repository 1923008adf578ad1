"""Sparse matrices of a plate in any state, fields taken at the quadrature points."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_diag, bmat, csr_matrix

from analysis.experiment import Patch, Plate
from simulation.laminate import SHEAR_FACTOR
from simulation.piezo_material import PIEZO_MATERIALS, PiezoMaterial
from simulation.plane_forms import MODULI, Blocks, ShearForm, plane_form, shell_matrix, weighted_sum
from simulation.plate_state import PlateState
from simulation.shape_space import ShapeSpace

Real = NDArray[np.float64]


@dataclass(frozen=True)
class StateMatrices:
    """A plate in one state: Z = storage K + j loss K_loss + Kp - w**2 M + (j w r - w**2 m) W.

    Attributes
    ----------
    plate, plate_loss, patches, mass, normal : (n, n) csr_matrix
        K, K_loss (already times the loss factor), Kp, M, and W, the integral of w times w.
    coupling : (n, P) ndarray
    """

    plate: csr_matrix
    plate_loss: csr_matrix
    patches: csr_matrix
    mass: csr_matrix
    normal: csr_matrix
    coupling: Real


@dataclass(frozen=True)
class FullPlate:
    """A meshed plate with patches that can be assembled in any state.

    Attributes
    ----------
    space : ShapeSpace
    plate : Plate
    patches : tuple of Patch
    under : tuple of (elements,) bool ndarray
        The elements under each patch.
    unknowns : (n,) ndarray
        As in `ShellModel`.
    moved : int
        The patch that a state's offset moves.
    materials : mapping
        Piezo material of each ``Patch.material``.
    """

    space: ShapeSpace
    plate: Plate
    patches: tuple[Patch, ...]
    under: tuple[NDArray[np.bool_], ...]
    unknowns: NDArray[np.int_]
    moved: int
    materials: Mapping[str, PiezoMaterial]

    @classmethod
    def of(
        cls,
        space: ShapeSpace,
        plate: Plate,
        patches: Sequence[Patch],
        unknowns: NDArray[np.int_],
        materials: Mapping[str, PiezoMaterial] = PIEZO_MATERIALS,
    ) -> "FullPlate":
        """Take the mesh and the unknowns of a `ShellModel`; the first sensor patch is the one that can move."""
        moved = next((k for k, patch in enumerate(patches) if patch.role == "sensor"), 0)
        under = tuple(space.inside((patch.span(0), patch.span(1))) for patch in patches)
        return cls(space, plate, tuple(patches), under, unknowns, moved, materials)

    @property
    def sampling(self) -> tuple[Real, Real]:
        """Return xi and zeta of all quadrature points, flat; of a moved sensor's, see `moved_by`."""
        x, y = self.space.quadrature_points
        return (2.0 * x / self.plate.length_x - 1.0).ravel(), (2.0 * y / self.plate.length_y - 1.0).ravel()

    def moved_by(self, dx: float, dy: float) -> "FullPlate":
        """Return the plate with its first sensor (dx, dy) m off its place; ValueError where it has no room."""
        others = [under for k, under in enumerate(self.under) if k != self.moved]
        return replace(self, space=self.space.shifted(self.under[self.moved], dx, dy, others))

    def matrices(self, state: PlateState) -> StateMatrices:
        """Assemble `state`; discs and point loads are not in it.

        Its fields stand at the points of `sampling`, those of the moved plate if the state has an offset.
        """
        here = self
        if state.offset_x or state.offset_y:
            here = self.moved_by(state.offset_x, state.offset_y)
        shape = here.space.basis.dx.shape
        thickness = self.plate.thickness * state.thickness.reshape(shape)
        temperature = state.temperature.reshape(shape)
        nu = state.laws.poisson_ratio(temperature)
        c1 = state.laws.youngs_modulus(temperature) / (1.0 - nu**2)
        loss = state.laws.loss_factor(temperature)
        normal = here.space.product("0", "0")
        nothing = csr_matrix((here.space.size,) * 2)
        stiffness, mass, coupling = here._patches(state, thickness)
        density = self.plate.density
        mass = mass + plate_inertia(here.space, density * thickness, density * thickness**3 / 12.0)
        return StateMatrices(
            plate=here._kept(here._plate(state, c1, nu, thickness)),
            plate_loss=here._kept(here._plate(state, c1 * loss, nu, thickness)),
            patches=here._kept(stiffness),
            mass=here._kept(mass),
            normal=here._kept(csr_matrix(block_diag([nothing, nothing, normal, nothing, nothing]))),
            coupling=coupling[here.unknowns],
        )

    def _plate(self, state: PlateState, c1: Real, nu: Real, thickness: Real) -> csr_matrix:
        shear = 0.5 * c1 * (1.0 - nu)
        moduli = {
            "q11": c1 * state.modulus_x,
            "q22": c1 * state.modulus_y,
            "q12": c1 * nu * np.sqrt(state.modulus_x * state.modulus_y),
            "q66": shear * state.in_plane_shear,
        }

        def plane(power: Real) -> Blocks:
            return weighted_sum([plane_form(self.space, name, moduli[name] * power) for name in MODULI])

        return shell_matrix(
            plane(thickness),
            None,
            plane(thickness**3 / 12.0),
            ShearForm.of(self.space, SHEAR_FACTOR * shear * thickness),
        )

    def _patches(self, state: PlateState, thickness: Real) -> tuple[csr_matrix, csr_matrix, Real]:
        """Stiffness and mass of all patches (5 n, 5 n), and their couplings (5 n, P)."""
        shape = (5 * self.space.size,) * 2
        stiffness, mass, columns = csr_matrix(shape), csr_matrix(shape), []
        for patch, covered in zip(self.patches, self.under, strict=True):
            ceramic = self.materials[patch.material]
            k, m, b = patch_parts(self.space, patch, ceramic, covered, thickness, state.bond)
            stiffness, mass = stiffness + k, mass + m
            columns.append(b)
        return stiffness, mass, np.array(columns).reshape(len(self.patches), shape[0]).T

    def _kept(self, matrix: csr_matrix) -> csr_matrix:
        smaller = csr_matrix(matrix[self.unknowns][:, self.unknowns])
        return csr_matrix(0.5 * (smaller + smaller.T))


def patch_parts(
    space: ShapeSpace,
    patch: Patch,
    ceramic: PiezoMaterial,
    covered: NDArray[np.bool_],
    thickness: Real,
    bond: float = 1.0,
) -> tuple[csr_matrix, csr_matrix, Real]:
    """Stiffness and mass (5 n, 5 n) and coupling (5 n,) of one patch on a plate whose thickness [m] is a field."""
    q11, q12 = ceramic.stiffness
    moduli = {"q11": q11, "q22": q11, "q12": q12, "q66": 0.5 * (q11 - q12)}
    height = _height(patch, thickness)

    def plane(weight: Real) -> Blocks:
        return weighted_sum([plane_form(space, m, moduli[m] * weight, covered) for m in MODULI])

    flat = np.full_like(thickness, patch.thickness)
    own = np.full_like(thickness, patch.thickness**3 / 12.0)
    bonded = bond * flat
    stiffness = shell_matrix(
        plane(bonded),
        plane(bonded * height),
        plane(bonded * height**2 + own),
        ShearForm.of(space, SHEAR_FACTOR * moduli["q66"] * flat, covered),
    )
    area = ceramic.density * flat
    mass = plate_inertia(space, area, area * height**2 + ceramic.density * own, area * height, covered)
    return stiffness, mass, bond * ceramic.e31 * mean_height_dilatation(space, covered, height)


def mean_height_dilatation(
    space: ShapeSpace, elements: NDArray[np.bool_], height: Real, flat: Real | None = None
) -> Real:
    """Integral over some elements of flat (u,x + v,y) + height (thx,x + thy,y), (5 n,), m2.

    `height` [m] and `flat` (ones unless given) are fields, (elements, quadrature points).
    """
    chosen = np.flatnonzero(elements)
    index = np.asarray(space.basis.element_dofs)[:, chosen].T
    columns = []
    for field in (np.ones_like(height) if flat is None else flat, height):
        measure = space.basis.dx[chosen] * field[chosen]
        for derivative in "xy":
            column = np.zeros(space.size)
            np.add.at(column, index, np.einsum("edq,eq->ed", space.at_quadrature(derivative, chosen), measure))
            columns.append(column)
    return np.concatenate([columns[0], columns[1], np.zeros(space.size), columns[2], columns[3]])


def _height(patch: Patch, thickness: Real) -> Real:
    """Mid-height of a patch above the plate's mid-plane, a field, m."""
    height = 0.5 * (thickness + patch.thickness)
    return height if patch.side == "top" else -height


def plate_inertia(
    space: ShapeSpace,
    area: Real,
    second: Real,
    first: Real | None = None,
    elements: NDArray[np.bool_] | None = None,
) -> csr_matrix:
    """Mass matrix (5 n, 5 n) of moments given as fields."""
    m0, m2 = (space.product("0", "0", elements, field) for field in (area, second))
    m1 = None if first is None else space.product("0", "0", elements, first)
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
