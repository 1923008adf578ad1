"""A mesh deformed so that one patch has an offset from its declared place."""

import numpy as np

from analysis.arrays import Real
from analysis.geometry.loop import Loop
from analysis.geometry.relations import overlap
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.space import ShapeSpace

LARGEST_REACH = 0.020
"""Largest distance from the patch at which cells are deformed, m."""
RIGID_SHARE = 1.0 / 6.0
"""Largest share of the free distance around the patch that moves rigidly with it or stays fixed, like strips."""
LEAST_ROOM = 0.4
"""Share of the free distance that must remain."""


def moved_space(
    shell: ShellPlate, patch: int, shift: tuple[float, float], larger: tuple[float, float] = (0.0, 0.0)
) -> ShapeSpace:
    """Space over the mesh with one patch moved, or enlarged; functions and their numbers stay.

    Integrals depend smoothly on the shift. Cells under other patches, and their matrices, do not change.

    Parameters
    ----------
    patch : int
        Index among the plate's patches.
    shift : (float, float)
        m.
    larger : (float, float)
        Along its first side and along its second, m.

    Raises
    ------
    ValueError
        For a patch that does not exist, too large a shift, or another patch on the opposite face.
    """
    if not 0 <= patch < len(shell.patches):
        raise ValueError(f"patch {patch} does not exist; the plate has {len(shell.patches)}")
    mesh, plate = shell.space.mesh, shell.plate
    own = shell.patches[patch].loop
    neighbours = [other.loop for k, other in enumerate(shell.patches) if k != patch]
    if any(overlap(own, other) is not None for other in neighbours):
        raise ValueError(f"patch {shell.patches[patch].id!r} lies opposite another one and cannot be moved alone")
    discs = [disc for _, disc in plate.supported_discs().values()]
    walls = [plate.loop, *plate.hole_loops, *plate.zone_loops, *discs]
    others = walls + neighbours
    room = min(float(other.distance(own.polygon).min()) for other in others)
    room = min(room, min(float(own.distance(other.polygon).min()) for other in others))
    if np.hypot(*shift) + max(map(abs, larger)) > (1.0 - LEAST_ROOM) * room:
        raise ValueError(f"patch {shell.patches[patch].id!r} moved by {shift} m has not the room around it")
    rigid = min(RIGID_SHARE * room, plate.thickness)
    near = np.maximum(_outside(own, mesh.points) - rigid, 0.0)
    away = [wall.distance(mesh.points) for wall in walls] + [_outside(other, mesh.points) for other in neighbours]
    far = np.min(away, axis=0)
    far = np.maximum(np.minimum(far - rigid, LARGEST_REACH), 0.0)
    share = np.maximum(0.0, np.minimum(far / np.maximum(near + far, 1e-12), 1.0 - near / LARGEST_REACH))
    share = np.where(near == 0.0, 1.0, share)
    low, high = own.bounds
    angle = np.deg2rad(shell.patches[patch].angle)
    axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    along = (mesh.points - 0.5 * np.add(low, high)) @ axes.T
    stretched = (np.divide(larger, shell.patches[patch].size) * along) @ axes
    moved = shell.space.moved(share[:, None] * (np.asarray(shift) + stretched))
    for here, there in zip(shell.space.groups, moved.groups, strict=True):
        if len(here.dx) and (there.dx < 0.2 * here.dx).any():
            raise ValueError(
                f"patch {shell.patches[patch].id!r} moved by {shift} m leaves no space for the cells around it"
            )
    return moved


def _outside(loop: Loop, points: Real) -> Real:
    """Distance from the inside of a loop, (K,); zero within."""
    return np.where(loop.contains(points), 0.0, loop.distance(points))
