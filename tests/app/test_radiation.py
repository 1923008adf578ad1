"""``flexura radiation``, and aims at sound through focus, compensate and export, on a small panel."""

import json

import h5py
import numpy as np
import pytest

import flexura
from analysis.focusing.measured import MeasuredTransfers
from analysis.focusing.panel_model import responses
from analysis.radiation.radiator import Radiator
from app.files.declarations.panel import read_panel
from app.files.provenance import read_stamp
from app.files.results.panel_files import load_compensation, load_focusing, load_radiation
from app.files.results.transfers_file import write_transfers
from app.report.written import part_of
from app.twins.panel_twin import panel_twin
from tests.app.test_focus_compensate import flex, laws, silent, write_laws
from tests.two_patch_panel import PANEL, TARGET_AND_FILTERS

SOUND = """
[sound]
level = -6.0

[[sound.listener]]
name = "ear"
position = [0.12, 0.095, 0.8]
"""


@pytest.fixture
def panel(tmp_path):
    path = tmp_path / "panel.toml"
    path.write_text(
        PANEL.replace("edges = [60.0, 360.0]", 'edges = [60.0, 360.0]\naim = "listeners"') + SOUND, "utf-8"
    )
    return path


@pytest.fixture
def run(tmp_path):
    return write_laws(tmp_path / "run", laws())


@pytest.mark.slow
def test_focus_for_a_listener_and_what_it_hears(run, panel):
    words = ["--temperature", 0, "--temperature", 20, "--temperature", 60]
    done = flex("focus", run, "--panel", panel, *words)
    assert done.exit_code == 0, done.output
    result = flex("radiation", run, "--json", "--picture")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    declared, found = load_radiation(run / "radiation.h5")
    assert declared == read_panel(panel)
    assert printed["aim"] == "listeners"
    assert printed["listeners"] == [
        {"name": "ear", "position_m": [0.12, 0.095, 0.8], "zone": "", "played_to": True}
    ]
    assert printed["temperatures_c"] == [0.0, 20.0, 60.0]
    assert printed["following"]["ripple_db"] == pytest.approx(found.ripple(found.following).tolist())
    assert max(printed["following"]["ripple_db"]) < 1.0 < max(printed["kept"]["ripple_db"])
    assert printed["following"]["level_db"] == pytest.approx([0.0] * 3, abs=0.5)
    assert printed["following"]["acoustic_contrast_db"] == [None] * 3
    assert "third-octave ripple up to ±" in result.stderr
    assert (run / "radiation.png").is_file()
    with h5py.File(run / "radiation.h5") as file:
        assert set(read_stamp(file)["inputs"]) == {"filters.h5", "laws.h5"}
    heard = flexura.radiation(run, out=run.parent / "library")
    assert heard.record() | {"seconds": 0.0} == printed | {"seconds": 0.0}
    assert flexura.plot(heard).axes
    shown = flex("radiation", run)
    assert "sound at ear, baffle; aim: listeners" in shown.stdout
    items, _ = part_of(run, "radiation.h5")
    assert [item.name for item in items if hasattr(item, "figure")] == ["levels", "powers", "polar"]


def test_the_same_filters_heard_elsewhere_and_in_a_box(run, panel, tmp_path):
    flex("focus", run, "--panel", panel, "--temperature", 20)
    other = tmp_path / "other.toml"
    text = (
        panel.read_text("utf-8")
        .replace("0.095, 0.8]", "0.095, 1.6]")
        .replace("[sound]", '[sound]\nmounting = "box"')
    )
    other.write_text(text, "utf-8")
    near, far = (json.loads(flex("radiation", run, "--json", *words).stdout) for words in ([], ["--panel", other]))
    spl = [one["following"]["level_at_rated_drive_db_spl"][0] for one in (near, far)]
    assert spl[0] - spl[1] == pytest.approx(12.04, abs=0.1)  # twice the way, half the pressure
    said = flex("radiation", run, "--panel", other)
    assert "mounting box: sources radiate into the whole space, which holds below 3" in said.stderr


@pytest.mark.slow
def test_networks_follow_the_aim_of_the_filters_and_are_exported(run, panel, tmp_path):
    assert flex("focus", run, "--panel", panel).exit_code == 0
    done = flex("compensate", run)
    assert done.exit_code == 0, done.output
    declared, found = load_compensation(run / "compensation.h5")
    assert declared.filters.aim == "listeners"
    assert found.largest_loss[0] < 0.02
    heard, exact = (np.abs(aim.sound) for aim in (found.network_aim, found.direct_aim))
    assert np.abs(20.0 * np.log10(heard / exact)).max() < 0.5
    assert flex("export", run, "--to", "npz", "--out", tmp_path / "shipped").exit_code == 0
    assert load_focusing(run / "filters.h5")[0].filters.aim == "listeners"


@pytest.mark.slow
def test_a_scan_is_heard_with_its_error(panel, tmp_path):
    declared = read_panel(panel)
    known = declared.plate.grown(laws())
    twin = panel_twin(declared, known, silent)
    lines = declared.filters.frequency
    ((_, amplitude),) = responses(twin, known, np.array([20.0]), lines)
    transfer = (amplitude @ twin.space.deflection.T)[None]
    variance = np.full(transfer.shape, 1e-4 * np.mean(np.abs(transfer) ** 2))
    scan = tmp_path / "scan.h5"
    write_transfers(scan, MeasuredTransfers(np.array([20.0]), twin.space.grid.points, lines, transfer, variance))
    out = tmp_path / "scan-run"
    done = flex("focus", "--transfers", scan, "--panel", panel, "--out", out)
    assert done.exit_code == 0, done.output
    result = flex("radiation", out, "--transfers", scan, "--json")
    assert result.exit_code == 0, result.output
    said = json.loads(result.stdout)["following"]
    assert 0.0 < said["pressure_sigma_db"][0] < 1.0
    assert "the noise of the transfers makes levels uncertain by" in result.stderr
    # every fourth point in each direction is too coarse for the plate's waves
    grid = twin.space.grid.points
    some = np.isin(grid[:, 0], np.unique(grid[:, 0])[1::6]) & np.isin(grid[:, 1], np.unique(grid[:, 1])[1::5])
    coarse = tmp_path / "coarse.h5"
    write_transfers(
        coarse, MeasuredTransfers(np.array([20.0]), grid[some], lines, transfer[..., some], variance[..., some])
    )
    refused = flex("focus", "--transfers", coarse, "--panel", panel, "--out", out)
    assert refused.exit_code != 0
    assert "mm apart are too coarse for 300 Hz, where the wavelength of the plate is" in refused.stderr


def test_a_force_and_a_listener_change_places(tmp_path):
    """Lyamshev: pressure by a force is the panel's deflection there by a source where the ear was."""
    path = tmp_path / "driven.toml"
    head, rest = PANEL.split("[[patch]]", 1)
    text = (
        head
        + '[[drive]]\nid = "F1"\npoint = [0.071, 0.083]\n\n'
        + TARGET_AND_FILTERS
        + rest.split("delay = 32", 1)[1]
    )
    path.write_text(text.replace("grid = [20, 16]", "grid = [48, 38]"), "utf-8")
    declared = read_panel(path)
    known = declared.plate.grown(laws())
    twin = panel_twin(declared, known, silent)
    lines = np.array([110.0, 200.0, 290.0])
    ((constants, amplitude),) = responses(twin, known, np.array([20.0]), lines)
    grid = twin.space.grid
    radiator = Radiator(grid.points, grid.area)
    ear = radiator.pressure(np.array([[0.2, 0.02, 0.3]]), lines)[0]
    heard = np.einsum("fk,kr,fr->f", ear, twin.space.deflection, amplitude[0])
    load = ear / (
        -((2.0 * np.pi * lines[:, None]) ** 2)
    )  # of a source of unit volume acceleration: blocked pressure
    solve = twin.reduced.modal_form(*constants).solve
    moved = []
    for f, line in enumerate(lines):
        force = twin.space.deflection.T @ load[f]
        answer = sum(
            part * solve(each[:, None], np.array([line]))[0, 0]
            for part, each in ((1.0, force.real), (1j, force.imag))
        )
        moved.append(-(twin.reduced.ports * twin.signs)[:, 0] @ answer)
    np.testing.assert_allclose(heard, -((2.0 * np.pi * lines) ** 2) * np.array(moved), rtol=1e-9)


def test_bad_input_is_one_sentence(run, panel, tmp_path):
    for words, said in (
        (["focus", run, "--panel", panel, "--method", "none"], "the aim 'listeners' is for stif"),
        (["focus", run, "--panel", panel, "--zone", "driver"], "filters.zone 'driver' has no listener"),
        (["focus", run, "--panel", panel, "--level", -3], "has a level of its own"),
        (["radiation", run], "holds no filters.h5; make it with: flexura focus"),
        (["radiation", run, "--transfers", panel, "--twin", panel], "takes the place of laws"),
    ):
        refused = flex(*words)
        assert refused.exit_code != 0, refused.output
        assert said in refused.stderr
    for old, new, said in (
        ("0.095, 0.8]", "0.095, -0.1]", "sound.listener[0].position"),
        (
            "level = -6.0",
            "level = -6.0\nsound_speed = 34.0",
            "sound.sound_speed = 34.0; allowed: a number from 270",
        ),
        ("level = -6.0", "level = -6.0\ndensity = 1204.0", "sound.density = 1204.0; allowed: a number from 0.4"),
        ("grid = [20, 16]", "grid = [6, 5]", "grid [6, 5]: points"),
    ):
        wrong = tmp_path / "wrong.toml"
        wrong.write_text(panel.read_text("utf-8").replace(old, new), "utf-8")
        refused = flex("focus", run, "--panel", wrong)
        assert refused.exit_code != 0, refused.output
        assert said in refused.stderr
        assert len(refused.stderr.splitlines()) <= 2
