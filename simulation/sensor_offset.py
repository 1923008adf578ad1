"""What moving the first sensor patch changes, as polynomials of its offset in reduced coordinates.

The mesh moves with the patch: shear layers at its edges stay on the strips made for them, the patch's own matrices
do not change at all, and those of the elements around it are smooth functions of the offset.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from simulation.effect_operators import BENDING_DEGREE, OFFSET_DEGREE, monomials
from simulation.effect_projection import IN_PLANE, ROTATIONS, Projector, transverse_shear
from simulation.field_basis import polynomial, polynomials
from simulation.laminate import SHEAR_FACTOR
from simulation.plane_forms import MODULI, plane_form
from simulation.shape_space import ShapeSpace
from simulation.state_matrices import FullPlate

Real = NDArray[np.float64]
Mask = NDArray[np.bool_]

OFFSET_RANGE = 0.0025
"""How far the first sensor patch can sit off its place along x or y, m."""
KEPT = 1e-5
"""Motions of the elements around the sensor weaker than this share of the strongest are left out."""
NAMES = ("offset_bending", "offset_membrane", "offset_shear", "offset_mass")


def can_move(full: FullPlate) -> bool:
    """Whether the first sensor has room for offsets up to `OFFSET_RANGE`, and no other patch stretches with it."""
    try:
        for x in (-OFFSET_RANGE, OFFSET_RANGE):
            for y in (-OFFSET_RANGE, OFFSET_RANGE):
                full.moved_by(x, y)
    except ValueError:
        return False
    zone = _zone(full)
    return not any((zone & under).any() for k, under in enumerate(full.under) if k != full.moved)


def offset_energies(p: Projector) -> dict[str, object]:
    """Stacks ``offset_*`` of `EffectOperators`, fitted over a grid of offsets; zero where it cannot move."""
    count, r, full = len(monomials(0.0, 0.0)), p.vectors.shape[1], p.full
    site = {"sensor_site": _site(full)}
    if not can_move(full):
        shapes = ((4, count), (4, count), (count,), (count,))
        empty = {name: np.zeros((*shape, r, r)) for name, shape in zip(NAMES, shapes, strict=True)}
        return {**site, **empty, "offset_range": 0.0}
    zone = _zone(full)
    near, back = _around(p, zone)
    places = padua_points(OFFSET_DEGREE)
    fit = np.linalg.pinv(np.array([monomials(x, y) for x, y in places]))
    origin = _energies(near, full.space, zone)
    changes = []
    for x, y in places:
        space = full.moved_by(OFFSET_RANGE * x, OFFSET_RANGE * y).space
        changes.append(_energies(near, space, zone) - origin)
    stacks = back.T @ np.tensordot(fit, np.array(changes), 1) @ back  # (monomials, 10, r, r)
    by_energy = stacks.transpose(1, 0, 2, 3)
    return {
        **site,
        "offset_bending": by_energy[:4],
        "offset_membrane": by_energy[4:8],
        "offset_shear": by_energy[8],
        "offset_mass": by_energy[9],
        "offset_range": OFFSET_RANGE,
    }


def padua_points(degree: int) -> list[tuple[float, float]]:
    """Points of a square that determine polynomials of a total degree (Caliari et al., AMC 165, 2005)."""
    x = np.cos(np.pi * np.arange(degree + 1) / degree)
    y = np.cos(np.pi * np.arange(degree + 2) / (degree + 1))
    return [(float(x[i]), float(y[j])) for i in range(x.size) for j in range(y.size) if (i + j) % 2 == 0]


def _site(full: FullPlate) -> Real:
    """Polynomials of `field_basis` at the sensor's declared place, (terms,)."""
    x, y = full.patches[full.moved].center
    xi, zeta = np.array([2.0 * x / full.plate.length_x - 1.0]), np.array([2.0 * y / full.plate.length_y - 1.0])
    return np.array([float(polynomial(d, xi, zeta)[0]) for d in polynomials(BENDING_DEGREE)])


def _zone(full: FullPlate) -> Mask:
    """Elements that change when the sensor moves."""
    mesh = full.space.basis.mesh
    moved = full.moved_by(1e-3 * OFFSET_RANGE, 1e-3 * OFFSET_RANGE).space.basis.mesh
    return np.asarray((mesh.p != moved.p).any(axis=0)[mesh.t].any(axis=0))


def _around(p: Projector, zone: Mask) -> tuple[Projector, Real]:
    """Vectors (n, q) of the leading motions in the zone, and the reduced coordinates' shares in them (q, r)."""
    elastic, inertia = _sums(_energies(p, p.full.space, zone))
    energy = elastic + inertia
    values, basis = np.linalg.eigh(0.5 * (energy + energy.T))
    kept = values > KEPT**2 * values[-1]
    root = np.sqrt(values[kept])
    touched = np.unique(np.asarray(p.full.space.basis.element_dofs)[:, zone])
    rows = np.flatnonzero(np.isin(p.full.unknowns % p.full.space.size, touched))
    cut = replace(p.full, unknowns=p.full.unknowns[rows])
    return Projector(cut, p.vectors[rows] @ (basis[:, kept] / root)), root[:, None] * basis[:, kept].T


def _sums(energies: Real) -> tuple[Real, Real]:
    """Elastic energies for moduli of 1 Pa and nu = 0, and inertia scaled to about their size."""
    elastic = energies[[0, 1, 4, 5, 8]].sum(axis=0) + 0.5 * energies[[3, 7]].sum(axis=0)
    inertia = energies[9]
    return elastic, inertia * np.trace(elastic) / np.trace(inertia)


def _energies(p: Projector, space: ShapeSpace, zone: Mask) -> Real:
    """Energies of the plate over the zone in the order of `NAMES`, as in `effect_projection`, (10, q, q)."""
    h, rho = p.full.plate.thickness, p.full.plate.density
    forms = [plane_form(space, modulus, None, zone) for modulus in MODULI]
    inertia = space.product("0", "0", zone)
    displaced, turned = (sum(p.gram(inertia, k, k) for k in fields) for fields in ((0, 1, 2), ROTATIONS))
    return np.array(
        [
            *(h**3 / 12.0 * p.plane(form, ROTATIONS, ROTATIONS) for form in forms),
            *(h * p.plane(form, IN_PLANE, IN_PLANE) for form in forms),
            SHEAR_FACTOR * h * transverse_shear(p, space, None, zone),
            rho * h * displaced + rho * h**3 / 12.0 * turned,
        ]
    )
