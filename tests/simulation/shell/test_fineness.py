"""How much is kept follows what the plate's material loses."""

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.declaration.plate_material import KINDS
from analysis.experiment import Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.unknowns import factorize

MESH = MeshRecipe(spacing=0.08, grading=0.0, pieces=1)


def test_polypropylene_has_the_tolerance_itself_and_metals_less() -> None:
    fine = Fineness(tolerance=3e-9)
    assert fine.share(KINDS["polypropylene"]) == 3e-9
    assert fine.share(KINDS["aluminium"]) == pytest.approx(3e-9 * 2e-4 * 0.02 / 0.025**2)
    assert Fineness(tolerance=0.0).share(KINDS["steel"]) == 0.0
    assert 0.0 < fine.share(MaterialBox((6e10, 8e10), (0.3, 0.35), (0.0, 0.01))) < 1e-10


def test_resonances_of_a_metal_err_by_less_of_their_width() -> None:
    """Shifts against the plate with all functions, in loss factors: alike for a polymer and a metal."""
    plate = Plate(length_x=0.12, length_y=0.1, thickness=0.003, mass=0.0342)
    force, band = [Footprint((0.1, 0.02), 0.003)], (100.0, 1500.0)
    shift = []
    for loss in ((0.01, 0.09), (0.001, 0.009)):
        box = MaterialBox((2e9, 3e9), (0.34, 0.4), loss)
        some, everything = (
            assemble_for(plate, [], box, band, footprints=force, fineness=Fineness(MESH, 6, tolerance))
            for tolerance in (1e-6, 0.0)
        )
        found, exact = (model.eigenfrequencies(2.4e9, 0.37, 13)[6:] for model in (some, everything))
        shift.append(float(np.max(found / exact - 1.0)))
    assert shift[0] > 2.5 * shift[1] > 0.0


def test_the_driving_point_of_a_sheet_metal_is_the_same_on_another_mesh() -> None:
    """Accelerance with a loss factor of 0.2 % on a rectangle as declared and turned, as share of the rms."""
    corners = np.array([(0.0, 0.0), (0.3, 0.0), (0.3, 0.2), (0.0, 0.2)])
    angle = 0.5
    turn = np.array([(np.cos(angle), np.sin(angle)), (-np.sin(angle), np.cos(angle))])
    box = MaterialBox((60e9, 80e9), (0.28, 0.38), (5e-4, 0.01))
    omega = 2 * np.pi * np.random.default_rng(1).uniform(100.0, 1400.0, 40)
    answers = []
    for matrix in (np.eye(2), turn):
        placed = corners @ matrix
        point = np.array((0.22, 0.13)) @ matrix - placed.min(axis=0)
        outline = {"kind": "polygon", "points": (placed - placed.min(axis=0)).tolist()}
        plate = Plate.model_validate({"outline": outline, "thickness": 0.002, "mass": 0.324})
        tip = [Footprint((float(point[0]), float(point[1])), 0.005)]
        model = assemble_for(plate, [], box, (50.0, 1500.0), footprints=tip)
        force, stiffness = model.footprint_rows(tip)[0], model.stiffness(70e9, 0.33, 0.0022)
        solved = [factorize(stiffness - w**2 * model.mass).solve(force + 0j) for w in omega]
        answers.append(omega**2 * np.array([force @ one for one in solved]))
    straight, turned = answers
    assert np.linalg.norm(turned - straight) < 3e-4 * np.linalg.norm(straight)
