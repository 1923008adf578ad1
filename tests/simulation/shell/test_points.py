"""Springs at points: matrices of rank one, checked against what the plate does without them."""

import numpy as np
import pytest
import scipy.linalg

from analysis.channel import Footprint
from analysis.experiment import Plate
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.assembly import assemble
from simulation.shell.footprints import footprint_points
from simulation.shell.shell_model import ShellModel

E, NU = 2e9, 0.35
POINT, RADIUS, STIFFNESS = (0.05, 0.04), 0.002, 3e3


def model(*supports: dict) -> ShellModel:
    plate = Plate(length_x=0.2, length_y=0.15, thickness=0.004, mass=0.12, support=supports)
    return assemble(plate, recipe=MeshRecipe(spacing=0.15, edge_strip=3.0, growth=2.0, grading=0.0), degree=3)


@pytest.fixture(scope="module")
def free() -> ShellModel:
    return model()


def test_a_mean_over_a_disc_is_exact_to_degree_five() -> None:
    """Of x**2 about the middle r**2/4, of x**4 r**4/8, of x**2 y**2 r**4/24; odd powers vanish."""
    points, average = footprint_points([Footprint(POINT, RADIUS), Footprint((0.1, 0.1), 0.0)])
    assert average.sum(axis=1) == pytest.approx(np.ones(2))
    x, y = ((points - POINT) / RADIUS).T
    for (i, j), mean in {
        (2, 0): 1 / 4,
        (0, 2): 1 / 4,
        (4, 0): 1 / 8,
        (2, 2): 1 / 24,
        (3, 2): 0,
        (1, 0): 0,
    }.items():
        assert average[0] @ (x**i * y**j) == pytest.approx(mean, abs=1e-12)
    assert average[1] @ points == pytest.approx([0.1, 0.1])


def test_frequencies_on_a_spring_are_zeros_of_the_modal_sum(free: ShellModel) -> None:
    """1 + k sum of phi(p)**2 / (w_i**2 - w**2) over all modes of the free plate, phi of mass one."""
    squares, shapes = scipy.linalg.eigh(free.stiffness(E, NU).toarray(), free.mass.toarray())
    there = (free.footprint_rows([Footprint(POINT, RADIUS)]) @ shapes)[0]
    held = model({"kind": "elastic", "point": POINT, "radius": RADIUS, "stiffness": STIFFNESS})
    squares_held = scipy.linalg.eigh(held.stiffness(E, NU).toarray(), held.mass.toarray(), eigvals_only=True)
    elastic = squares_held[squares_held > 1.0][:8]
    assert squares[6] < elastic[-1] < squares[14]
    for square in elastic:
        assert 1.0 + (STIFFNESS * there**2 / (squares - square)).sum() == pytest.approx(0.0, abs=1e-4)


def test_on_a_soft_spring_in_the_middle_a_plate_heaves() -> None:
    held = model({"kind": "elastic", "point": (0.1, 0.075), "radius": RADIUS, "stiffness": 10.0})
    squares = scipy.linalg.eigh(held.stiffness(E, NU).toarray(), held.mass.toarray(), eigvals_only=True)
    assert squares[5] == pytest.approx(10.0 / 0.12, rel=1e-3)
    assert np.abs(squares[:5]).max() < 1e-3 * squares[5]


def test_a_support_at_a_point_holds_it(free: ShellModel) -> None:
    """The stiffer of both ways leaves the spot at rest: its share in the lowest modes is nearly nothing."""
    for kind, rows in (("soft-simple", (2,)), ("clamped", (2, 3, 4))):
        held = model({"kind": kind, "point": POINT, "radius": RADIUS})
        _, shapes = scipy.linalg.eigh(
            held.stiffness(E, NU).toarray(), held.mass.toarray(), subset_by_index=[0, 11]
        )
        points, average = footprint_points([Footprint(POINT, RADIUS)])
        mean = average @ held.space.values(points).toarray()
        w = free.footprint_rows([Footprint(POINT, RADIUS)])[0]
        largest = np.abs(shapes[held.unknowns.number[2][held.unknowns.number[2] >= 0]]).max()
        assert np.abs(w @ shapes).max() < 2e-3 * largest
        for field in rows[1:]:
            turn = held.unknowns.vector({field: mean[0]})
            assert np.abs(turn @ shapes).max() < 0.05 * np.abs(shapes[held.unknowns.number[field]]).max()
