"""``flexura focus`` and ``flexura compensate`` on a panel small enough to be reduced in seconds."""

import json
import shutil
import subprocess
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest
import pyuff
from click.testing import CliRunner
from scipy.sparse.linalg import spsolve

from analysis.compensation.settings import Training
from analysis.estimation.transfer import MeasuredTransfer
from analysis.focusing.measured import MeasuredTransfers
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel_model import responses
from analysis.material import MaterialLaws
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.hdf5_file import write_value
from app.files.provenance import provenance, read_stamp, sha256, stamp
from app.files.results.panel_files import load_compensation, load_focusing, other_filters
from app.files.results.transfers_file import read_transfers, write_transfers
from app.files.uff.frfs import write_frfs
from app.main import flexura
from app.report.focusing import loss, relative_errors
from app.stages import compensate as compensate_stage
from app.stages import focus as focus_stage
from app.stages.focus import uncorrected_aim
from app.stages.panel import inputs as panel_inputs
from app.stages.panel.laws import laws_for
from app.twins import warm_twin as warm_module
from app.twins.panel_twin import panel_twin
from app.twins.warm_twin import warm_twin
from simulation.state.plate_state import PlateState
from tests.two_patch_panel import PANEL


@pytest.fixture
def panel(tmp_path):
    path = tmp_path / "panel.toml"
    path.write_text(PANEL, encoding="utf-8")
    return path


def laws(low=0.0, high=60.0):
    """E falls from 3.2 to 1.0 GPa over 0 to 60 °C, nu and eta hold still; valid from `low` to `high`."""
    knots = np.concatenate([[0.0] * 4, [60.0] * 4])
    steps = np.linspace(0.0, 1.0, 4)
    log_e = np.log(3.2e9) + steps * np.log(1.0 / 3.2)
    coefficients = np.array([log_e, np.full(4, 0.38), np.full(4, np.log(0.07))])
    return MaterialLaws(knots, coefficients, np.zeros((3, 4, 4)), (low, high))


def write_laws(folder, value):
    folder.mkdir(exist_ok=True)
    with atomic_hdf5(folder / "laws.h5") as file:
        stamp(file, provenance({}))
        file.create_group("updated")
        write_value(file.create_group("laws"), value)
    return folder


@pytest.fixture
def run(tmp_path):
    return write_laws(tmp_path / "run", laws())


def silent(_stage, _share):
    pass


def flex(*words):
    return CliRunner().invoke(flexura, [str(word) for word in words])


def test_focus_writes_what_it_prints(run, panel):
    result = flex("focus", run, "--panel", panel, "--json")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    declared, found, comparison = load_focusing(run / "filters.h5")
    assert declared == read_panel(panel)
    assert printed["temperatures_c"] == found.temperature.tolist() == list(np.arange(0.0, 61.0, 5.0))
    assert printed["direct"]["contrast"] == pytest.approx(found.direct.contrast.mean(axis=1).tolist())
    assert (
        set(printed["comparison"]) == set(comparison.methods) == {"stif", "time-reversal", "modal-control", "none"}
    )
    assert found.bank.taps.shape == (13, 2, 64)
    place = found.temperature.tolist().index(20.0)
    np.testing.assert_allclose(found.fixed.contrast[place], found.direct.contrast[place])
    with h5py.File(run / "filters.h5") as file:
        made_from = read_stamp(file)
    assert set(made_from["inputs"]) == {"laws.h5", "panel.toml"}
    assert made_from["settings"]["panel"]["filters"]["taps"] == 64
    assert "13 temperatures" in result.stderr
    again = flex("focus", run, "--panel", panel, "--temperature", 21.5)
    assert f"note: {run / 'filters.h5'} held filters of 13 temperatures, 0 to 60 °C: replaced" in again.stderr
    assert "--out FOLDER" in again.stderr
    (line,) = (line for line in again.stderr.splitlines() if line.startswith("21.5 °C: contrast"))
    assert " to " not in line.partition(" with their own filters")[0]  # one value, not "0.57 to 0.57"
    assert "replaced" not in flex("focus", run, "--panel", panel, "--temperature", 21.5).stderr


def test_temperatures_method_and_regularisation_can_be_chosen(run, panel, tmp_path):
    words = [
        "--temperature",
        31.5,
        "--temperature",
        7,
        "--method",
        "time-reversal",
        "--regularisation",
        "truncation",
    ]
    words += ["--tolerance", 0.2, "--out", tmp_path / "other"]
    result = flex("focus", run / "laws.h5", "--panel", panel, *words)
    assert result.exit_code == 0, result.output
    _, found, _ = load_focusing(tmp_path / "other" / "filters.h5")
    assert (found.method, found.regularisation, found.tolerance) == ("time-reversal", "truncation", 0.2)
    np.testing.assert_array_equal(found.temperature, [7.0, 31.5])
    assert not (run / "filters.h5").exists()


def test_compensate_prints_every_method_and_keeps_the_networks(run, panel):
    result = flex("compensate", run, "--panel", panel, "--json")
    assert result.exit_code == 0, result.output
    printed = json.loads(result.stdout)
    _, found = load_compensation(run / "compensation.h5")
    assert list(printed["methods"]) == list(found.methods)
    assert printed["temperatures"] == 241
    network = printed["methods"]["network"]
    assert network["relative_error_max_percent"] == pytest.approx(found.relative_error[0].max())
    assert network["contrast_loss"] <= 0.005
    assert printed["methods"]["linear"]["relative_error_max_percent"] > network["relative_error_max_percent"]
    assert printed["methods"][printed["best"]]["contrast_loss"] == min(
        m["contrast_loss"] for m in printed["methods"].values()
    )
    # The file holds the network itself: what it says at a training temperature is the filter there.
    flex("focus", run, "--panel", panel, "--temperature", 20)
    _, focused, _ = load_focusing(run / "filters.h5")
    np.testing.assert_allclose(
        found.trained.networks.taps([20.0]), focused.bank.taps, atol=3e-3 * np.abs(focused.bank.taps).max()
    )


@pytest.mark.slow
def test_the_verbs_write_what_the_stages_compute_and_save(run, panel, tmp_path):
    """Byte for byte; on a plate that grows with temperature, so that growth counts once."""
    panel.write_text(PANEL.replace("mass =", "expansion = 1e-3\ndimensions_at = 20.0\nmass ="), encoding="utf-8")
    declared, inputs = read_panel(panel), {path.name: sha256(path) for path in (run / "laws.h5", panel)}
    assert flex("focus", run, "--panel", panel).exit_code == 0
    assert flex("compensate", run, "--panel", panel, "--spacing", 6, "--seed", 1).exit_code == 0
    found = focus_stage.compute(declared, laws(), silent)
    focus_stage.save(tmp_path, found, inputs)
    trained = compensate_stage.compute(declared, laws(), silent, training=Training(seed=1), spacing=6.0)
    compensate_stage.save(tmp_path, trained, inputs)
    assert (tmp_path / "filters.h5").read_bytes() == (run / "filters.h5").read_bytes()
    written, again = (load_compensation(folder / "compensation.h5")[1] for folder in (run, tmp_path))
    np.testing.assert_array_equal(written.contrast, again.contrast)
    rigid = declared.model_copy(update={"plate": declared.plate.model_copy(update={"expansion": 0.0})})
    plain = focus_stage.compute(rigid, laws(), silent, temperature=np.array([20.0, 60.0]))
    off = np.abs(plain.focusing.bank.taps - found.focusing.bank.taps[[4, -1]]).max(axis=(1, 2))
    assert off[1] > 20.0 * off[0]  # as declared at 20 °C, but for the spline's error


def test_compensate_takes_the_panel_filters_were_made_for(run, panel):
    assert flex("focus", run, "--panel", panel, "--temperature", 20).exit_code == 0
    panel.unlink()
    result = flex("compensate", run, "--nodes", 8, "--split", "matlab", "--scale", "tap", "--seed", 3)
    assert result.exit_code in (0, 1), result.output
    declared, found = load_compensation(run / "compensation.h5")
    assert declared.title == "two patches"
    assert (found.trained.settings.nodes, found.trained.settings.split, found.trained.settings.seed) == (
        8,
        "matlab",
        3,
    )
    np.testing.assert_array_equal(found.trained.used.sum(axis=1), 11.0)


def test_filters_in_a_folder_of_their_own_go_on_with_the_laws_of_the_run(run, panel, tmp_path):
    """Two seats are two folders: each of them follows its own panel, and the run keeps what it has."""
    assert flex("focus", run, "--panel", panel, "--temperature", 20).exit_code == 0
    other = tmp_path / "other.toml"
    other.write_text(PANEL.replace("two patches", "right seat"), encoding="utf-8")
    right = tmp_path / "seats" / "right"
    assert flex("focus", run, "--panel", other, "--out", right).exit_code == 0
    assert json.loads((right / "laws.json").read_text()) == {"laws": "../../run"}
    assert not (run / "laws.json").exists()
    result = flex("compensate", right)
    assert result.exit_code in (0, 1), result.output
    assert load_compensation(right / "compensation.h5")[0].title == "right seat"
    assert not (run / "compensation.h5").exists()
    mixed = flex("compensate", run, "--out", right)
    assert mixed.exit_code == 2
    said = f"--out {right}: holds filters of 'right seat'; those to be followed are of 'two patches', from {run}"
    assert said in mixed.output
    assert f"follow the filters there: flexura compensate {right}" in mixed.output
    assert "panel 'right seat', " in result.output
    again = tmp_path / "again"
    assert flex("focus", right, "--panel", other, "--temperature", 20, "--out", again).exit_code == 0
    assert json.loads((again / "laws.json").read_text()) == {"laws": "../run"}  # where they are, not a way there
    assert flex("focus", run / "laws.h5", "--panel", other, "--temperature", 20, "--out", again).exit_code == 0
    assert json.loads((again / "laws.json").read_text()) == {"laws": "../run/laws.h5"}
    assert laws_for(again, None, "render").path == run / "laws.h5"
    run.rename(tmp_path / "elsewhere")
    lost = flex("compensate", right)
    assert lost.exit_code
    assert "laws.json: laws = '../../run': nothing is there any more" in lost.output


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"laws": 3}', '{"other": "."}', '{"laws": ".", "twin": "."}'])
def test_a_damaged_place_of_laws_is_told(tmp_path, text):
    (tmp_path / "laws.json").write_text(text)
    result = flex("compensate", tmp_path)
    assert "laws.json: " in result.output
    assert f"with the run folder of the laws and --out {tmp_path}" in " ".join(result.output.split())


def test_laws_that_end_early_are_used_as_far_as_they_go_and_it_is_said(tmp_path, panel):
    run = write_laws(tmp_path / "short", laws(22.0, 60.0))
    result = flex("focus", run, "--panel", panel)
    assert result.exit_code == 0, result.output
    assert "do not reach 20 °C" in result.stderr
    _, found, _ = load_focusing(run / "filters.h5")
    assert (found.temperature[0], found.temperature[-1], found.reference_temperature) == (22.0, 60.0, 22.0)
    result = flex("compensate", run, "--spacing", 3)
    assert result.exit_code in (0, 1), result.output
    assert "22 to 60 °C only" in result.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--temperature", 61), "--temperature 61 °C is outside the laws' range, 0 to 60 °C"),
        (("--temperature", "nan"), "'--temperature': nan; allowed: a finite number"),
        (("--tolerance", 2), "filters.tolerance"),
        (("--delay", 64), "filters: delay 64 samples must lie inside the 64 taps; leave it out, or take 0 to 63"),
        (("--taps", 400), "transform_length 512 must be at least twice taps"),
        (("--outside-weight", 0.5), "filters.outside_weight = 0.5"),
        (("--method", "magic"), "magic"),
        (("--panel", "nowhere.toml"), "--panel nowhere.toml: does not exist; allowed"),
    ],
)
def test_focus_names_what_is_wrong(run, panel, words, said):
    result = CliRunner().invoke(
        flexura, ["focus", str(run), "--panel", str(panel), *map(str, words)], standalone_mode=True
    )
    assert result.exit_code in (1, 2)
    assert said in result.output
    assert "Traceback" not in result.output
    assert not (run / "filters.h5").exists()


def test_another_length_brings_its_own_delay(run, panel):
    """The panel's file declares 64 taps and a delay of 32; half of 24 suits 24."""
    assert flex("focus", run, "--panel", panel, "--taps", 24, "--temperature", 20).exit_code == 0
    _, found, _ = load_focusing(run / "filters.h5")
    assert (found.bank.taps.shape[2], found.bank.delay) == (24, 12)


def test_what_is_compensated_is_what_was_focused(run, panel):
    words = ("--method", "time-reversal", "--temperature", 20)
    assert flex("focus", run, "--panel", panel, *words).exit_code == 0
    result = flex("compensate", run)
    assert "those of time-reversal" in result.stderr
    _, found = load_compensation(run / "compensation.h5")
    assert found.focusing == "time-reversal"
    _, focused, _ = load_focusing(run / "filters.h5")
    # Many temperatures are computed in the few coordinates that 10 K need.
    largest = np.abs(focused.bank.taps).max()
    np.testing.assert_allclose(found.filters.taps[4], focused.bank.taps[0], atol=5e-4 * largest, rtol=0.0)
    assert found.filters.delay == focused.bank.delay


def test_filters_that_follow_the_paper_closely_and_the_sound_badly_end_with_status_1(run, panel):
    """MATLAB's split leaves temperatures out: hardly seen in the relative error, heard in the contrast."""
    words = ("--feed", "temperature", "--scale", "tap", "--start", "random", "--split", "matlab", "--seed", 7)
    result = flex("compensate", run, "--panel", panel, "--json", "--design", "inverse-fft", *words)
    _, found = load_compensation(run / "compensation.h5")
    assert result.exit_code == int(found.largest_loss[0] > 0.02)
    assert json.loads(result.stdout)["methods"]["network"]["contrast_loss"] == pytest.approx(found.largest_loss[0])


@pytest.mark.parametrize("verb", [("focus", "--temperature", "20"), ("compensate",)])
def test_filters_and_networks_do_without_what_takes_long_to_import(run, panel, verb):
    code = "import sys; from app.main import flexura; flexura(sys.argv[1:], standalone_mode=False)"
    code += "; sys.exit(not {'torch', 'pyuff'}.isdisjoint(sys.modules))"
    words = [
        sys.executable,
        "-c",
        code,
        *verb,
        str(run),
        "--panel",
        str(panel),
        "--quiet",
    ]
    assert subprocess.run(words, check=False).returncode == 0


def test_compensate_names_what_is_wrong(run, panel):
    result = flex("compensate", run, "--panel", panel, "--spacing", 30)
    assert "3 training temperatures; at least 4 are needed: take a smaller spacing" in result.output
    assert result.exit_code == 2
    result = flex("compensate", run, "--panel", panel, "--device", "abacus")
    assert "--device abacus: no device for networks; allowed: cpu, cuda" in result.output
    result = flex("compensate", run, "--panel", panel, "--place", 8, "--spacing", 4)
    assert "--place and --spacing each choose the training temperatures" in result.output
    assert result.exit_code == 2
    for words in (("--feed", "rigidity"), ("--design", "field")):
        result = flex("compensate", run, "--panel", panel, "--as-paper", *words)
        assert f"--as-paper sets {words[0]} itself" in result.output
        assert result.exit_code == 2
    result = flex("study", "18", run, "--panel", panel, "--as-paper", "--design", "field")
    assert "--as-paper sets --design itself" in result.output
    assert not (run / "compensation.h5").exists()


@pytest.mark.parametrize("words", [("focus",), ("compensate",), ("study", "13")])
def test_laws_outside_the_twin_s_box_leave_no_folder_behind(tmp_path, panel, words):
    stiff = replace(laws(), coefficients=laws().coefficients + np.log([[10.0], [1.0], [1.0]]))
    run, out = write_laws(tmp_path / "stiff", stiff), tmp_path / "new" / "results"
    refused = flex(*words, run, "--panel", panel, "--out", out)
    assert "outside the panel's twin: youngs_modulus of the laws is" in refused.output
    assert "poisson_ratio" not in refused.output  # only what has to be widened
    assert "loss_factor" not in refused.output
    assert not out.parent.exists()


def test_a_run_without_laws_says_how_to_make_them(tmp_path):
    result = flex("focus", tmp_path)
    assert "holds no laws.h5; make it with: flexura update" in result.output


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("taps = 64", "taps = 64.5", "filters.taps = 64.5; allowed: an integer from 16 to 16384"),
        ("length_x = 0.24", "length_x = 240", "plate.length_x = 240"),
        ("[target]", "[aim]", "target is missing"),
        ("delay = 32", "dealy = 32", "filters.dealy is not known; the keys here are taps, sample_rate"),
        ("delay = 32", "delay = 64", "filters: delay 64 samples must lie inside the 64 taps"),
        ("center = [0.07, 0.1]", "center = [0.005, 0.1]", "patch 'A1' spans -0.005 to 0.015 m along x"),
        ('format = "panel/1"', "format =", "allowed: TOML"),
        (
            "youngs_modulus = [0.9e9, 3.4e9]",
            "youngs_modulus = [1.05e9, 3.4e9]",
            "widen [twin] in the panel's file. The paper's panel (the one without --panel) is of plastic",
        ),
    ],
)
def test_a_panel_file_s_faults_are_told_in_its_own_words(run, panel, old, new, said):
    text = PANEL.replace(old, new)
    assert text != PANEL
    panel.write_text(text, encoding="utf-8")
    result = flex("focus", run, "--panel", panel)
    assert result.exit_code != 0
    assert said in result.output
    assert "panel.toml" in result.output or "widen" in said


def test_filters_of_another_sample_rate_drive_the_panel_alike_and_go_on_with_it(run, panel, tmp_path):
    """As long in time, they have the same frequency responses, whatever the rate, up to what taps cannot reach."""
    held = []
    for rate, taps, delay in ((4_000, 64, 32), (6_000, 96, 48)):
        out = tmp_path / str(rate)
        words = ("--panel", panel, "--sample-rate", rate, "--taps", taps, "--delay", delay, "--out", out)
        assert flex("focus", run, *words).exit_code == 0
        declared, found, _ = load_focusing(out / "filters.h5")
        assert declared.filters.sample_rate == rate
        lines = np.arange(120.0, 280.0, 10.0)
        held.append((found.bank.response(lines), found.direct.contrast))
        assert flex("export", out, "--to", "c").exit_code == 0
        assert f"SAMPLE_RATE {rate}.0f" in (out / "flexura_filters.h").read_text()
    (slow, contrast), (fast, same) = held
    np.testing.assert_allclose(fast, slow, atol=0.03 * np.abs(slow).max())
    np.testing.assert_allclose(same.mean(axis=1), contrast.mean(axis=1), atol=0.01)


def test_filters_of_laws_that_lack_nothing_lose_nothing(panel):
    """Robust ones, too: filters from the uncorrected laws are designed as those from the corrected ones are."""
    declared = panel_inputs.changed(read_panel(panel), {"thermometer_error": 8.0})
    model, t = panel_twin(declared, laws(), lambda _stage, _share: None), np.array([20.0, 35.0])
    found = focus(model, declared, laws(), t)
    same = uncorrected_aim(model, declared, laws(), laws(), t, "stif")
    np.testing.assert_allclose(same.contrast, found.direct.contrast, rtol=1e-9)


def test_the_shipped_panel_is_the_paper_s_section_2():
    panel = read_panel(SECTION_2)
    assert len(panel.patch) == 6
    assert panel.plate.density == pytest.approx(950.0)
    assert (panel.filters.taps, panel.filters.sample_rate, panel.filters.band) == (512, 44_100.0, (100.0, 800.0))
    assert (panel.target.center, panel.target.size) == ((0.3, 0.55), (0.25, 0.3))
    assert panel.grid[0] * panel.grid[1] >= 1000


def scanned(run, panel, path, temperature=20.0):
    """Write the twin's own transfers at its grid as a universal file: nodes in a data set 2411, FRFs in 58."""
    declared = read_panel(panel)
    here = laws()
    model = panel_twin(declared, here, lambda _stage, _share: None)
    spacing = declared.filters.sample_rate / declared.filters.transform_length
    frequency = np.arange(54.0 // spacing + 1, 400.0 // spacing) * spacing
    (_, amplitude), *_ = responses(model, here, np.array([temperature]), frequency)
    h = amplitude @ model.space.deflection.T
    points = model.space.grid.points
    frfs = [
        MeasuredTransfer(
            f"A{n + 1}",
            f"{k + 1}:+3",
            f"{9001 + n}:+3",
            "displacement",
            frequency,
            h[n, :, k],
            "unknown",
            ("m", ""),
        )
        for n in range(len(h))
        for k in range(len(points))
    ]
    write_frfs(path, frfs)
    none = np.zeros(len(points), dtype=int)
    nodes = pyuff.prepare_2411(np.arange(1, len(points) + 1), none, none, none, *points.T, np.zeros(len(points)))
    pyuff.UFF(str(path)).write_sets(nodes | {"type": 2411}, "add")


def test_the_twin_s_own_transfers_from_a_universal_file_give_the_twin_s_filters(run, panel, tmp_path):
    panel.write_text(PANEL.replace("grid = [20, 16]", "grid = [20, 20]"), encoding="utf-8")
    scanned(run, panel, tmp_path / "scan.uff")
    assert flex("focus", run, "--panel", panel, "--temperature", 20).exit_code == 0
    words = ("--transfers", tmp_path / "scan.uff", "--temperature", 20, "--out", tmp_path / "scan")
    result = flex("focus", "--panel", panel, *words)
    assert result.exit_code == 0, result.output
    _, exact, _ = load_focusing(run / "filters.h5")
    _, found, comparison = load_focusing(tmp_path / "scan" / "filters.h5")
    assert comparison.methods == ("stif", "time-reversal", "none")
    with h5py.File(tmp_path / "scan" / "filters.h5") as file:
        settings = read_stamp(file)["settings"]
    assert (settings["measured"], settings["temperatures"]) == (True, [20.0])
    np.testing.assert_allclose(found.bank.taps, exact.bank.taps, atol=1e-4 * np.abs(exact.bank.taps).max())
    np.testing.assert_allclose(found.direct.contrast, exact.direct.contrast, atol=1e-4)
    again = read_transfers(tmp_path / "scan.uff", (60.0, 360.0), 20.0)
    write_transfers(tmp_path / "scan.h5", again)
    words = ("--transfers", tmp_path / "scan.h5", "--out", tmp_path / "h5")
    assert flex("focus", "--panel", panel, *words).exit_code == 0
    np.testing.assert_array_equal(load_focusing(tmp_path / "h5" / "filters.h5")[1].bank.taps, found.bank.taps)
    assert flex("focus", "--panel", panel, "--method", "modal-control", *words).exit_code == 2
    shutil.copy(run / "laws.h5", tmp_path / "h5")
    result = flex("compensate", tmp_path / "h5")
    assert result.exit_code != 0
    assert "designed from measured transfers" in result.output
    narrow = panel.read_text(encoding="utf-8").replace("edges = [60.0, 360.0]", "edges = [20.0, 360.0]")
    panel.write_text(narrow, encoding="utf-8")
    result = flex("focus", "--panel", panel, *words)
    assert "filters.edges ask for 20 to 360 Hz: measure wider" in result.output


def test_transfers_of_several_temperatures_are_compensated_as_the_twin_is(run, panel, tmp_path):
    """The twin's own transfers, written and read back: its filters, and networks that say the same."""
    panel.write_text(PANEL.replace("grid = [20, 16]", "grid = [20, 20]"), encoding="utf-8")
    declared, here, scan = read_panel(panel), laws(), tmp_path / "scan.h5"
    model = panel_twin(declared, here, lambda _stage, _share: None)
    spacing = declared.filters.sample_rate / declared.filters.transform_length
    frequency = np.arange(54.0 // spacing + 1, 400.0 // spacing) * spacing
    temperature = np.arange(0.0, 61.0, 5.0)
    fields = np.array([a @ model.space.deflection.T for _, a in responses(model, here, temperature, frequency)])
    points = model.space.grid.points
    write_transfers(scan, MeasuredTransfers(temperature, points, frequency, fields, np.zeros(fields.shape)))
    out = ("--out", tmp_path / "scan")
    assert flex("focus", "--panel", panel, "--transfers", scan, *out).exit_code == 0
    result = flex("compensate", tmp_path / "scan", "--transfers", scan, "--json")
    assert result.exit_code in (0, 1), result.output
    printed, (_, found) = json.loads(result.stdout), load_compensation(tmp_path / "scan" / "compensation.h5")
    assert printed["judged"] == found.judged == "left-out"
    assert list(printed["methods"]) == ["network", "linear", "cubic-spline", "low-rank"]
    assert printed["law_band"] is printed["placed"] is printed["across"] is None
    assert "measured transfers give no log" in result.stderr
    assert "13 temperatures measured; left out one by one from 5 to 55" in result.stderr
    twin = flex("compensate", run, "--panel", panel, "--feed", "temperature", "--nodes", 8)
    assert twin.exit_code in (0, 1), twin.output
    _, own = load_compensation(run / "compensation.h5")
    largest = np.abs(own.filters.taps).max()
    np.testing.assert_allclose(found.filters.taps, own.filters.taps, atol=1e-4 * largest)
    np.testing.assert_allclose(
        found.trained.networks.taps(temperature), own.trained.networks.taps(temperature), atol=2e-3 * largest
    )
    at = np.searchsorted(own.temperature, found.temperature)
    np.testing.assert_allclose(found.contrast_direct, own.contrast_direct[at], atol=1e-4)
    exported = flex("export", tmp_path / "scan", "--to", "npz", "--out", tmp_path / "shipped")
    assert exported.exit_code == 0, exported.output
    drawn = relative_errors(found)
    assert len(drawn.axes[1].get_legend().get_texts()) == 4
    refused = flex("compensate", tmp_path / "scan", "--transfers", scan, "--spacing", 4)
    assert "leave out --spacing, --place, --across and --weather" in refused.output


def test_temperatures_are_placed_and_it_is_said_what_that_gains(run, panel):
    result = flex("compensate", run, "--panel", panel, "--place", 9, "--nodes", 6, "--json")
    assert result.exit_code in (0, 1), result.output
    printed, (_, found) = json.loads(result.stdout), load_compensation(run / "compensation.h5")
    np.testing.assert_array_equal(found.filters.temperature, found.placed.temperature)
    assert len(found.placed.temperature) == 9
    assert found.placed.loss <= found.placed.equidistant_loss
    assert printed["placed"]["temperatures_c"] == printed["training_temperatures_c"]
    assert "note: placed at 0, " in result.stderr
    assert "the laws state no uncertainty (sigma 0)" in result.stderr
    with h5py.File(run / "compensation.h5") as file:
        settings = read_stamp(file)["settings"]
    assert (settings["place"], settings["spacing"], settings["across"]) == (9, None, [])
    result = flex("compensate", run, "--panel", panel, "--place", 3)
    assert result.exit_code == 2
    few = write_laws(run / "few", laws(20.0, 25.5))
    result = flex("compensate", few, "--panel", panel, "--place", 9)
    assert "--place: 9 training temperatures; allowed 4 to 7, 20 to 25.5 °C" in result.output


def test_the_band_of_uncertain_laws_is_told_kept_and_drawn(tmp_path, panel):
    """E uncertain by 1 %: a band about what the laws themselves give, in words, JSON, file and figure."""
    spread = np.array([1e-2**2, 0.0, 0.0])[:, None, None] * np.ones((3, 4, 4))
    run = write_laws(tmp_path / "run", replace(laws(), covariance=spread))
    assert flex("focus", run, "--panel", panel).exit_code == 0
    result = flex("compensate", run, "--json")
    assert result.exit_code in (0, 1), result.output
    band = json.loads(result.stdout)["law_band"]
    _, found = load_compensation(run / "compensation.h5")
    assert (
        band["temperatures_c"] == found.law_band.temperature.tolist() == [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0]
    )
    np.testing.assert_array_equal(band["contrast_worst_line_band"], found.law_band.worst)
    assert (found.law_band.mean[:, 1] > found.law_band.mean[:, 0] + 1e-4).all()
    own = found.contrast[0, np.searchsorted(found.temperature, found.law_band.temperature)]
    np.testing.assert_allclose(found.law_band.nominal[:, 0], own.mean(axis=1), atol=3e-5)
    assert "note: uncertainty of the laws: the 90% band of the mean contrast" in result.stderr
    drawn = loss(load_focusing(run / "filters.h5")[1], found)
    assert any("90 %" in text.get_text() for text in drawn.legends[0].get_texts())


def test_transfers_at_four_temperatures_are_too_few_to_train_on_all_but_one(panel, tmp_path):
    frequency, points = np.arange(40.0, 400.0, 10.0), np.array([[0.05, 0.1], [0.1, 0.1], [0.2, 0.05]])
    fields, scan = np.ones((4, 2, len(frequency), 3), dtype=complex), tmp_path / "scan.h5"
    at = np.array([0.0, 20.0, 40.0, 60.0])
    write_transfers(scan, MeasuredTransfers(at, points, frequency, fields, np.zeros(fields.shape)))
    refused = flex("compensate", "--panel", panel, "--transfers", scan)
    assert "transfers at 4 temperatures; at least 5 are needed" in refused.output
    assert refused.exit_code != 0
    refused = flex("compensate", tmp_path / "nowhere", "--panel", panel, "--transfers", scan)
    assert "nowhere: does not exist; make it with: flexura update, or flexura focus --transfers" in refused.output
    assert not (tmp_path / "nowhere").exists()


@pytest.mark.slow
def test_a_panel_warmer_on_one_side_is_judged(run, panel):
    result = flex("compensate", run, "--panel", panel, "--across", 20, "--nodes", 8, "--json")
    assert result.exit_code in (0, 1), result.output
    (row,) = json.loads(result.stdout)["across"]
    _, found = load_compensation(run / "compensation.h5")
    assert row["difference_k"] == 20.0
    with h5py.File(run / "compensation.h5") as file:
        assert read_stamp(file)["settings"]["across"] == [20.0]
    assert row["temperatures_c"] == found.tilted.temperature[0].tolist() == [10.0, 30.0, 50.0]
    assert row["loss_fed_target_temperature"] < row["loss_fed_mean_temperature"]
    at = [int(np.argmin(np.abs(found.temperature - t))) for t in (10.0, 30.0, 50.0)]
    np.testing.assert_allclose(found.tilted.uniform[0, :, 0], found.contrast[0, at].mean(axis=1), atol=1e-5)
    shorter = write_laws(run / "short", laws(20.0, 60.0))
    refused = flex("compensate", shorter, "--panel", panel, "--across", 50)
    assert "--across 50 K: the laws hold from 20 to 60 °C, so that up to 40 K can be judged" in refused.output
    assert refused.exit_code == 2


def test_transfers_with_missing_points_or_of_other_actuators_are_refused(panel, tmp_path):
    frequency, points = np.arange(40.0, 400.0, 10.0), np.array([[0.05, 0.1], [0.1, 0.1], [0.2, 0.05]])
    h = np.ones((1, 2, len(frequency), 3), dtype=complex)

    def refused(transfer, points, *words):
        with h5py.File(tmp_path / "scan.h5", "w") as file:
            parts = {"temperature": [20.0], "points": points, "frequency": frequency, "transfer": transfer}
            for name, value in parts.items():
                file[name] = value
        result = flex("focus", *words, "--panel", panel, "--transfers", tmp_path / "scan.h5")
        assert result.exit_code != 0
        assert "Traceback" not in result.output
        assert not (tmp_path / "filters.h5").exists()
        return result.output

    gone = h.copy()
    gone[0, 1, :, 2] = np.nan
    assert "the first from actuator 2 to point 3; measure them" in refused(gone, points)
    assert "transfers of 1 actuators; the panel declares 2" in refused(h[:, :1], points)
    assert "point 3 at (0.3, 0.05) m is outside the plate" in refused(h, points + np.outer([0, 0, 1], [0.1, 0]))
    assert "must be (T, N, F, K)" in refused(h[..., :2], points)
    assert "scan.h5 was measured at 20 °C; leave it out" in refused(h, points, "--temperature", 40)
    assert "thermometer_error 5 °C needs a model" in refused(h, points, "--thermometer-error", 5)
    assert "takes the place of RUN" in refused(h, points, tmp_path)
    assert "takes the place of RUN" in refused(h, points, "--twin", tmp_path)


def test_vectors_of_another_plate_in_the_cache_are_refused_with_their_file(panel, monkeypatch):
    monkeypatch.setattr(warm_module, "load_plate_basis", lambda _: None)
    with pytest.raises(ResultFileError, match=r"basis-\w+\.h5: holds no vectors of this plate; delete it"):
        warm_twin(read_panel(panel), laws(), silent)


def test_a_tilted_twin_is_the_twin_where_nothing_is_tilted_and_the_full_plate_where_it_is(panel):
    """The vectors of the uniform panel carry one that is 20 K warmer on one side, at largest x."""
    declared, frequency = read_panel(panel), np.array([110.0, 190.0, 290.0])
    tilted, plain = (made(declared, laws(), lambda _stage, _share: None) for made in (warm_twin, panel_twin))
    here = laws().at(30.0)
    constants = (here.youngs_modulus, here.poisson_ratio, here.loss_factor)
    exact = plain.amplitudes(*(float(x[0]) for x in constants), frequency) @ plain.space.deflection.T
    found = tilted.amplitudes(30.0, (0.0, 0.0), frequency) @ tilted.space.deflection.T
    np.testing.assert_allclose(found, exact, atol=1e-6 * np.abs(exact).max())

    xi, zeta = tilted.full.sampling
    warm = 30.0 + 10.0 * xi  # laws() are straight in log E: their expansion holds all over the panel
    state = PlateState.baseline(xi, zeta, laws().local(30.0), 30.0, frequency).with_(temperature=warm)
    matrices = tilted.full.matrices(state)
    answers = tilted.amplitudes(30.0, (20.0, 0.0), frequency)
    for line, f in enumerate(frequency):
        stiffness = matrices.plate + 1j * matrices.plate_loss + matrices.patches
        exact = -spsolve((stiffness - (2.0 * np.pi * f) ** 2 * matrices.mass).tocsc(), matrices.coupling)
        missed = tilted.vectors @ answers[:, line].T - exact
        assert np.linalg.norm(missed) < 0.02 * np.linalg.norm(exact)
    cold = tilted.amplitudes(30.0, (-20.0, 0.0), frequency)
    assert np.abs(cold - answers).max() > 0.05 * np.abs(answers).max()


def test_the_library_follows_the_filters_of_the_run_as_the_verb(run, panel, monkeypatch):
    import flexura as library

    library.focus(run, panel, temperature=[0.0, 20.0, 40.0, 60.0], method="time-reversal", out=run)
    asked = {}

    def noted(declared, _laws, _report, **options):
        asked.update(options, panel=declared)
        raise KeyboardInterrupt

    monkeypatch.setattr(compensate_stage, "compute", noted)
    with pytest.raises(KeyboardInterrupt):
        library.compensate(run, place=6, across=10.0)
    assert (asked["panel"], asked["method"]) == (read_panel(panel), "time-reversal")
    assert (asked["place"], asked["across"]) == (6, (10.0,))
    with pytest.raises(KeyboardInterrupt):
        library.compensate(run, SECTION_2)
    assert (asked["panel"], asked["method"]) == (read_panel(SECTION_2), "stif")


def test_results_of_two_panels_come_into_no_folder_of_their_own(run, panel, tmp_path):
    import flexura as library

    other = tmp_path / "other.toml"
    other.write_text(PANEL.replace("two patches", "right seat"), encoding="utf-8")
    right = tmp_path / "right seat"
    library.focus(run, other, temperature=20.0, out=right)
    with pytest.raises(UnsuitedOptionError, match=r"^out .*: holds filters of 'right seat'") as no:
        library.compensate(run, panel, out=right)
    assert f"flexura compensate '{right}'" in str(no.value)
    assert not (right / "compensation.h5").exists()
    with pytest.raises(UnsuitedOptionError, match="holds filters of other settings of this panel"):
        library.compensate(run, other, method="time-reversal", out=right)


def test_it_is_told_where_compensation_and_filters_are_of_two_panels(run, panel, tmp_path):
    other = tmp_path / "other.toml"
    other.write_text(PANEL.replace("two patches", "right seat"), encoding="utf-8")
    assert flex("focus", run, "--panel", panel, "--temperature", 20).exit_code == 0
    assert other_filters(run) == []
    assert flex("compensate", run, "--panel", other).exit_code in (0, 1)
    (said,) = other_filters(run)
    assert said == (
        "compensation.h5 follows other filters than those of filters.h5 beside it (title 'right seat', there "
        f"'two patches'); make it again: flexura compensate {run}"
    )
    after = flex("focus", run, "--panel", panel, "--temperature", 20, "--taps", 48, "--method", "time-reversal")
    told = "designed by stif, there by time-reversal; title 'right seat', there 'two patches'; filters.taps 64"
    assert f"({told}, there 48; and 1 more); make it again" in after.output


def test_few_placed_temperatures_get_few_hidden_nodes(panel, monkeypatch):
    given = []
    monkeypatch.setattr(compensate_stage, "panel_twin", lambda *_: None)

    def noted(*words, **_options):
        given.append(words[4].nodes)
        raise KeyboardInterrupt

    monkeypatch.setattr(compensate_stage, "compensate", noted)
    for place in (None, 6, 30):
        with pytest.raises(KeyboardInterrupt):
            compensate_stage.compute(read_panel(panel), laws(), silent, place=place)
    assert given == [10, 4, 10]
