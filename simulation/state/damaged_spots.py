"""Round spots of less stiffness, in reduced coordinates.

A spot is smaller than what polynomials over the plate can tell: its energy is summed over the points at which
strains are kept, a point on the rim counting for the part of its cell that lies inside. A soft spot strains more
than its surroundings do. That is not in the coordinates, but known: a round inclusion in a wide uniform strain is
strained uniformly, 1/(1 - s loss) times as much (Eshelby, Proc. R. Soc. A 241, 1957, in plane stress; in bending,
from the continuity of deflection, slope, moment and shear force over the rim).
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulation.reduction.composition import STEP, Composite
from simulation.reduction.effect_operators import EffectOperators
from simulation.shell.rigidity import SHEAR_FACTOR
from simulation.state.plate_state import Disc, PlateState

Real = NDArray[np.float64]
Numbers = NDArray[Any]

WHOLE = 0.95
"""Share of a disc's cells from which it counts as wholly on the plate: its ramp reaches a cell beyond its rim."""


def with_spots(ops: EffectOperators, whole: Composite, state: PlateState) -> Composite:
    """Take the stiffness that a state's discs have lost out of a composite."""
    loss = state.laws.loss_factor(state.mean_temperature)
    for disc in state.discs:
        near, lost = _lost(ops, state, disc)
        energy = _energy(ops, near, np.real(lost), np.eye(ops.size))
        whole = replace(whole, plate=whole.plate - energy, plate_loss=whole.plate_loss - np.real(loss) * energy)
    return whole


def spots_slope(ops: EffectOperators, moved: Composite, stepped: PlateState, basis: Real) -> Composite:
    """Add what discs contribute to the derivative by the parameter whose imaginary step gave `stepped`.

    `moved` is in the coordinates whose columns (r, m) are `basis`.
    """
    loss = stepped.laws.loss_factor(stepped.mean_temperature)
    for disc in stepped.discs:
        near, lost = _lost(ops, stepped, disc)
        plate, plate_loss = (_energy(ops, near, np.imag(part) / STEP, basis) for part in (lost, loss * lost))
        moved = replace(moved, plate=moved.plate - plate, plate_loss=moved.plate_loss - plate_loss)
    return moved


def _lost(ops: EffectOperators, state: PlateState, disc: Disc) -> tuple[NDArray[np.int_], Numbers]:
    """Points within a disc, and the stiffness lost there, (8, 8, points): force by strain, as in `ops.strain`."""
    share = coverage(ops, disc)
    near = np.flatnonzero(np.real(share))
    temperature, h = state.mean_temperature, ops.thickness
    nu = state.laws.poisson_ratio(temperature)
    c1 = state.laws.youngs_modulus(temperature) / (1.0 - nu**2)
    cross = nu * np.sqrt(state.modulus_x * state.modulus_y)
    in_plane = c1 * np.array(
        [
            [state.modulus_x, cross, 0.0],
            [cross, state.modulus_y, 0.0],
            [0.0, 0.0, 0.5 * (1.0 - nu) * state.in_plane_shear],
        ]
    )
    stiffness: Numbers = np.zeros((8, 8), dtype=np.result_type(in_plane, disc.loss))
    even = 0.5 * (1.0 + nu)
    for first, factor, odd in ((0, h, 0.25 * (3.0 - nu)), (3, h**3 / 12.0, 0.25 * (1.0 - nu))):
        more = _amplified(disc.loss, even, odd)
        stiffness[first : first + 3, first : first + 3] = factor * more @ in_plane @ more
    stiffness[6:, 6:] = np.eye(2) * SHEAR_FACTOR * h * 0.5 * c1 * (1.0 - nu) / (1.0 - 0.5 * disc.loss)
    return near, np.multiply.outer(disc.loss * stiffness, ops.cell * share[near])


def _amplified(loss: Any, even: Any, odd: Any) -> Numbers:
    """Root of strains (x, y, xy) in a spot over those around: energy lost is in between the two, (3, 3).

    `even` and `odd` are s of strain that is alike in all directions, and of the rest.
    """
    alike, rest = (1.0 / np.sqrt(1.0 - s * loss) for s in (even, odd))
    mean, half = 0.5 * (alike + rest), 0.5 * (alike - rest)
    return np.array([[mean, half, 0.0], [half, mean, 0.0], [0.0, 0.0, rest]])


def _energy(ops: EffectOperators, near: NDArray[np.int_], stiffness: Real, basis: Real) -> Real:
    """Energy of strains at some points for a stiffness (8, 8, points) there, (m, m)."""
    rows = ops.strain[:, near] @ basis
    force = np.einsum("abp,bpm->apm", stiffness, rows)
    return np.asarray(rows.reshape(-1, basis.shape[1]).T @ force.reshape(-1, basis.shape[1]))


def coverage(ops: EffectOperators, disc: Disc) -> Numbers:
    """Share of every cell that lies within a disc, (N,), smooth in its place, scaled to the disc's area.

    What of a disc lies beside the plate or in a hole is lost.
    """
    place, reach = np.real([disc.x, disc.y]), disc.radius + np.sqrt(ops.cell)
    near = np.flatnonzero((np.abs(ops.strain_points - place) < reach).all(axis=1))
    here = _share(ops.strain_points[near], ops.cell, disc)
    share = np.zeros(len(ops.strain_points), here.dtype)
    share[near] = here
    covered, whole = here.sum(), _share(_lattice(ops, place, reach), ops.cell, disc).sum()
    if np.real(covered) < WHOLE * np.real(whole):
        covered = WHOLE * whole
    return np.asarray(share * (np.pi * disc.radius**2 / (ops.cell * covered)))


def _share(points: Real, cell: float, disc: Disc) -> Numbers:
    """Share of the cells about some points (K, 2) that lies within a disc, (K,)."""
    away = np.sqrt((points[:, 0] - disc.x) ** 2 + (points[:, 1] - disc.y) ** 2 + 1e-18)
    depth = (disc.radius - away) / np.sqrt(cell)
    ramp = 0.5 + 0.75 * depth - 0.25 * depth**3
    return np.asarray(np.where(np.real(depth) > 1.0, 1.0, np.where(np.real(depth) < -1.0, 0.0, ramp)))


def _lattice(ops: EffectOperators, place: Real, reach: float) -> Real:
    """Middles (K, 2) of all cells about a place as if the plate went on there, m."""
    first, axes = ops.strain_points[0], []
    columns = np.unique(np.round(ops.strain_points[:, 0], 9))
    along = float(np.diff(columns).min()) if columns.size > 1 else float(np.sqrt(ops.cell))
    for axis, spacing in enumerate((along, ops.cell / along)):
        low, high = (place[axis] - first[axis] + side * reach for side in (-1.0, 1.0))
        axes.append(first[axis] + spacing * np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1.0))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
