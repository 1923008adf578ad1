"""Offsets of the sensor: the grid they are fitted on, and where there is no room for them."""

import numpy as np
import pytest

from analysis.experiment import Patch, Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.effect_operators import OFFSET_DEGREE, monomials
from simulation.shell.assembly import assemble
from simulation.state.patch_departures import OFFSET_RANGE, can_move, padua_points
from simulation.state.state_matrices import FullPlate


@pytest.mark.parametrize("degree", [2, 4, OFFSET_DEGREE])
def test_padua_points_determine_a_polynomial_of_their_degree(degree):
    points = padua_points(degree)
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    assert len(points) == len(powers)
    vandermonde = np.array([[x**i * y**j for i, j in powers] for x, y in points])
    assert np.linalg.cond(vandermonde) < 300.0
    assert np.abs(points).max() == pytest.approx(1.0)


def test_no_offset_is_no_change():
    assert not monomials(0.0, 0.0).any()
    assert len(monomials(0.0, 0.0)) == len(padua_points(OFFSET_DEGREE)) - 1


def test_fit_through_the_points_returns_the_polynomial():
    rng = np.random.default_rng(4)
    wanted = rng.standard_normal(len(monomials(0.0, 0.0)))
    places = padua_points(OFFSET_DEGREE)
    values = [monomials(x, y) @ wanted for x, y in places]
    fit = np.linalg.pinv(np.array([monomials(x, y) for x, y in places]))
    np.testing.assert_allclose(fit @ values, wanted, atol=1e-11)


def full_plate(*patches: Patch) -> FullPlate:
    plate = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.13)
    return FullPlate.of(assemble(plate, patches, recipe=MeshRecipe(spacing=0.08), degree=2))


def square(name: str, role: str, center: tuple[float, float], side: str = "top") -> Patch:
    return Patch(id=name, role=role, center=center, size=(0.02, 0.02), thickness=0.0005, side=side)


def test_a_sensor_amid_the_plate_can_move_and_takes_its_elements_along():
    full = full_plate(square("A1", "actuator", (0.2, 0.155)), square("S1", "sensor", (0.04, 0.035)))
    assert can_move(full)
    under = full.shell.under[full.moved]
    moved = full.moved_by(OFFSET_RANGE, -0.001).shell.space.mesh
    change = (moved.centers - full.shell.space.mesh.centers)[under]
    np.testing.assert_allclose(change, np.ones((len(change), 1)) * [OFFSET_RANGE, -0.001])


@pytest.mark.parametrize(
    ("center", "way"), [((0.022, 0.1), (-OFFSET_RANGE, 0.0)), ((0.04, 0.123), (0.0, -OFFSET_RANGE))]
)
def test_room_between_a_sensor_and_the_next_wall_is_shared_by_its_cells(center, way):
    """12 mm to the plate's edge or to the next patch: no cell loses half of its area."""
    full = full_plate(
        square("A1", "actuator", (0.2, 0.155)),
        square("S1", "sensor", center),
        square("S2", "sensor", (0.04, 0.091 if center[0] > 0.03 else 0.04)),
    )
    assert can_move(full)
    before, after = full.shell.space, full.moved_by(*way).shell.space
    share = after.dx / before.dx
    assert 1.0 - OFFSET_RANGE / 0.012 > share.min() > 0.5
    stays = np.abs(after.points - before.points).max(axis=1) < 1e-15
    others = [k for k in range(len(full.shell.patches)) if k != full.moved]
    assert all(stays[before.spread(full.shell.under[k])].all() for k in others)
    assert after.dx.sum() == pytest.approx(before.dx.sum(), rel=1e-12)


def test_a_sensor_at_the_edge_cannot_move():
    assert not can_move(full_plate(square("A1", "actuator", (0.2, 0.155)), square("S1", "sensor", (0.01, 0.035))))
