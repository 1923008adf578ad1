"""How much is kept follows what the plate's material loses."""

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.experiment import Plate
from analysis.material import MaterialBox
from analysis.material_kinds import KINDS
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness

MESH = MeshRecipe(spacing=0.08, grading=0.0, pieces=1)


def test_polypropylene_has_the_tolerance_itself_and_metals_less() -> None:
    fine = Fineness(tolerance=3e-9)
    assert fine.share(KINDS["polypropylene"]) == 3e-9
    assert fine.share(KINDS["aluminium"]) == pytest.approx(3e-9 * np.sqrt(2e-4 * 0.02) / 0.025)
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
