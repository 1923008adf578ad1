"""Projection of the energies of a plate's patches onto given vectors."""

from concurrent.futures import Executor

import numpy as np

from analysis.arrays import Real
from simulation.reduction.effect_operators import BENDING_DEGREE
from simulation.reduction.effect_projection import weight_table
from simulation.reduction.projector import Projector, Rows
from simulation.shell.rigidity import U, V, W
from simulation.shell.shear_factor import SHEAR_FACTOR
from simulation.state.field_basis import polynomials

THICKNESS_STEP = 1e-3
"""Step of central differences by the relative thickness of a patch."""


def patch_energies(p: Projector, executor: Executor, degree: int = BENDING_DEGREE) -> dict[str, Real]:
    """Project the energies of all patches.

    Parameters
    ----------
    executor : Executor
        Works on several patches at a time.
    degree : int
        Largest total degree of the plate's thickness over it.

    Returns
    -------
    dict of str to ndarray
        Stacks ``patch_own``, ``patch_membrane``, ``patch_mass``, ``coupling`` and those of each patch alone of
        `EffectOperators`.
    """
    table, nominal = (
        weight_table(p, polynomials(degree)),
        p.full.shell.space.spread(p.full.shell.thickness),
    )

    def of(place: int) -> tuple[Real, Real, Real, Real]:
        return _one_patch(p, place, table, nominal)

    def thicker(place: int) -> tuple[Real, Real]:
        high, low = (declared_patch(p, place, 1.0 + sign * THICKNESS_STEP) for sign in (1, -1))
        return (high[0] - low[0]) / (2.0 * THICKNESS_STEP), (high[2] - low[2]) / (2.0 * THICKNESS_STEP)

    every = range(len(p.full.shell.patches))
    parts, slopes = list(executor.map(of, every)), list(executor.map(thicker, every))
    r, terms = p.vectors.shape[1], len(table)
    own, membrane, mass, coupling = np.zeros((r, r)), np.zeros((1 + 2 * terms, r, r)), np.zeros((r, r)), []
    for one in parts:
        own, membrane, mass = own + one[0], membrane + one[1], mass + one[2]
        coupling.append(one[3])
    return {
        "patch_own": own + p.vectors.T @ (p.full.supports @ p.vectors),
        "patch_membrane": membrane,
        "patch_mass": mass,
        "patch_alone": np.reshape([one[0] + one[1][0] for one in parts], (len(parts), r, r)),
        "patch_thicker": np.reshape([one[0] for one in slopes], (len(parts), r, r)),
        "patch_mass_alone": np.reshape([one[2] for one in parts], (len(parts), r, r)),
        "thicker_coupling": np.reshape([one[1] for one in slopes], (len(parts), r)),
        "coupling": np.reshape(coupling, (len(parts), 1 + terms, r)).transpose(1, 2, 0),
    }


def declared_patch(p: Projector, place: int, thicker: float = 1.0) -> tuple[Real, Real, Real]:
    """Stiffness, mass and coupling of one patch on the declared plate.

    Parameters
    ----------
    place : int
        Of the patch.
    thicker : float
        Its thickness over the declared one.

    Returns
    -------
    stiffness, mass : (r, r) ndarray
    coupling : (r,) ndarray
    """
    nominal = p.full.shell.space.spread(p.full.shell.thickness)
    own, membrane, mass, coupling = _one_patch(p, place, np.zeros((0, nominal.size)), nominal, thicker)
    return own + membrane[0], mass, coupling[0]


def _one_patch(
    p: Projector, place: int, table: Real, nominal: Real, thicker: float = 1.0
) -> tuple[Real, Real, Real, Real]:
    """Return one patch's terms of `patch_energies`: own, membrane, mass, and its column of the coupling."""
    r, terms, shell = p.vectors.shape[1], len(table), p.full.shell
    patch, covered = shell.patches[place], shell.under[place]
    ceramic, t = shell.materials[patch.material], patch.thickness * thicker
    sign = 1.0 if patch.side == "top" else -1.0
    q11, q12 = ceramic.stiffness
    plane = np.array([[q11, q12, 0.0], [q12, q11, 0.0], [0.0, 0.0, 0.5 * (q11 - q12)]])
    own, mass = np.zeros((r, r)), np.zeros((r, r))
    membrane, coupling = np.zeros((1 + 2 * terms, r, r)), np.zeros((1 + terms, r))
    for rows in p.rows(shell.space, covered):
        dx, h = rows.dx, nominal[rows.points]
        z0, lever = 0.5 * sign * (h + t), 0.5 * sign * h
        bent = rows.strain[3:6]
        flat = rows.strain[:3] + z0[:, None] * bent
        own += t**3 / 12.0 * _form(bent, bent, plane, dx)
        for shear in rows.strain[6:]:
            own += SHEAR_FACTOR * t * plane[2, 2] * shear.T @ (dx[:, None] * shear)
        membrane[0] += t * _form(flat, flat, plane, dx)
        mass += ceramic.density * t * _inertia(rows, z0, t)
        coupling[0] += ceramic.e31 * (flat[0] + flat[1]).T @ dx
        for j in range(terms):
            weight = dx * table[j, rows.points]
            cross = _form(flat, bent, plane, weight * lever)
            membrane[1 + j] += t * (cross + cross.T)
            membrane[1 + terms + j] += t * _form(bent, bent, plane, weight * lever**2)
            coupling[1 + j] += ceramic.e31 * (bent[0] + bent[1]).T @ (weight * lever)
    return own, membrane, mass, coupling


def _form(left: Real, right: Real, plane: Real, weight: Real) -> Real:
    """Energy of two sets of in-plane strains (3, Q, r) for moduli (3, 3) and weights (Q,)."""
    total = np.zeros((left.shape[2], right.shape[2]))
    for a, b in zip(*np.nonzero(plane), strict=True):
        total += plane[a, b] * (left[a].T @ (weight[:, None] * right[b]))
    return total


def _inertia(rows: Rows, height: Real, thickness: float) -> Real:
    """Inertia per area density of a layer whose middle lies `height` (Q,) over the mid-plane."""
    total = np.zeros((rows.motion.shape[2],) * 2)
    for straight, turning in zip((U, V, W), rows.director, strict=False):  # a flat plate's does not move along z
        moving = rows.motion[straight] + height[:, None] * turning
        total += moving.T @ (rows.dx[:, None] * moving)
        total += thickness**2 / 12.0 * turning.T @ (rows.dx[:, None] * turning)
    if len(rows.director) < 3:
        total += rows.motion[W].T @ (rows.dx[:, None] * rows.motion[W])
    return np.asarray(total)
