"""Projection of every field-weighted energy of a plate with patches onto given vectors."""

from collections.abc import Callable, Collection
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from simulation.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE
from simulation.field_basis import polynomial, polynomials
from simulation.laminate import SHEAR_FACTOR
from simulation.plane_forms import MODULI, Blocks, Modulus, plane_form, weighted_sum
from simulation.shape_space import ShapeSpace
from simulation.state_matrices import FullPlate, mean_height_dilatation

Real = NDArray[np.float64]
Mask = NDArray[np.bool_]
Step = Callable[[], None]

STRAIN_SPACING = 0.004
"""Distance of the points at which strains are kept, m: some thirty within a spot of 24 mm."""

U, V, W, THX, THY = range(5)
IN_PLANE, ROTATIONS = (U, V), (THX, THY)


@dataclass(frozen=True)
class Projector:
    """Vectors (n, r) of a plate, field by field."""

    full: FullPlate
    vectors: Real

    @cached_property
    def _by_field(self) -> list[tuple[NDArray[np.int_], Real]]:
        field, function = np.divmod(self.full.unknowns, self.full.space.size)
        return [(function[field == k], self.vectors[field == k]) for k in range(5)]

    def rows(self, field: int) -> tuple[NDArray[np.int_], Real]:
        """Functions that a field uses, and the vectors there."""
        return self._by_field[field]

    def gram(self, matrix: csr_matrix, left: int, right: int) -> Real:
        """V_left' A V_right for a matrix over the shape functions, (r, r)."""
        (rows, first), (columns, second) = self.rows(left), self.rows(right)
        cut = csr_matrix(matrix[rows][:, columns])
        used = np.flatnonzero(np.diff(cut.indptr))
        return np.asarray(first[used].T @ (cut[used] @ second))

    def plane(self, blocks: Blocks, left: tuple[int, int], right: tuple[int, int]) -> Real:
        """Energy of two in-plane motions (or rotations), (r, r)."""
        r = self.vectors.shape[1]
        total = np.zeros((r, r))
        for i in range(2):
            for j in range(2):
                if blocks[i][j].nnz and not (left == right and i > j):
                    part = self.gram(blocks[i][j], left[i], right[j])
                    total += part + part.T if left == right and i != j else part
        return total

    def weight(self, degrees: tuple[int, int]) -> Real:
        """Return a polynomial at the quadrature points, (elements, points)."""
        xi, zeta = self.full.sampling
        return polynomial(degrees, xi, zeta).reshape(self.full.space.basis.dx.shape)


def plate_energies(p: Projector, executor: Executor, step: Step) -> dict[str, Real]:
    """Stacks ``bending``, ``membrane``, ``shear``, ``mass``, ``rotary`` and ``normal`` of `EffectOperators`."""

    def of(degrees: tuple[int, int]) -> dict[str, Real]:
        wanted = {"bending", "membrane", "shear", "mass"} if sum(degrees) <= MEMBRANE_DEGREE else {"bending"}
        return weighed_energies(p, p.full.space, p.weight(degrees), wanted)

    found = []
    for energies in executor.map(of, polynomials(BENDING_DEGREE)):
        found.append(energies)
        step()
    stacks = {name: np.array([energies[name] for energies in found if name in energies]) for name in found[0]}
    for name in ("bending", "membrane"):  # by modulus first
        stacks[name] = np.moveaxis(stacks[name], 1, 0)
    return {**stacks, "normal": p.gram(p.full.space.product("0", "0"), W, W)}


def weighed_energies(
    p: Projector, space: ShapeSpace, weight: Real, wanted: Collection[str], covered: Mask | None = None
) -> dict[str, Real]:
    """Energies of the plate with a weight over some elements: those `wanted`; with ``mass`` comes ``rotary``."""
    h, rho = p.full.plate.thickness, p.full.plate.density
    forms = [plane_form(space, modulus, weight, covered) for modulus in MODULI]
    found = {}
    if "bending" in wanted:
        found["bending"] = h**3 / 12.0 * np.array([p.plane(form, ROTATIONS, ROTATIONS) for form in forms])
    if "membrane" in wanted:
        found["membrane"] = h * np.array([p.plane(form, IN_PLANE, IN_PLANE) for form in forms])
    if "shear" in wanted:
        found["shear"] = SHEAR_FACTOR * h * transverse_shear(p, space, weight, covered)
    if "mass" in wanted:
        inertia = space.product("0", "0", covered, weight)
        displaced, turned = (sum(p.gram(inertia, k, k) for k in fields) for fields in ((U, V, W), ROTATIONS))
        found["mass"] = np.asarray(rho * h * displaced)
        found["rotary"] = np.asarray(rho * h**3 / 12.0 * turned)
    return found


def transverse_shear(p: Projector, space: ShapeSpace, weight: Real | None, covered: Mask | None = None) -> Real:
    """Transverse shear energy for a shear stiffness of 1 N/m times a weight over some elements, (r, r)."""
    ww = space.product("x", "x", covered, weight) + space.product("y", "y", covered, weight)
    mass = space.product("0", "0", covered, weight)
    cross = p.gram(space.product("x", "0", covered, weight), W, THX)
    cross += p.gram(space.product("y", "0", covered, weight), W, THY)
    return p.gram(ww, W, W) + cross + cross.T + p.gram(mass, THX, THX) + p.gram(mass, THY, THY)


def patch_energies(p: Projector, executor: Executor) -> dict[str, Real]:
    """Stacks ``patch_own``, ``patch_membrane``, ``patch_mass`` and ``coupling`` of `EffectOperators`."""
    r, terms = p.vectors.shape[1], polynomials(BENDING_DEGREE)
    own, mass = np.zeros((r, r)), np.zeros((r, r))
    membrane = np.zeros((1 + 2 * len(terms), r, r))
    coupling = np.zeros((1 + len(terms), r, len(p.full.patches)))
    flat = np.ones(p.full.space.basis.dx.shape)
    for k, (patch, covered) in enumerate(zip(p.full.patches, p.full.under, strict=True)):
        ceramic, t, h = p.full.materials[patch.material], patch.thickness, p.full.plate.thickness
        sign = 1.0 if patch.side == "top" else -1.0
        z0 = 0.5 * sign * (h + t)
        form = _laminate(p, ceramic.stiffness, flat, covered)
        mb, bb = _levers(p, form)
        own += t**3 / 12.0 * bb
        own += (
            SHEAR_FACTOR
            * t
            * 0.5
            * (ceramic.stiffness[0] - ceramic.stiffness[1])
            * transverse_shear(p, p.full.space, None, covered)
        )
        membrane[0] += t * (p.plane(form, IN_PLANE, IN_PLANE) + z0 * mb + z0**2 * bb)
        mass += _patch_mass(p, covered, ceramic.density * t, z0, t)
        coupling[0, :, k] = ceramic.e31 * _dilatation(p, covered, flat, z0 * flat)
        weights = [p.weight(degrees) for degrees in terms]
        forms = (_laminate(p, ceramic.stiffness, weight, covered) for weight in weights)
        for j, (mb, bb) in enumerate(executor.map(partial(_levers, p), forms)):
            membrane[1 + j] += t * (0.5 * sign * h * mb + 0.5 * sign * h * 2.0 * z0 * bb)
            membrane[1 + len(terms) + j] += t * 0.25 * h**2 * bb
            lever = 0.5 * sign * h * weights[j]
            coupling[1 + j, :, k] = ceramic.e31 * _dilatation(p, covered, np.zeros_like(flat), lever)
    return {"patch_own": own, "patch_membrane": membrane, "patch_mass": mass, "coupling": coupling}


def _laminate(p: Projector, stiffness: tuple[float, float], weight: Real, covered: Mask) -> Blocks:
    """In-plane energy of an isotropic layer of moduli Q11, Q12, weighted, over some elements."""
    q11, q12 = stiffness
    moduli: dict[Modulus, float] = {"q11": q11, "q22": q11, "q12": q12, "q66": 0.5 * (q11 - q12)}
    return weighted_sum([plane_form(p.full.space, m, value * weight, covered) for m, value in moduli.items()])


def _levers(p: Projector, form: Blocks) -> tuple[Real, Real]:
    """Energies of membrane with bending (both ways), and of bending."""
    cross = p.plane(form, IN_PLANE, ROTATIONS)
    return cross + cross.T, p.plane(form, ROTATIONS, ROTATIONS)


def _patch_mass(p: Projector, covered: Mask, area: float, height: float, thickness: float) -> Real:
    inertia = p.full.space.product("0", "0", covered)
    straight = sum(p.gram(inertia, k, k) for k in (U, V, W))
    turning = sum(p.gram(inertia, k, k) for k in ROTATIONS)
    cross = p.gram(inertia, U, THX) + p.gram(inertia, V, THY)
    second = height**2 + thickness**2 / 12.0
    return np.asarray(area * (straight + second * turning + height * (cross + cross.T)))


def _dilatation(p: Projector, covered: Mask, flat: Real, height: Real) -> Real:
    """Integral of (flat (u,x + v,y) + height (thx,x + thy,y)) over some elements, (r,)."""
    full = mean_height_dilatation(p.full.space, covered, height, flat)
    return np.asarray(full[p.full.unknowns] @ p.vectors)


def strains(p: Projector) -> dict[str, Any]:
    """Entries ``strain``, ``strain_points`` and ``cell`` of `EffectOperators`."""
    plate = p.full.plate
    counts = [int(np.ceil(length / STRAIN_SPACING)) for length in (plate.length_x, plate.length_y)]
    x, y = (
        (np.arange(n) + 0.5) * length / n
        for n, length in zip(counts, (plate.length_x, plate.length_y), strict=True)
    )
    points = np.array([(a, b) for a in x for b in y])
    by_x, by_y = p.full.space.slopes(points)
    value = p.full.space.values(points)

    def of(matrix: csr_matrix, field: int) -> Real:
        functions, vectors = p.rows(field)
        return np.asarray(matrix[:, functions] @ vectors)

    return {
        "strain": np.array(
            [
                of(by_x, U),
                of(by_y, V),
                of(by_y, U) + of(by_x, V),
                of(by_x, THX),
                of(by_y, THY),
                of(by_y, THX) + of(by_x, THY),
                of(by_x, W) + of(value, THX),
                of(by_y, W) + of(value, THY),
            ]
        ),
        "strain_points": points,
        "cell": plate.length_x * plate.length_y / len(points),
        "thickness": plate.thickness,
    }
