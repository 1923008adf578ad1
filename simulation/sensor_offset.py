"""What moving the first sensor patch changes, as polynomials of its offset in reduced coordinates.

The mesh moves with the patch: shear layers at its edges stay on the strips made for them, the patch's own matrices
do not change at all, and those of the elements around it are smooth functions of the offset.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from simulation.composition import OFFSET_DEGREE, monomials
from simulation.effect_projection import Projector
from simulation.laminate import SHEAR_FACTOR
from simulation.plane_forms import MODULI, Blocks, ShearForm, plane_form, shell_matrix, weighted_sum
from simulation.shape_space import ShapeSpace
from simulation.state_matrices import FullPlate, plate_inertia

Real = NDArray[np.float64]
Mask = NDArray[np.bool_]

OFFSET_RANGE = 0.003
"""How far the first sensor patch can sit off its place along x or y, m."""
NAMES = ("offset_1", "offset_2", "offset_mass")


def can_move(full: FullPlate) -> bool:
    """Whether the first sensor has room for offsets up to `OFFSET_RANGE`."""
    try:
        for x in (-OFFSET_RANGE, OFFSET_RANGE):
            for y in (-OFFSET_RANGE, OFFSET_RANGE):
                full.space.shifted(full.under[full.moved], x, y)
    except ValueError:
        return False
    return True


def offset_energies(p: Projector) -> dict[str, object]:
    """Stacks ``offset_*`` of `EffectOperators`, fitted over a grid of offsets; zero where it cannot move."""
    count, r, full = len(monomials(0.0, 0.0)), p.vectors.shape[1], p.full
    if not can_move(full):
        return {**{name: np.zeros((count, r, r)) for name in NAMES}, "offset_range": 0.0}
    places = padua_points(OFFSET_DEGREE)
    zone = _zone(full)
    origin = _matrices(full, full.space, zone)
    fit = np.linalg.pinv(np.array([monomials(x, y) for x, y in places]))
    stacks: list[list[Real]] = [[] for _ in NAMES]
    for x, y in places:
        space = full.space.shifted(full.under[full.moved], OFFSET_RANGE * x, OFFSET_RANGE * y)
        for stack, new, old in zip(stacks, _matrices(full, space, zone), origin, strict=True):
            stack.append(_projected(p, new - old))
    found: dict[str, object] = {
        name: np.tensordot(fit, np.array(stack), 1) for name, stack in zip(NAMES, stacks, strict=True)
    }
    return {**found, "offset_range": OFFSET_RANGE}


def padua_points(degree: int) -> list[tuple[float, float]]:
    """Points of a square that determine polynomials of a total degree (Caliari et al., AMC 165, 2005)."""
    x = np.cos(np.pi * np.arange(degree + 1) / degree)
    y = np.cos(np.pi * np.arange(degree + 2) / (degree + 1))
    return [(float(x[i]), float(y[j])) for i in range(x.size) for j in range(y.size) if (i + j) % 2 == 0]


def _zone(full: FullPlate) -> Mask:
    """Elements that change when the sensor moves."""
    mesh = full.space.basis.mesh
    moved = full.space.shifted(full.under[full.moved], 1e-3 * OFFSET_RANGE, 1e-3 * OFFSET_RANGE).basis.mesh
    return np.asarray((mesh.p != moved.p).any(axis=0)[mesh.t].any(axis=0))


def _matrices(full: FullPlate, space: ShapeSpace, zone: Mask) -> list[csr_matrix]:
    """K1, K2 and the mass of the plate over the zone, (5 n, 5 n)."""
    h, rho = full.plate.thickness, full.plate.density
    ones = np.ones(space.basis.dx.shape)

    def stiffness(q11: float, q12: float) -> csr_matrix:
        shares = {"q11": q11, "q22": q11, "q12": q12, "q66": 0.5 * (q11 - q12)}

        def plane(factor: float) -> Blocks:
            return weighted_sum([plane_form(space, m, factor * shares[m] * ones, zone) for m in MODULI])

        shear = ShearForm.of(space, SHEAR_FACTOR * h * shares["q66"] * ones, zone)
        return shell_matrix(plane(h), None, plane(h**3 / 12.0), shear)

    mass = plate_inertia(space, rho * h * ones, rho * h**3 / 12.0 * ones, None, zone)
    return [stiffness(1.0, 0.0), stiffness(0.0, 1.0), mass]


def _projected(p: Projector, change: csr_matrix) -> Real:
    """V' A V over the rows that A has, (r, r)."""
    cut = csr_matrix(change[p.full.unknowns][:, p.full.unknowns])
    used = np.flatnonzero(np.diff(cut.indptr))
    small = p.vectors[used].T @ (cut[used] @ p.vectors)
    return np.asarray(0.5 * (small + small.T))
