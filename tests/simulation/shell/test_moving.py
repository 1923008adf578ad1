"""A mesh that stretches so that a patch sits beside its place."""

import numpy as np
import pytest

from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.shell_plate import ShellPlate
from simulation.state.state_matrices import moved_space

SHIFT = (0.002, -0.0015)


def shell(*more: Patch, sensor: tuple[float, float] = (0.05, 0.05), **plate) -> ShellPlate:
    patches = [
        Patch(id="A", role="actuator", center=(0.1, 0.06), size=(0.02, 0.02), thickness=0.0005),
        Patch(id="S", role="sensor", center=sensor, size=(0.02, 0.015), thickness=0.0005),
        *more,
    ]
    declared = Plate(length_x=0.15, length_y=0.12, thickness=0.003, mass=0.0513, **plate)
    return ShellPlate.of(declared, patches, recipe=MeshRecipe(spacing=0.06, grading=0.0), degree=2)


@pytest.fixture(scope="module")
def still() -> ShellPlate:
    return shell()


def test_what_is_under_the_patch_moves_along_and_keeps_its_shape(still: ShellPlate) -> None:
    moved = moved_space(still, 1, SHIFT)
    here = still.space.spread(still.under[1])
    np.testing.assert_allclose(moved.points[here] - still.space.points[here], np.tile(SHIFT, (here.sum(), 1)))
    np.testing.assert_allclose(moved.dx[here], still.space.dx[here], rtol=1e-12)


def test_outline_other_patches_and_all_that_is_far_stay(still: ShellPlate) -> None:
    moved = moved_space(still, 1, SHIFT)
    edge = np.unique(still.space.mesh.edges[still.space.mesh.borders["outline"].edge])
    assert np.array_equal(moved.mesh.points[edge], still.space.mesh.points[edge])
    other = still.space.spread(still.under[0])
    assert np.array_equal(moved.points[other], still.space.points[other])
    assert moved.dx.sum() == pytest.approx(still.space.dx.sum(), rel=1e-12)
    far = np.hypot(*(still.space.mesh.points - (0.05, 0.05)).T) > 0.05
    assert np.array_equal(moved.mesh.points[far], still.space.mesh.points[far])


def test_integrals_follow_the_shift_smoothly(still: ShellPlate) -> None:
    """Points move in proportion to it: areas are quadratic in the shift."""
    areas = [moved_space(still, 1, (s * SHIFT[0], s * SHIFT[1])).dx for s in (-1.0, -0.5, 0.0, 0.5, 1.0)]
    third = areas[0] - 2 * areas[1] + 2 * areas[3] - areas[4]
    assert np.abs(third).max() < 1e-12 * areas[2].max()


def test_where_there_is_no_room_it_is_said() -> None:
    with pytest.raises(ValueError, match=r"'S' moved by .* has not the room around it"):
        moved_space(shell(sensor=(0.014, 0.05)), 1, (-0.003, 0.0))
    hole = {"kind": "circle", "center": (0.05, 0.07), "radius": 0.008}
    with pytest.raises(ValueError, match="has not the room around it"):
        moved_space(shell(hole=(hole,)), 1, (0.0, 0.003))


def test_over_a_patch_on_the_other_face_it_cannot_move() -> None:
    """Its own matrices would stay, but not those of the one below."""
    below = Patch(id="B", role="sensor", center=(0.05, 0.05), size=(0.04, 0.04), thickness=0.0005, side="bottom")
    with pytest.raises(ValueError, match="'S' lies opposite another one"):
        moved_space(shell(below), 1, (0.001, 0.0))


def test_a_plate_without_patches_has_nothing_to_move() -> None:
    bare = Plate(length_x=0.15, length_y=0.12, thickness=0.003, mass=0.0513)
    with pytest.raises(ValueError, match="patch 0 does not exist; the plate has 0"):
        moved_space(ShellPlate.of(bare, recipe=MeshRecipe(spacing=0.1), degree=2), 0, (0.001, 0.0))
