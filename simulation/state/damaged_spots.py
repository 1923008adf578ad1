"""Round spots of reduced stiffness, in reduced coordinates.

A spot is smaller than polynomials over the plate resolve: its energy is summed over the points at which strains
are stored; a point at the rim counts with the part of its cell inside. The strain in a soft spot is larger than
around it. The coordinates do not represent this, but it is known: the strain of a round inclusion in a wide
uniform strain is uniform, (1 - loss P q)**-1 times as large (Eshelby, Proc. R. Soc. A 241, 1957). For a disc in a
sheet of any stiffness q, P is the mean over all directions of the compliance to a plane wave (Mura, Micromechanics
of Defects in Solids, 1987, section 11, in the plane; likewise in bending). All quantities are in the sheet's own
axes.
"""

from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Numbers, Real
from simulation.reduction.composition import COMPLEX_STEP, Composite
from simulation.reduction.effect_operators import EffectOperators
from simulation.shell.rigidity import SHEAR_FACTOR
from simulation.state.plate_state import Disc, PlateState

ANGLES = np.arange(96) * (np.pi / 96)
"""Directions in the plane, rad."""
WHOLE_DISC_SHARE = 0.95
"""Share of a disc's cells from which it counts as wholly on the plate: its ramp ends one cell outside its rim."""


def with_spots(ops: EffectOperators, whole: Composite, state: PlateState) -> Composite:
    """Subtract the stiffness lost in a state's discs from a composite.

    Parameters
    ----------
    whole : Composite
        Without discs, in all r coordinates.
    """
    if not state.discs:
        return whole
    sheet = _Sheet.of(ops, state)
    for disc in state.discs:
        near, area = _within(ops, disc)
        lost, lossy = (np.real(one) for one in sheet.lost(disc))
        rows, area = ops.strain[:, near], np.real(area)
        plate, plate_loss = _energy(rows, lost, area), _energy(rows, lossy, area)
        whole = replace(whole, plate=whole.plate - plate, plate_loss=whole.plate_loss - plate_loss)
    return whole


def spots_slope(ops: EffectOperators, moved: Composite, stepped: PlateState, basis: Real) -> Composite:
    """Add the contribution of discs to a derivative of the composite.

    Parameters
    ----------
    moved : Composite
        The derivative without discs, in the coordinates of `basis`.
    stepped : PlateState
        The state with an imaginary step of the parameter.
    basis : (r, m) ndarray
        Columns that span the coordinates.
    """
    if not stepped.discs:
        return moved
    sheet = _Sheet.of(ops, stepped)
    sheet_steps = _steps(sheet)
    for disc in stepped.discs:
        if not (sheet_steps or _steps(disc)):  # most parameters leave spots as they are
            continue
        near, area = _within(ops, disc)
        both = sheet.lost(disc)
        rows = ops.strain[:, near] @ basis
        plate, plate_loss = (
            _energy(rows, np.imag(one) / COMPLEX_STEP, area.real)
            + _energy(rows, one.real, np.imag(area) / COMPLEX_STEP)
            for one in both
        )
        moved = replace(moved, plate=moved.plate - plate, plate_loss=moved.plate_loss - plate_loss)
    return moved


@dataclass(frozen=True)
class _Sheet:
    """The sheet in which spots lie.

    Attributes
    ----------
    in_plane : (3, 3) ndarray
        Stiffness by strains x, y, xy, over `modulus`.
    across : (2, 2) ndarray
        Transverse shear stiffness, over that of an isotropic sheet.
    modulus : number
        Plane-stress modulus E/(1 - nu2), Pa.
    poisson_ratio : number
    losses : (8,) ndarray
        Root of the loss factor of each strain of `EffectOperators.strain`.
    thickness : float
        m.
    """

    in_plane: Numbers
    across: Numbers
    modulus: Any
    poisson_ratio: Any
    losses: Numbers
    thickness: float

    @classmethod
    def of(cls, ops: EffectOperators, state: PlateState) -> Self:
        """Return that of a state, at its mean temperature."""
        temperature, away = state.mean_temperature, state.departures
        nu = state.laws.poisson_ratio(temperature)
        x, y, shear = ops.sheet * [
            state.modulus_x * away.modulus_x,
            state.modulus_y * away.modulus_y,
            state.in_plane_shear * away.in_plane_shear,
        ]
        cross = nu * np.sqrt(x * y)
        in_plane = np.array([[x, cross, 0.0], [cross, y, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu) * shear]])
        modulus = state.laws.youngs_modulus(temperature) / (1.0 - nu**2)
        roots = np.sqrt(
            np.array([away.loss_x, away.loss_y, away.loss_shear]) * state.laws.loss_factor(temperature)
        )
        losses = np.concatenate([roots, roots, roots[[2, 2]]])
        return cls(in_plane, np.diag([away.shear_x, away.shear_y]), modulus, nu, losses, ops.thickness)

    def lost(self, disc: Disc) -> tuple[Numbers, Numbers]:
        """Return both parts of the complex stiffness lost in a disc, (8, 8): force by strain, per area.

        The energy lost is loss u'Qu, where one strain u is that around the disc, the other that in it.
        """
        h, q = self.thickness, self.in_plane
        kind = np.result_type(q, self.modulus, disc.loss, self.across)
        stiffness: Numbers = np.zeros((8, 8), dtype=kind)
        for first, factor, yielding in ((0, h, in_plane_yielding(q)), (3, h**3 / 12.0, bending_yielding(q))):
            held = np.linalg.solve(np.eye(3) - disc.loss * q @ yielding, q)
            stiffness[first : first + 3, first : first + 3] = factor * self.modulus * held
        shear = 0.5 * self.modulus * (1.0 - self.poisson_ratio)
        stiffness[6:, 6:] = self.across * SHEAR_FACTOR * h * shear / (1.0 - 0.5 * disc.loss)
        lost = np.asarray(disc.loss * stiffness)
        return lost, np.asarray(self.losses[:, None] * self.losses * lost)


def _steps(of: Disc | _Sheet) -> bool:
    """Whether a value of it has an imaginary step."""
    return any(np.iscomplexobj(getattr(of, field.name)) for field in fields(of))


def in_plane_yielding(q: Numbers) -> Numbers:
    """Strains (x, y, xy) of a disc per stress that it has lost, in a wide sheet of stiffness q, (3, 3), 1/Pa."""
    c, s, zero = np.cos(ANGLES), np.sin(ANGLES), np.zeros_like(ANGLES)
    # strains of displacements that vary along each direction, (directions, 2, 3)
    along = np.array([[c, zero, s], [zero, s, c]]).transpose(2, 0, 1)
    held = np.linalg.solve(along @ q @ along.transpose(0, 2, 1), along)
    return np.asarray((along.transpose(0, 2, 1) @ held).mean(axis=0))


def bending_yielding(q: Numbers) -> Numbers:
    """Likewise curvatures of a disc in a wide thin plate, whose deflection varies along each direction, (3, 3)."""
    c, s = np.cos(ANGLES), np.sin(ANGLES)
    along = np.array([c * c, s * s, 2.0 * c * s])
    return np.asarray((along / (along * (q @ along)).sum(axis=0)) @ along.T / ANGLES.size)


def _energy(rows: Real, stiffness: Real, area: Real) -> Real:
    """Energy of strains `rows` (8, points, m) for one stiffness (8, 8) over areas (points,), (m, m)."""
    if not (stiffness.any() and area.any()):
        return np.zeros((rows.shape[2],) * 2)
    force = np.tensordot(stiffness, rows, 1) * area[:, None]
    return np.asarray(rows.reshape(-1, rows.shape[2]).T @ force.reshape(-1, rows.shape[2]))


def _within(ops: EffectOperators, disc: Disc) -> tuple[NDArray[np.int_], Numbers]:
    """Points (K,) whose cells lie within a disc, at least in part, and their areas there (K,), m2."""
    share = coverage(ops, disc)
    near = np.flatnonzero(np.real(share))
    return near, ops.cell * share[near]


def coverage(ops: EffectOperators, disc: Disc) -> Numbers:
    """Share of every cell within a disc, (N,), a smooth function of its position, scaled to the disc's area.

    The part of a disc outside the plate or in a hole is ignored.
    """
    place, reach = np.real([disc.x, disc.y]), float(np.real(disc.radius)) + np.sqrt(ops.cell)
    near = np.flatnonzero((np.abs(ops.strain_points - place) < reach).all(axis=1))
    here = _share(ops.strain_points[near], ops.cell, disc)
    share = np.zeros(len(ops.strain_points), here.dtype)
    share[near] = here
    covered, whole = here.sum(), _share(_lattice(ops, place, reach), ops.cell, disc).sum()
    if np.real(covered) < WHOLE_DISC_SHARE * np.real(whole):
        covered = WHOLE_DISC_SHARE * whole
    return np.asarray(share * (np.pi * disc.radius**2 / (ops.cell * covered)))


def _share(points: Real, cell: float, disc: Disc) -> Numbers:
    """Share of the cells about some points (K, 2) that lies within a disc, (K,)."""
    away = np.sqrt((points[:, 0] - disc.x) ** 2 + (points[:, 1] - disc.y) ** 2 + 1e-18)
    depth = (disc.radius - away) / np.sqrt(cell)
    ramp = 0.5 + 0.75 * depth - 0.25 * depth**3
    return np.asarray(np.where(np.real(depth) > 1.0, 1.0, np.where(np.real(depth) < -1.0, 0.0, ramp)))


def _lattice(ops: EffectOperators, place: Real, reach: float) -> Real:
    """Middles (K, 2) of all cells about a place, including cells outside the plate, m."""
    first, axes = ops.strain_points[0], []
    columns = np.unique(np.round(ops.strain_points[:, 0], 9))
    along = float(np.diff(columns).min()) if columns.size > 1 else float(np.sqrt(ops.cell))
    for axis, spacing in enumerate((along, ops.cell / along)):
        low, high = (place[axis] - first[axis] + side * reach for side in (-1.0, 1.0))
        axes.append(first[axis] + spacing * np.arange(np.ceil(low / spacing), np.floor(high / spacing) + 1.0))
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
