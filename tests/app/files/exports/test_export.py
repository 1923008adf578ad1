"""``flexura export`` on the filters of a panel small enough to be reduced in seconds."""

import json
import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from app.files.hdf5_file import BLOCK, sealed
from app.files.provenance import sha256
from app.files.results.panel_files import load_compensation, load_focusing
from app.main import flexura


def flex(*words):
    return CliRunner().invoke(flexura, [str(word) for word in words])


@pytest.fixture(scope="module")
def run(small_run):
    return small_run.folder


@pytest.mark.parametrize(
    ("form", "names"),
    [
        ("c", ["flexura_filters.h", "flexura_filters.c"]),
        ("onnx", ["flexura_filters.onnx"]),
        ("npz", ["flexura_filters.npz"]),
        ("csv", ["flexura_filters.csv"]),
        ("wav", [f"flexura_filters_+{t:06.2f}C.wav" for t in range(0, 61, 5)]),
    ],
)
def test_every_form_is_written_and_told(run, tmp_path, form, names):
    result = flex("export", run, "--to", form, "--method", "network", "--out", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert [Path(file).name for file in told["files"]] == names
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(names)
    assert told["bytes"] == sum(path.stat().st_size for path in (tmp_path / "out").iterdir())
    assert (told["method"], told["actuators"], told["taps"]) == ("network", ["A1", "A2"], 64)
    assert ("target" in told) == (form == "c")
    assert "network, 2 filters of 64 taps, 0 to 60 °C" in result.stderr


def test_the_file_says_what_it_was_made_from(run, tmp_path):
    assert flex("export", run, "--to", "npz", "--method", "network", "--out", tmp_path).exit_code == 0
    with np.load(tmp_path / "flexura_filters.npz", allow_pickle=False) as held:
        stamp = json.loads(str(held["provenance"]))
    assert stamp["inputs"] == {"compensation.h5": sha256(run / "compensation.h5")}
    assert stamp["settings"] == {"method": "network", "to": "npz", "number": "float32"}
    assert "laws.h5" in stamp["made_from"]["compensation.h5"]["inputs"]
    assert stamp["format"] == "flexura-filters/1"


@pytest.mark.parametrize("method", ["network", "low-rank", "cubic-spline", "cubic-spline-rigidity", "linear"])
def test_methods_give_back_the_filters_at_the_training_temperatures(run, tmp_path, method):
    words = ("--to", "npz", "--method", method, "--temperature", 10, "--temperature", 45, "--out", tmp_path)
    result = flex("export", run, *words)
    assert result.exit_code == 0, result.output
    _, focusing, _ = load_focusing(run / "filters.h5")
    known = [focusing.temperature.tolist().index(t) for t in (10.0, 45.0)]
    exact = focusing.bank.taps[known]
    with np.load(tmp_path / "flexura_filters.npz", allow_pickle=False) as held:
        assert held["temperature"].tolist() == [10.0, 45.0]
        error = np.sum((held["taps"] - exact) ** 2) / np.sum(exact**2)
    # coordinates of ten kelvins: 5e-5 of a tap
    assert error < {"network": 5e-4, "low-rank": 1e-5}.get(method, 1e-8)


def test_left_out_the_method_is_the_recommended_one_or_said_to_be_another(run, tmp_path):
    _, found = load_compensation(run / "compensation.h5")
    result = flex("export", run, "--to", "c", "--out", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)["method"]
    assert (
        told == found.recommended
        or f"{found.recommended}, recommended here, is no sum of fixed banks; {told}" in result.stderr
    )


def test_a_compensation_of_other_filters_than_those_beside_it_is_said(small_run, tmp_path):
    folder = small_run.laws_alone(tmp_path / "run")
    (folder / "compensation.h5").write_bytes((small_run.folder / "compensation.h5").read_bytes())
    words = ("--panel", small_run.panel, "--temperature", 20, "--taps", 24)
    assert flex("focus", folder, *words).exit_code == 0
    result = flex("export", folder, "--to", "csv", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert (
        "compensation.h5 follows other filters than those of filters.h5 beside it (filters.taps" in result.stderr
    )
    result = flex("export", small_run.folder, "--to", "csv", "--out", tmp_path / "out")
    assert "follows other filters" not in result.stderr


def test_filters_of_focus_alone_can_be_exported(run, tmp_path):
    (tmp_path / "filters.h5").write_bytes((run / "filters.h5").read_bytes())
    result = flex("export", tmp_path, "--to", "c", "--number", "int16", "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["method"] == "cubic-spline"
    assert told["target"]["multiply_adds_per_sample"] == 2 * 64
    assert "int16" in (tmp_path / "flexura_filters.c").read_text()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ("--to", "wav", "--temperature", "61"),
            "--temperature 61 °C is outside what the filters cover, 0 to 60 °C",
        ),
        (
            ("--to", "wav", "--temperature", "20.001", "--temperature", "20.004"),
            "two of them are the same to 0.01 °C",
        ),
        (("--to", "npz", "--temperature", "nan"), "'--temperature': nan; allowed: a finite number"),
        (("--to", "c", "--temperature", "20"), "c follows every temperature"),
        (("--to", "csv", "--number", "int16"), "--number int16 is for --to c"),
        (("--to", "mp3"), "mp3"),
        ((), "--to"),
    ],
)
def test_what_is_wrong_is_told_in_a_sentence_and_nothing_is_written(run, tmp_path, words, said):
    result = CliRunner().invoke(flexura, ["export", str(run), "--out", str(tmp_path / "out"), *words])
    assert result.exit_code != 0
    assert said in result.output
    assert "Traceback" not in result.output
    assert not (tmp_path / "out").exists()


def test_a_run_without_filters_says_how_to_make_them(tmp_path):
    result = flex("export", tmp_path, "--to", "c")
    assert "holds no filters.h5; make it with: flexura focus" in result.output
    result = flex("export", tmp_path, "--to", "c", "--method", "network")
    assert "holds no compensation.h5; make it with: flexura compensate" in result.output


def test_damaged_filters_are_refused(run, tmp_path):
    held = bytearray((run / "filters.h5").read_bytes())
    held[len(held) // 2] ^= 0xFF
    (tmp_path / "filters.h5").write_bytes(held)
    result = flex("export", tmp_path, "--to", "onnx")
    assert result.exit_code != 0
    assert "not a readable filters.h5" in result.output
    assert [path.name for path in tmp_path.iterdir()] == ["filters.h5"]


@pytest.mark.parametrize(
    ("name", "axis", "said"),
    [
        ("compensation.h5", "compensation/filters/temperature", "Compensation.filters.temperature must ascend"),
        ("compensation.h5", "compensation/temperature", "Compensation.temperature must ascend"),
        ("filters.h5", "focusing/bank/temperature", "Focusing.bank.temperature must ascend"),
    ],
)
def test_filters_whose_temperatures_do_not_ascend_are_refused(run, tmp_path, name, axis, said):
    """The file is sound but for the order: splines through them, and what is exported, need it."""
    path = tmp_path / name
    shutil.copy(run / name, path)
    with h5py.File(path, "r+") as file:
        file[axis][:] = file[axis][()][::-1]
    path.write_bytes(b"".join(sealed(path.read_bytes()[BLOCK:])))
    result = flex("export", tmp_path, "--to", "c")
    assert result.exit_code != 0, result.output
    assert name in result.output
    assert said in " ".join(result.output.split())


def test_filters_of_one_temperature_are_said_to_follow_none(small_run, tmp_path):
    made = small_run.laws_alone(tmp_path / "run")
    assert flex("focus", made, "--panel", small_run.panel, "--temperature", 20).exit_code == 0
    result = flex("export", made, "--to", "wav")
    assert result.exit_code == 0, result.output
    assert "filters of one temperature, 20 °C; they follow none" in result.stderr
    assert [path.name for path in made.glob("*.wav")] == ["flexura_filters_+020.00C.wav"]
    with h5py.File(made / "filters.h5") as file:
        assert file["focusing/temperature"][:].tolist() == [20.0]


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_the_example_for_a_target_plays_what_render_wrote(run, tmp_path):
    """As the comment of the program says: export, render, compile, compare."""
    soundfile = pytest.importorskip("soundfile")
    sound = tmp_path / "sound.wav"
    noise = 0.25 * np.clip(np.random.default_rng(5).standard_normal(30_000), -3.0, 3.0)
    soundfile.write(sound, noise, 4_000, subtype="PCM_16")
    words = ("--method", "cubic-spline", "--out", tmp_path, "--json")
    exported = flex("export", run, "--to", "c", "--number", "int16", "--example", *words)
    assert exported.exit_code == 0, exported.output
    written = [Path(file) for file in json.loads(exported.stdout)["files"]]
    assert [path.name for path in written[2:]] == ["flexura_target.h", "flexura_target.c", "flexura_loopback.c"]
    assert flex("render", sound, run, "--temperature", "15:40", *words).exit_code == 0
    sources = [path for path in written if path.suffix == ".c"]
    command = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-o", tmp_path / "loopback", *sources, "-lm"]
    subprocess.run([str(word) for word in command], check=True)
    files = (tmp_path / "loopback", sound, tmp_path / "sound-rendered.wav")
    for way, status in ((("15", "40"), 0), (("40", "15"), 1)):
        done = subprocess.run([*map(str, files), *way], capture_output=True, text=True, check=False)
        assert done.returncode == status, done.stdout + done.stderr
