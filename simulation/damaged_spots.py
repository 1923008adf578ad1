"""Round spots of less stiffness, in reduced coordinates.

A spot is smaller than what polynomials over the plate can tell: its energy is summed over the points at which
strains are kept, a point on the rim counting for the part of its cell that lies inside. What the plate does within
a soft spot beyond following its surroundings is not in the coordinates: the effect is right to first order in the
loss.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulation.composition import STEP, Composite
from simulation.effect_operators import EffectOperators
from simulation.laminate import SHEAR_FACTOR
from simulation.plate_state import Disc, PlateState

Real = NDArray[np.float64]
Numbers = NDArray[Any]


def with_spots(ops: EffectOperators, whole: Composite, state: PlateState) -> Composite:
    """Take the stiffness that a state's discs have lost out of a composite."""
    if not state.discs:
        return whole
    plate, loss = _lost(ops, state, np.eye(ops.size))
    return replace(whole, plate=whole.plate - plate, plate_loss=whole.plate_loss - loss)


def spots_slope(ops: EffectOperators, moved: Composite, stepped: PlateState, basis: Real) -> Composite:
    """Add what discs contribute to the derivative by the parameter whose imaginary step gave `stepped`.

    `moved` is in the coordinates whose columns (r, m) are `basis`.
    """
    if not stepped.discs:
        return moved
    plate, loss = (np.imag(part) / STEP for part in _lost(ops, stepped, basis))
    return replace(moved, plate=moved.plate - plate, plate_loss=moved.plate_loss - loss)


def _lost(ops: EffectOperators, state: PlateState, basis: Real) -> tuple[Numbers, Numbers]:
    """Stiffness lost to all discs, real part and imaginary part of the modulus, (m, m) each."""
    temperature = state.mean_temperature
    nu = state.laws.poisson_ratio(temperature)
    c1 = state.laws.youngs_modulus(temperature) / (1.0 - nu**2)
    total: Numbers = np.zeros((basis.shape[1],) * 2)
    for disc in state.discs:
        total = total + disc.loss * _energy(ops, disc, basis, c1 * _moduli(state, nu), 0.5 * c1 * (1.0 - nu))
    return total, state.laws.loss_factor(temperature) * total


def _moduli(state: PlateState, nu: Any) -> Numbers:
    """Q11, Q22, Q12 and Q66 over C1."""
    cross = nu * np.sqrt(state.modulus_x * state.modulus_y)
    return np.array([state.modulus_x, state.modulus_y, cross, 0.5 * (1.0 - nu) * state.in_plane_shear])


def _energy(ops: EffectOperators, disc: Disc, basis: Real, moduli: Numbers, shear: Any) -> Numbers:
    """Strain energy within a disc, (m, m)."""
    share = coverage(ops, disc)
    near = np.flatnonzero(np.real(share))
    weight = ops.cell * share[near]
    h = ops.thickness
    q11, q22, q12, q66 = moduli
    rows = ops.strain[:, near] @ basis
    total: Numbers = np.zeros((basis.shape[1],) * 2)
    for (x, y, xy), factor in (((0, 1, 2), h), ((3, 4, 5), h**3 / 12.0)):
        stress = (q11 * rows[x] + q12 * rows[y], q12 * rows[x] + q22 * rows[y], q66 * rows[xy])
        for strain, force in zip((x, y, xy), stress, strict=True):
            total = total + factor * rows[strain].T @ (weight[:, None] * force)
    for strain in (6, 7):
        total = total + SHEAR_FACTOR * h * shear * rows[strain].T @ (weight[:, None] * rows[strain])
    return total


def coverage(ops: EffectOperators, disc: Disc) -> Numbers:
    """Share of every cell that lies within a disc, (N,), smooth in its place, scaled to the disc's area."""
    place, reach = np.real([disc.x, disc.y]), disc.radius + np.sqrt(ops.cell)
    near = np.flatnonzero((np.abs(ops.strain_points - place) < reach).all(axis=1))
    points = ops.strain_points[near]
    away = np.sqrt((points[:, 0] - disc.x) ** 2 + (points[:, 1] - disc.y) ** 2 + 1e-18)
    depth = (disc.radius - away) / np.sqrt(ops.cell)
    inside = np.real(depth) > 1.0
    outside = np.real(depth) < -1.0
    ramp = 0.5 + 0.75 * depth - 0.25 * depth**3
    share = np.zeros(len(ops.strain_points), depth.dtype)
    share[near] = np.where(inside, 1.0, np.where(outside, 0.0, ramp))
    return np.asarray(share * (np.pi * disc.radius**2 / (ops.cell * share.sum())))
