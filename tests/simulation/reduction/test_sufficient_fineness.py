"""A free L of aluminium, driven by a hammer: refused with the usual mesh, exact enough with a finer one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.arrays import Complex
from analysis.channel import Footprint
from analysis.declaration.plate_material import KINDS
from analysis.experiment import Plate
from analysis.gap.data.noise import NumericalFloor, allowed_error
from simulation.reduction import sufficient_fineness as module
from simulation.reduction.effect_operators import truncation_error
from simulation.reduction.sufficient_fineness import RequiredError, sufficient_fineness
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.shell_model import ShellModel
from simulation.shell.unknowns import factorize

CORNERS = [[0.0, 0.0], [0.40, 0.0], [0.40, 0.14], [0.18, 0.14], [0.18, 0.30], [0.0, 0.30]]
HOLE = {"kind": "circle", "center": [0.30, 0.07], "radius": 0.03}
PLATE = Plate.model_validate(
    {
        "outline": {"kind": "polygon", "points": CORNERS},
        "hole": [HOLE],
        "thickness": 0.004,
        "mass": 0.885,
        "material": {"kind": "aluminium"},
    }
)
BOX, BAND, LOSS = KINDS["aluminium"], (80.0, 1200.0), 0.002
POINTS = [Footprint(point, 0.004) for point in ((0.03, 0.04), (0.15, 0.27), (0.37, 0.11))]
NOISE = 0.004
RESONANCES = np.array([105.452, 223.502, 377.268, 658.571, 837.307, 1174.290])
"""Hz, of E 70 GPa and nu 0.33."""
ASKED: dict[str, Any] = {"plate": PLATE, "patches": [], "box": BOX, "band": BAND, "footprints": POINTS}


@pytest.fixture(scope="module")
def usual() -> ShellModel:
    return assemble_for(**ASKED)


def accelerances(model: ShellModel) -> Complex:
    """Between the force and the other two points, on both flanks of six resonances, (2, 12)."""
    rows = model.footprint_rows(POINTS)
    stiffness = model.stiffness(70e9, 0.33, LOSS)
    found = []
    for frequency in np.outer(RESONANCES, 1.0 + 0.5 * LOSS * np.array([-1.0, 1.0])).ravel():
        omega2 = (2 * np.pi * frequency) ** 2
        found.append(-omega2 * rows[1:] @ factorize(stiffness - omega2 * model.mass).solve(rows[0] + 0j))
    return np.array(found).T


@pytest.mark.slow
def test_a_refused_plate_gets_the_mesh_that_it_needs(usual: ShellModel) -> None:
    with pytest.raises(ValueError, match="finer mesh"):
        NumericalFloor(truncation_error(usual.dropped, LOSS), NOISE)
    fine = sufficient_fineness(**ASKED, required=RequiredError(allowed_error(NOISE), LOSS))
    assert fine is not None
    model = assemble_for(**ASKED, fineness=fine)
    NumericalFloor(truncation_error(model.dropped, LOSS), NOISE)
    assert fine.mesh is not None
    finest = Fineness(replace(fine.mesh, spacing=0.6 * fine.mesh.spacing), 8, 1e-10)
    exact = accelerances(assemble_for(**ASKED, fineness=finest))
    before, after = (np.linalg.norm(accelerances(one) - exact) / np.linalg.norm(exact) for one in (usual, model))
    assert after < 0.3 * before
    assert after < allowed_error(NOISE) < before


def test_the_bound_of_the_cost_is_kept(monkeypatch: pytest.MonkeyPatch, usual: ShellModel) -> None:
    monkeypatch.setattr(module, "MOST_UNKNOWNS", usual.size)
    assert sufficient_fineness(**ASKED, required=RequiredError(allowed_error(NOISE), LOSS)) is None


def test_the_requirement_counts_truncation_and_reduction() -> None:
    required = RequiredError(1e-3, 0.01)
    assert required.met(4e-6, 1e-4)
    assert not required.met(4e-6, 3e-4)
    assert not required.met(5e-6, 1e-4)
    with pytest.raises(ValueError, match="above 0"):
        RequiredError(0.0, 0.01)
