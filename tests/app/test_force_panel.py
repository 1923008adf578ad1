"""A panel driven by two shakers: the sense of their push, and filters for them."""

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from analysis.focusing.energy import Grid
from analysis.material import MaterialLaws
from app.files.atomic import atomic_hdf5
from app.files.declarations.panel import read_panel
from app.files.hdf5_file import write_value
from app.files.provenance import provenance, stamp
from app.twins.panel_twin import panel_twin
from tests.two_patch_panel import TARGET_AND_FILTERS

Run = Callable[..., tuple[int, str, str]]
PANEL = f"""\
format = "panel/1"
title = "two shakers"
grid = [16, 12]

[plate]
length_x = 0.2
length_y = 0.15
thickness = 0.003
mass = 0.0855
boundary = "clamped"

[[drive]]
id = "below"
point = [0.1, 0.075]
side = "bottom"

[[drive]]
id = "above"
point = [0.06, 0.05]
mass = 0.001

{TARGET_AND_FILTERS}
[twin]
youngs_modulus = [1.8e9, 2.2e9]
poisson_ratio = [0.36, 0.4]
loss_factor = [0.05, 0.09]
basis_tolerance = 1e-2

[illustration]
youngs_modulus = 2e9
poisson_ratio = 0.38
"""


@pytest.fixture
def panel(tmp_path: Path) -> Path:
    path = tmp_path / "panel.toml"
    path.write_text(PANEL, encoding="utf-8")
    return path


def laws() -> MaterialLaws:
    """Constant: 2 GPa, 0.38, 0.07 from 0 to 60 °C."""
    knots = np.concatenate([[0.0] * 4, [60.0] * 4])
    values = np.repeat([[np.log(2e9)], [0.38], [np.log(0.07)]], 4, axis=1)
    return MaterialLaws(knots, values, np.zeros((3, 4, 4)), (0.0, 60.0))


def test_a_push_moves_the_plate_its_way(panel: Path) -> None:
    """Below its first mode a clamped plate follows the force: up from below, down from above."""
    declared = read_panel(panel)
    assert (declared.centers, "patch" in declared.model_dump()) == (((0.1, 0.075), (0.06, 0.05)), True)
    twin = panel_twin(declared, laws(), lambda stage, share: None)
    low = np.array([declared.filters.twin_band[0]])
    field = twin.amplitudes(2e9, 0.38, 0.07, low)[:, 0] @ twin.reduced.deflection.T
    points = Grid.of(declared).points
    for k, sign in enumerate((1.0, -1.0)):
        here = np.hypot(*(points - declared.centers[k]).T).argmin()
        assert sign * field[k, here].real > 0.9 * np.abs(field[k]).max()
    modes = twin.modes(2e9, 0.38, 0.07, 2)
    assert modes.coupling.shape == (2, 2)
    assert np.prod(np.sign(modes.coupling[0])) < 0.0  # the first mode has one sign all over


def test_energies_without_the_fields_are_those_of_the_fields(panel: Path) -> None:
    declared = read_panel(panel)
    twin = panel_twin(declared, laws(), lambda stage, share: None)
    lines = declared.filters.frequency
    found = twin.forms(2e9, 0.38, 0.07, lines, 1e-6)
    expected = twin.space.forms([twin.amplitudes(2e9, 0.38, 0.07, lines)], 1e-6)
    for one, other in ((found.plate, expected.plate), (found.target, expected.target), (found.aim, expected.aim)):
        assert np.abs(one - other).max() < 1e-11 * np.abs(other).max()


def test_filters_for_shakers(panel: Path, tmp_path: Path, run_flexura: Run) -> None:
    run = tmp_path / "run"
    run.mkdir()
    with atomic_hdf5(run / "laws.h5") as file:
        stamp(file, provenance({}))
        file.create_group("updated")
        write_value(file.create_group("laws"), laws())
    status, output, message = run_flexura("focus", run, "--panel", panel, "--json")
    assert status == 0, message
    assert json.loads(output)
    with h5py.File(run / "filters.h5") as file:
        assert file["focusing/filters"].shape[-1] == 2
