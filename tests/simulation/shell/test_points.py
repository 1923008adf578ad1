"""Springs at points: matrices of rank one, checked against what the plate does without them."""

import numpy as np
import pytest
import scipy.linalg

from analysis.channel import Footprint
from analysis.experiment import Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.points import footprint_points
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize
from tests.simulation.verification.exact_plates import ExactDisc

E, NU = 2e9, 0.35
POINT, RADIUS, STIFFNESS = (0.05, 0.04), 0.002, 3e3


def model(*supports: dict) -> ShellModel:
    plate = Plate(length_x=0.2, length_y=0.15, thickness=0.004, mass=0.12, support=supports)
    return assemble(plate, recipe=MeshRecipe(spacing=0.15, edge_strip=3.0, growth=2.0, grading=0.0), degree=3)


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


def test_frequencies_on_a_spring_are_zeros_of_the_modal_sum() -> None:
    """1 + k sum of phi(p)**2 / (w_i**2 - w**2) over all modes of the free plate, phi of mass one.

    The eigenvalues span sixteen decades because of the small cells at the disc.
    """
    held = model({"kind": "elastic", "point": POINT, "radius": RADIUS, "stiffness": STIFFNESS})
    free = held.stiffness(E, NU) - held.stiffness_patch  # the spring is all that is held
    squares, shapes = scipy.linalg.eigh(free.toarray(), held.mass.toarray())
    disc = held.space.mesh.inside["support 1"]
    mean = held.unknowns.vector({2: held.space.moments("0", None, disc) / (np.pi * RADIUS**2)})
    squares_held = scipy.linalg.eigh(held.stiffness(E, NU).toarray(), held.mass.toarray(), eigvals_only=True)
    elastic = squares_held[squares_held > 1.0][:8]
    assert squares[6] < elastic[-1] < squares[14]
    for square in elastic:
        assert 1.0 + (STIFFNESS * (mean @ shapes) ** 2 / (squares - square)).sum() == pytest.approx(0.0, abs=5e-3)


def test_on_a_soft_spring_in_the_middle_a_plate_heaves() -> None:
    held = model({"kind": "elastic", "point": (0.1, 0.075), "radius": RADIUS, "stiffness": 100.0})
    squares = scipy.linalg.eigh(held.stiffness(E, NU).toarray(), held.mass.toarray(), eigvals_only=True)
    assert squares[5] == pytest.approx(100.0 / 0.12, rel=2e-3)
    assert np.abs(squares[:5]).max() < 3e-3 * squares[5]


def test_a_simple_support_at_a_point_holds_it() -> None:
    held = model({"kind": "soft-simple", "point": POINT, "radius": RADIUS})
    _, shapes = scipy.linalg.eigh(held.stiffness(E, NU).toarray(), held.mass.toarray(), subset_by_index=[0, 11])
    disc = held.space.mesh.inside["support 1"]
    mean = held.unknowns.vector({2: held.space.moments("0", None, disc) / (np.pi * RADIUS**2)})
    largest = np.abs(shapes[held.unknowns.number[2][held.unknowns.number[2] >= 0]]).max()
    assert np.abs(mean @ shapes).max() < 2e-3 * largest


def test_a_disc_clamped_in_its_middle_is_an_annulus_clamped_inside() -> None:
    """Exact Mindlin annulus, b/a = 0.04; means over a disc within larger cells gave half of some frequencies."""
    disc = {"kind": "circle", "center": (0.0, 0.0), "radius": 0.1}
    support = {"kind": "clamped", "point": (0.0, 0.0), "radius": 0.004}
    plate = Plate(outline=disc, thickness=0.005, mass=0.15, support=(support,))
    found = assemble(plate, degree=7).eigenfrequencies(E, NU, 10)
    exact = ExactDisc(0.05, NU, "free", 0.04, "clamped").lowest(8)
    rigidity = E * 0.005**3 / (12.0 * (1.0 - NU**2))
    unit = np.sqrt(rigidity / (plate.density * 0.005)) / (2.0 * np.pi * 0.1**2)
    # two rotations and one twist within the plane are among those found
    nearest = np.abs(found[:, None] / unit - exact).argmin(axis=0)
    assert found[nearest] / unit == pytest.approx(exact, rel=1e-4)


def test_functions_are_chosen_for_the_forces_of_point_supports_too() -> None:
    """They used to be chosen for drives and sensors alone: 0.5 % of a response was lost, and not reported."""
    points = ((0.02, 0.13), (0.17, 0.02), (0.1, 0.02))
    supports = [{"kind": "soft-simple", "point": point} for point in points]
    plate = Plate(length_x=0.2, length_y=0.15, thickness=0.003, mass=0.0855, support=supports)
    box, drive = MaterialBox((1e9, 4e9), (0.3, 0.45), (0.01, 0.1)), Footprint((0.06, 0.1), 0.002)
    fine = Fineness(mesh=MeshRecipe(spacing=0.06, growth=2.0), degree=6)
    chosen = assemble_for(plate, (), box, (100.0, 900.0), footprints=[drive], fineness=fine)
    whole = assemble(plate, recipe=fine.mesh, degree=fine.degree)
    for frequency in (230.0, 640.0):
        answers = []
        for one in (chosen, whole):
            row = one.footprint_rows([drive])[0]
            dynamic = one.stiffness(2e9, NU, 0.06) - (2 * np.pi * frequency) ** 2 * one.mass
            answers.append(row @ factorize(dynamic).solve(row.astype(complex)))
        assert abs(answers[0] - answers[1]) < 1e-3 * abs(answers[1])
