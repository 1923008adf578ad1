"""The identify verb as typed, on universal files and on what it must refuse."""

import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from threadpoolctl import threadpool_limits

from analysis.estimation.transfer import MeasuredTransfer
from analysis.estimation.windows import without_window
from analysis.identification.modes import Modes
from analysis.identification.pole_residue import named
from analysis.identification.settings import Settings
from analysis.shapes.participation import mac
from app.files.uff.frfs import read_frfs, write_frfs
from app.main import flexura
from app.modal_test.modes_of_test import load_test
from app.modal_test.without_windows import rebuilt
from app.stages.identify import uff_records
from app.stages.identify_options import Wanted
from app.summaries.modes import mode_table, modes_record
from app.terminal.tables import show
from tests.synthetic_frf import SyntheticFrf, r10

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
BEAM = SHARED / "real" / "beam_roving_hammer"
CAMPAIGN = SHARED / "campaigns" / "pp-plate-nominal"


def typed(*words: str) -> Result:
    with threadpool_limits(1):
        result = CliRunner().invoke(flexura, list(words))
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def of_case(case: SyntheticFrf, name: str, quantity: str = "displacement") -> MeasuredTransfer:
    power = {"displacement": 0, "velocity": 1, "acceleration": 2}[quantity]
    h = case.h * (2j * np.pi * case.frequency) ** power
    return MeasuredTransfer(name, "1:+3", "2:+3", quantity, case.frequency, h)


@pytest.fixture(scope="module")
def cases() -> list[SyntheticFrf]:
    return [r10(np.random.default_rng(seed)) for seed in (61, 62, 63)]


@pytest.fixture(scope="module")
def uff(cases: list[SyntheticFrf], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three FRFs of three plates: receptance, mobility and accelerance."""
    path = tmp_path_factory.mktemp("uff") / "plates.uff"
    kinds = ("displacement", "velocity", "acceleration")
    write_frfs(path, [of_case(case, kind, kind) for case, kind in zip(cases, kinds, strict=True)])
    return path


def test_every_frf_of_a_file_shows_its_ten_modes(uff: Path, cases: list[SyntheticFrf]) -> None:
    result = typed("identify", str(uff), "--json", "--damping", "viscous")
    assert result.exit_code == 0
    printed = json.loads(result.stdout)
    assert [frf["name"] for frf in printed["frfs"]] == ["displacement", "velocity", "acceleration"]
    for frf, case in zip(printed["frfs"], cases, strict=True):
        f = np.array([mode["frequency_hz"] for mode in frf["modes"]])
        zeta = np.array([mode["damping_ratio"] for mode in frf["modes"]])
        sigma_f = np.array([mode["sigma_frequency_hz"] for mode in frf["modes"]])
        sigma_zeta = np.array([mode["sigma_damping_ratio"] for mode in frf["modes"]])
        w = np.abs(case.poles)
        assert (np.abs(f - w / (2 * np.pi)) < 4.5 * sigma_f).all()
        assert (np.abs(zeta + case.poles.real / w) < 4.5 * sigma_zeta).all()
        assert {mode["status"] for mode in frf["modes"]} == {"kept"}
        assert {mode["confirmation"] for mode in frf["modes"]} == {"confirmed"}
        assert all(mode["reason"] for mode in frf["modes"] + frf["rejected"])
    assert printed["frfs"][0]["misfit"] == pytest.approx(0.01, rel=0.1)


def test_deviations_without_end_are_none_in_json_and_in_the_table(capsys: pytest.CaptureFixture[str]) -> None:
    """A direction that the data do not determine, with an exponential window taken out."""
    pole = np.array([-5.0 + 900j])
    moved, spread = without_window(pole, np.diag([1e-6, np.inf])[None], 2.0)
    assert np.isinf(spread[0, 1, 1])
    nothing = np.zeros((1, 0), dtype=complex)
    modes = Modes(
        moved, np.ones((1, 1), complex), spread, named("none"), nothing, ("weak",), ("why",), (1.0, 300.0), 0.1, 99
    )
    for damping in ("hysteretic", "viscous"):
        record = modes_record(modes.read_as(damping))
        assert record["modes"][0]["sigma_damping_ratio"] is None
        json.dumps(record, allow_nan=False)
        show([mode_table("plate", record["modes"])])
        assert "∞" in capsys.readouterr().out


def test_frfs_are_read_as_other_programs_read_them_by_default(uff: Path, cases: list[SyntheticFrf]) -> None:
    printed = json.loads(typed("identify", str(uff), "--json").stdout)
    for mode, pole in zip(printed["frfs"][0]["modes"], cases[0].poles, strict=True):
        f, zeta = np.abs(pole) / (2 * np.pi), -pole.real / np.abs(pole)
        assert mode["frequency_hz"] == pytest.approx(f, abs=4.5 * mode["sigma_frequency_hz"])
        assert mode["damping_ratio"] == pytest.approx(zeta, abs=4.5 * mode["sigma_damping_ratio"])


def test_the_hysteretic_reading_is_there_on_demand(uff: Path, cases: list[SyntheticFrf]) -> None:
    printed = json.loads(typed("identify", str(uff), "--damping", "hysteretic", "--json").stdout)
    k = -(cases[0].poles ** 2)
    for mode, stiffness in zip(printed["frfs"][0]["modes"], k, strict=True):
        f, eta = np.sqrt(stiffness.real) / (2 * np.pi), stiffness.imag / stiffness.real
        assert mode["frequency_hz"] == pytest.approx(f, abs=4.5 * mode["sigma_frequency_hz"])
        assert mode["loss_factor"] == pytest.approx(eta, abs=4.5 * mode["sigma_loss_factor"])


def test_shared_poles_and_band(cases: list[SyntheticFrf], tmp_path: Path) -> None:
    case = cases[0]
    rng = np.random.default_rng(9)
    again = case.h + case.deviation * (rng.normal(size=case.h.shape) + 1j * rng.normal(size=case.h.shape))
    frfs = [of_case(case, "a"), MeasuredTransfer("b", "2:+3", "2:+3", "displacement", case.frequency, -2 * again)]
    write_frfs(tmp_path / "two.uff", frfs)
    result = typed("identify", str(tmp_path / "two.uff"), "--shared-poles", "--band", "100", "900", "--json")
    printed = json.loads(result.stdout)
    f = np.abs(case.poles) / (2 * np.pi)
    inside = f[f < 880.0]
    found = np.array([mode["frequency_hz"] for mode in printed["modes"]])
    assert all(np.abs(found / one - 1).min() < 5e-3 for one in inside)
    assert (found < 900.0).all()
    assert printed["places"] == ["1:+3", "2:+3"]
    for shape in printed["shapes"]:
        assert shape["shape"][1] == pytest.approx([1.0, 0.0])
        assert shape["shape"][0] == pytest.approx([-0.5, 0.0], abs=0.1)


def test_frfs_with_different_lines_cannot_share_poles(cases: list[SyntheticFrf], tmp_path: Path) -> None:
    case = cases[0]
    short = MeasuredTransfer("short", "1:+3", "2:+3", "displacement", case.frequency[:900], case.h[:900])
    write_frfs(tmp_path / "two.uff", [of_case(case, "long"), short])
    result = typed("identify", str(tmp_path / "two.uff"), "--shared-poles")
    assert result.exit_code != 0
    assert "'short' and 'long'" in result.output


def test_paper_recipe_is_offered(uff: Path) -> None:
    printed = json.loads(typed("identify", str(uff), "--method", "peak-picking", "--json").stdout)
    assert 5 <= len(printed["frfs"][0]["modes"]) <= 10


def test_a_dead_channel_is_noted_and_does_not_stop_the_others(cases: list[SyntheticFrf], tmp_path: Path) -> None:
    case = cases[1]
    dead = MeasuredTransfer("dead", "3:+3", "2:+3", "displacement", case.frequency, 0 * case.h)
    write_frfs(tmp_path / "two.uff", [dead, of_case(case, "alive")])
    result = typed("identify", str(tmp_path / "two.uff"), "--json")
    assert result.exit_code == 0
    first, second = json.loads(result.stdout)["frfs"]
    assert (first["modes"], len(second["modes"])) == ([], 10)
    assert "zero on every line" in first["note"]
    assert "dead" in result.stderr


def test_nothing_found_is_exit_status_one(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    f = np.arange(100.0, 500.0, 0.5)
    h = rng.normal(size=len(f)) + 1j * rng.normal(size=len(f))
    write_frfs(tmp_path / "noise.uff", [MeasuredTransfer("noise", "1:+3", "2:+3", "displacement", f, h)])
    result = typed("identify", str(tmp_path / "noise.uff"))
    assert result.exit_code == 1
    assert "0 modes" in result.stderr


def test_a_note_on_the_coherence_stays_where_nothing_can_be_identified() -> None:
    f = np.arange(100.0, 500.0, 0.5)
    silent = MeasuredTransfer("silent", "1:+3", "2:+3", "displacement", f, 0j * f, coherence=np.ones(len(f)))
    (record,) = uff_records([silent], Wanted(Settings(), "hysteretic", "auto", None), lambda *_: None)
    assert "coherence 1 on every line" in record["note"]
    assert record["note"].endswith("an FRF is zero on every line: nothing to identify")


def test_a_campaign_of_noise_is_exit_status_one(tiny: Any, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    for file in tiny.files.values():
        for group in file.groups.values():
            group |= {name: rng.normal(size=len(group["drive"])).astype(np.float32) for name in ("S1", "S2")}
    result = typed("identify", str(tiny.write(tmp_path / "noise")))
    assert result.exit_code == 1, result.output
    assert "6 sweeps, 0 modes each (0 of 0 unconfirmed)" in result.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--band", "900", "100"), "LOW must be below HIGH"),
        (("--mains", "0"), "mains"),
        (("--method", "guess"), "peak-picking"),
        (("--out", "somewhere"), "a run folder needs --shared-poles"),
    ],
)
def test_options_that_make_no_sense_are_refused(uff: Path, words: tuple[str, ...], message: str) -> None:
    result = CliRunner().invoke(flexura, ["identify", str(uff), *words])
    assert result.exit_code == 2
    assert message in result.output


def test_what_is_neither_campaign_nor_universal_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("nothing here\n")
    for path, message in ((tmp_path / "notes.txt", "universal file"), (tmp_path / "absent", "does not exist")):
        result = CliRunner().invoke(flexura, ["identify", str(path)])
        assert result.exit_code != 0
        assert message in str(result.exception) + result.output
    assert sorted(child.name for child in tmp_path.iterdir()) == ["notes.txt"]


@pytest.mark.shared
@pytest.mark.skipif(not BEAM.is_dir(), reason="the measured beam lies beside the checkout, and is absent")
def test_measured_beam_has_four_modes_and_no_doublets(tmp_path: Path) -> None:
    """Accelerance of a lightly damped beam with some leakage; poles known from a study."""
    frfs = []
    for number in (3, 5, 7):
        with gzip.open(BEAM / f"Hxysv0000{number}.txt.gz", "rt", encoding="latin-1") as file:
            f, real, imaginary = np.loadtxt(file.readlines()[9:]).T
        used = (f >= 65.0) & (f <= 1000.0)
        h = (real + 1j * imaginary)[used]
        frfs.append(MeasuredTransfer(f"point {number}", f"{number}:+1", "1:-1", "acceleration", f[used], h))
    write_frfs(tmp_path / "beam.uff", frfs)
    printed = json.loads(typed("identify", str(tmp_path / "beam.uff"), "--json").stdout)
    for frf in printed["frfs"]:
        found = [mode["frequency_hz"] for mode in frf["modes"]]
        assert found == pytest.approx([112.0, 306.9, 596.4, 974.2], abs=0.15)
        assert all(1e-5 < mode["damping_ratio"] < 4e-4 for mode in frf["modes"])


@pytest.mark.slow
@pytest.mark.shared
@pytest.mark.skipif(not CAMPAIGN.is_dir(), reason="the recorded campaigns lie beside the checkout, and are absent")
def test_recorded_campaign_is_identified_down_to_its_noise(tmp_path: Path) -> None:
    """31 temperatures by an independent solver: the material's loss factor is what the well-known modes show."""
    from app.files.results.modes_file import load_frf, load_modes

    assert typed("identify", str(CAMPAIGN), "--out", str(tmp_path)).exit_code == 0
    tracked, (_, frf) = load_modes(tmp_path / "modes.h5"), load_frf(tmp_path / "frf.h5")
    assert (tracked.misfit < 1.15 * frf.noise_floor).all()
    truth = np.loadtxt(CAMPAIGN / "truth-laws.csv", delimiter=",", skiprows=1)
    eta = np.interp(tracked.temperature, truth[:, 0], truth[:, 3])
    read = tracked.reading()
    for t in range(31):
        known = read.sigma_loss_factor[t] < 0.01 * read.loss_factor[t]
        assert known.sum() >= 3
        share = read.loss_factor[t, known] / eta[t]
        # the patches, a few per cent of the strain energy, have no loss
        assert 0.96 < np.median(share) < 1.02


@pytest.mark.slow
@pytest.mark.shared
@pytest.mark.skipif(not BEAM.is_dir(), reason="the measured beam lies beside the checkout, and is absent")
@pytest.mark.parametrize("lowest", [0.0, 65.0])
def test_measured_beam_as_one_structure_has_four_bending_shapes(tmp_path: Path, lowest: float) -> None:
    """Roving hammer over nine points of a beam on soft supports: free bending shapes, 1.3 m long by its points.

    From one point to the next the mode at 974 Hz falls, by 0.06 Hz in all: it must not be taken for two.
    """
    frfs = []
    for number in range(1, 10):
        with gzip.open(BEAM / f"Hxysv0000{number}.txt.gz", "rt", encoding="latin-1") as file:
            f, real, imaginary = np.loadtxt(file.readlines()[9:]).T
        used = (f > lowest) & (f <= 1000.0)
        h = (real + 1j * imaginary)[used]
        frfs.append(MeasuredTransfer(f"point {number}", "4:-1", f"{number}:+1", "acceleration", f[used], h))
    write_frfs(tmp_path / "beam.uff", frfs)
    result = typed("identify", str(tmp_path / "beam.uff"), "--shared-poles", "--out", str(tmp_path / "run"))
    assert result.exit_code == 0
    measured, modes, shapes = load_test(tmp_path / "run")
    reading = modes.reading()
    assert list(reading.frequency_hz[modes.real]) == pytest.approx([112.0, 306.9, 596.4, 974.2], abs=0.15)
    x = np.array([0.1, 0.25, 0.375, 0.5, 0.65, 0.8, 0.925, 1.05, 1.2]) / 1.3
    for shape, beta in zip(shapes.shape, (4.730041, 7.853205, 10.995608, 14.137165), strict=True):
        s = (np.cosh(beta) - np.cos(beta)) / (np.sinh(beta) - np.sin(beta))
        free = np.cosh(beta * x) + np.cos(beta * x) - s * (np.sinh(beta * x) + np.sin(beta * x))
        assert mac(shape[None], free[None].astype(complex))[0, 0] > 0.95
    again = rebuilt(modes, measured.frequency, measured)
    written = np.array([one.h for one in read_frfs(tmp_path / "run" / "rebuilt.uff")])
    np.testing.assert_allclose(written, again, rtol=1e-12)


def test_lines_spaced_evenly_by_ratio_show_the_same_modes(cases: list[SyntheticFrf], tmp_path: Path) -> None:
    case = cases[0]
    rng = np.random.default_rng(12)
    frequency = np.geomspace(100.0, 1500.0, 2500)
    h = sum(
        r / (2j * np.pi * frequency - p) + np.conj(r) / (2j * np.pi * frequency - np.conj(p))
        for p, r in zip(case.poles, case.residues.ravel(), strict=True)
    )
    noise = 0.01 * np.sqrt(np.mean(np.abs(h) ** 2) / 2)
    h = h + noise * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
    write_frfs(tmp_path / "a.uff", [MeasuredTransfer("log", "1:+3", "2:+3", "displacement", frequency, h)])
    (frf,) = json.loads(typed("identify", str(tmp_path / "a.uff"), "--damping", "viscous", "--json").stdout)[
        "frfs"
    ]
    f = np.array([mode["frequency_hz"] for mode in frf["modes"]])
    sigma = np.array([mode["sigma_frequency_hz"] for mode in frf["modes"]])
    assert (np.abs(f - np.abs(case.poles) / (2 * np.pi)) < 5 * sigma).all()
