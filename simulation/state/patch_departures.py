"""Change of the matrices where a patch is not at its declared place, and slopes under transducers.

A patch has its centre beside its declared place, or is larger. Its own matrices and those of the cells around it
change: they act on the few motions that these cells can make. Where borders move, the mesh moves with them, as in
`simulation.state.sensor_offset`. Moves are some tenths of a millimetre. To first order the change of a response
needs the response alone, which the vectors represent; the second order would need vectors that follow the moves,
and without them it is ten times too large: responses are linear in the moves, see `simulation.twin.twin`.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from scipy.sparse import csr_matrix

from analysis.arrays import Mask, Real
from analysis.channel import Footprint
from simulation.reduction.effect_projection import declared_patch, weighed_energies
from simulation.reduction.projector import Projector
from simulation.shell.points import footprint_points, footprint_rows
from simulation.shell.rigidity import W
from simulation.state.sensor_offset import Zone, around
from simulation.state.state_matrices import FullPlate

MOVE_STEP = 1e-4
"""Step of the central differences by moves, m."""
WEAKEST_MOTION = 3e-5
"""Motions weaker than this share of the strongest are left out: derivatives by moves are good to 1 or 2 %. A
ceramic is so much stiffer than a plastic plate that with 3e-4 those by its sides were wrong by 12 %."""
KINDS = {"bending": 1, "membrane": 1, "shear": 1, "mass": 1}
WAYS = MOVE_STEP * np.eye(4)
"""Moved along x and y, larger along its first side and along its second, m."""


def patch_departures(p: Projector, executor: Executor) -> dict[str, Real]:
    """Entries ``movable``, ``patch_zone`` and those of moves of `EffectOperators`."""
    return _all_patches(p, [_of_patch(p, patch, executor) for patch in range(len(p.full.shell.patches))])


def patches_as_declared(p: Projector) -> dict[str, Real]:
    """Return the same entries, all zero: of patches that are exactly as declared."""
    return _all_patches(p, [_unmoved(0, p.vectors.shape[1])] * len(p.full.shell.patches))


def _all_patches(p: Projector, found: Sequence[dict[str, Real]]) -> dict[str, Real]:
    most = max((len(one["patch_zone"]) for one in found), default=0)
    empty = _unmoved(0, p.vectors.shape[1])
    names = [name for name in empty if name != "movable"]
    stacks = {name: _stacked([one[name] for one in found], empty[name], most) for name in names}
    return {**stacks, "movable": np.array([float(one["movable"]) for one in found])}


def _of_patch(p: Projector, patch: int, executor: Executor) -> dict[str, Real]:
    """Return one patch's entries, over the q motions of the cells around it."""
    try:
        sides = [
            [p.full.moved_by(sign * x, sign * y, patch, (sign * a, sign * b)) for sign in (1, -1)]
            for x, y, a, b in WAYS.tolist()
        ]
        cells = Zone.of(p.full, patch).elements
    except ValueError:  # no room for it, or another patch on the opposite face
        sides, cells = [], p.full.shell.under[patch]
    near, motions = around(p, cells, executor, WEAKEST_MOTION)
    found = _unmoved(len(motions), p.vectors.shape[1])
    found |= {"patch_zone": motions, "movable": np.array(float(bool(sides)))}

    def slopes(two: Sequence[FullPlate]) -> dict[str, Real]:
        ahead, behind = (_energies(near, one, patch, cells) for one in two)
        return {name: (ahead[name] - behind[name]) / (2.0 * MOVE_STEP) for name in ahead}

    for way, slope in enumerate(executor.map(slopes, sides)):
        for name, value in slope.items():
            found[name][way] = value
    return found


def _energies(near: Projector, full: FullPlate, patch: int, cells: Mask) -> dict[str, Real]:
    """Energies of a plate whose patch has moved, over the cells that are deformed, and those of the patch."""
    here, space = Projector(full, near.vectors), full.shell.space
    found = weighed_energies(here, space, np.ones((1, space.dx.size)), KINDS, cells=cells)
    stiffness, mass, coupling = declared_patch(here, patch)
    return {
        "moved_plane": found["bending"][:, 0] + found["membrane"][:, 0],
        "moved_shear": found["shear"].sum(axis=0)[0],
        "moved_mass": found["mass"][0] + found["rotary"][0] + mass,
        "moved_fixed": stiffness,
        "moved_coupling": coupling,
    }


def _unmoved(q: int, r: int) -> dict[str, Real]:
    """Return one patch's entries, all zero."""
    ways = len(WAYS)
    return {
        "patch_zone": np.zeros((q, r)),
        "moved_plane": np.zeros((ways, 4, q, q)),
        **{name: np.zeros((ways, q, q)) for name in ("moved_shear", "moved_mass", "moved_fixed")},
        "moved_coupling": np.zeros((ways, q)),
        "movable": np.zeros(()),
    }


def _stacked(parts: Sequence[Real], empty: Real, most: int) -> Real:
    """Stack the entries of all patches, of as many motions each: those that a patch lacks are zero."""
    shape = tuple(most if size == 0 else size for size in empty.shape)
    found = np.zeros((len(parts), *shape))
    for row, part in zip(found, parts, strict=True):
        row[tuple(slice(size) for size in part.shape)] = part
    return found


def footprint_slopes(full: FullPlate, footprints: Sequence[Footprint], vectors: Real) -> Real:
    """Differentiate the mean deflection over footprints by their shifts and their areas.

    That over a disc of radius a is w + a**2 lap(w) / 8 at its middle, but for a**4: linear in its area. What it is
    more than the deflection of the middle is the derivative by a share of the area, and a share of -1 is a point.

    Parameters
    ----------
    footprints : sequence of S Footprint
    vectors : (n, r) ndarray

    Returns
    -------
    (3, S, r) ndarray
        Along x and y, 1/m, and by the share.
    """
    middles = [replace(one, radius=0.0) for one in footprints]
    more = footprint_rows(full.shell.space, footprints) - footprint_rows(full.shell.space, middles)
    by_area = full.unknowns.rows(csr_matrix(more), W) @ vectors
    return np.concatenate([shift_slopes(full, footprints, vectors), by_area[None]])


def shift_slopes(full: FullPlate, footprints: Sequence[Footprint], vectors: Real) -> Real:
    """Differentiate the mean deflection over footprints by their shifts.

    Parameters
    ----------
    footprints : sequence of S Footprint
    vectors : (n, r) ndarray

    Returns
    -------
    (2, S, r) ndarray
        Along x and y, 1/m.
    """
    points, average = footprint_points(footprints)
    rows = (full.unknowns.rows(csr_matrix(average @ one), W) for one in full.shell.space.slopes(points))
    return np.array([one @ vectors for one in rows]).reshape(2, len(footprints), vectors.shape[1])
