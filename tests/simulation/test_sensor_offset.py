"""Offsets of the sensor: the grid they are fitted on, and where there is no room for them."""

import numpy as np
import pytest

from analysis.experiment import Patch, Plate
from analysis.local_laws import LocalLaws
from simulation.effect_operators import OFFSET_DEGREE, monomials
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.plate_state import PlateState
from simulation.sensor_offset import OFFSET_RANGE, can_move, padua_points
from simulation.shell.factors import factorize
from simulation.state_matrices import FullPlate

RECIPE = MeshRecipe(degree=3, spacing=0.06)


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


def full_plate(*patches: Patch, recipe: MeshRecipe = RECIPE) -> FullPlate:
    plate = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.13)
    model = assemble(plate, patches, recipe=recipe)
    return FullPlate.of(model.space, plate, patches, model.unknowns)


def square(name: str, role: str, center: tuple[float, float], side: str = "top") -> Patch:
    return Patch(id=name, role=role, center=center, size=(0.02, 0.02), thickness=0.0005, side=side)


def test_a_sensor_amid_the_plate_can_move_and_takes_its_elements_along():
    full = full_plate(square("A1", "actuator", (0.2, 0.155)), square("S1", "sensor", (0.04, 0.035)))
    assert can_move(full)
    under = full.under[full.moved]
    moved = full.space.shifted(under, OFFSET_RANGE, -0.001)
    change = moved.centers[:, under] - full.space.centers[:, under]
    np.testing.assert_allclose(change, np.array([[OFFSET_RANGE], [-0.001]]) * np.ones(change.shape[1]))


@pytest.mark.parametrize(
    ("center", "way"), [((0.022, 0.1), (-OFFSET_RANGE, 0.0)), ((0.04, 0.123), (0.0, -OFFSET_RANGE))]
)
def test_all_there_is_between_a_sensor_and_the_next_wall_stretches_alike(center, way):
    """12 mm to the plate's edge or to the next patch, with strips of 2.5 mm in it on either side."""
    full = full_plate(
        square("A1", "actuator", (0.2, 0.155)),
        square("S1", "sensor", center),
        square("S2", "sensor", (0.04, 0.091 if center[0] > 0.03 else 0.04)),
    )
    assert can_move(full)
    before, after = full.space.basis, full.moved_by(*way).space.basis
    area = after.dx.sum(axis=1) / before.dx.sum(axis=1)
    assert area.min() == pytest.approx(1.0 - OFFSET_RANGE / 0.012, rel=1e-6)
    unmoved = np.abs(after.mesh.p - before.mesh.p).max(axis=0)[before.mesh.t].max(axis=0) == 0.0
    assert all(unmoved[under].all() for k, under in enumerate(full.under) if k != full.moved)


def test_a_moved_sensor_answers_as_one_declared_there():
    place, way = (0.04, 0.035), (0.0015, -0.002)
    actuator, recipe = square("A1", "actuator", (0.2, 0.155)), MeshRecipe(degree=6)
    laws = LocalLaws.of_material(2.0e9, 0.38, 0.05)

    def answer(center: tuple[float, float], offset: tuple[float, float]) -> np.ndarray:
        full = full_plate(actuator, square("S1", "sensor", center), recipe=recipe)
        there = full.moved_by(*offset)
        state = PlateState.baseline(*there.sampling, laws, laws.reference, np.array([400.0]))
        matrices = full.matrices(state.with_(offset_x=offset[0], offset_y=offset[1]))
        stiffness = matrices.plate + 1j * matrices.plate_loss + matrices.patches
        found = []
        for frequency in (310.0, 700.0):
            z = stiffness - (2.0 * np.pi * frequency) ** 2 * matrices.mass
            found.append(matrices.coupling[:, 1] @ factorize(z).solve(matrices.coupling[:, 0].astype(complex)))
        return np.array(found)

    wanted = answer((place[0] + way[0], place[1] + way[1]), (0.0, 0.0))
    assert np.abs(answer(place, (0.0, 0.0)) / wanted - 1.0).min() > 0.02
    np.testing.assert_allclose(answer(place, way), wanted, rtol=1e-3)


def test_a_sensor_at_the_edge_cannot_move():
    assert not can_move(full_plate(square("A1", "actuator", (0.2, 0.155)), square("S1", "sensor", (0.01, 0.035))))
