"""``flexura thermometer`` on a small panel: simulated, and from files."""

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner

import flexura as library
from app.files.bad_file import ResultFileError
from app.main import flexura
from app.sound.listening import ListeningPanel

soundfile = pytest.importorskip("soundfile")
RATE = 4_000


def flex(*words):
    return CliRunner().invoke(flexura, [str(word) for word in words])


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    path = tmp_path_factory.mktemp("sound") / "noise.wav"
    soundfile.write(path, 0.1 * np.random.default_rng(4).standard_normal(12 * RATE), RATE, subtype="DOUBLE")
    return path


def rows_of(folder):
    with (folder / "thermometer.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_simulated_panel_tells_its_temperature(small_run, sound, tmp_path):
    words = (
        "--simulate",
        sound,
        "--temperature",
        "20:20.3",
        "--seed",
        1,
        "--out",
        tmp_path,
        "--json",
        "--picture",
    )
    result = flex("thermometer", small_run.folder, *words)
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["stretches"] == 11
    assert (tmp_path / "thermometer.png").read_bytes().startswith(b"\x89PNG")
    assert told["refused"] == 0
    assert told["rms_error_k"] < 0.3
    assert abs(told["temperature_c"] - 20.3) < 5.0 * told["sigma_k"] + 0.02
    rows = rows_of(tmp_path)
    assert [float(row["true_c"]) for row in rows] == sorted(float(row["true_c"]) for row in rows)
    assert float(rows[-1]["sigma_k"]) < float(rows[0]["sigma_k"])
    assert "rms error" in result.stderr


def test_a_recording_with_any_gain_is_read(small_run, tmp_path):
    """Made here with the twin's own patch-to-patch response, as a long convolution at one temperature."""
    from app.files.results.panel_files import load_panel
    from app.stages.panel.laws import laws_for
    from app.twins.panel_twin import panel_twin

    declared = load_panel(small_run.folder / "filters.h5")
    laws = laws_for(small_run.folder, None, "test").laws
    twin = panel_twin(declared, laws, lambda *_: None)
    at = laws.at(33.3)
    count = 6 * RATE
    drive = np.random.default_rng(2).standard_normal(count)
    lines = np.fft.rfftfreq(count, 1.0 / RATE)
    inside = (lines >= 60.0) & (lines <= 360.0)
    answer = np.zeros(len(lines), dtype=complex)
    e, nu, eta = (float(v[0]) for v in (at.youngs_modulus, at.poisson_ratio, at.loss_factor))
    answer[inside] = twin.reduced.compliance(e, nu, eta, lines[inside])[0, 1] * np.fft.rfft(drive)[inside]
    response = np.fft.irfft(answer, count)
    response *= -0.01 / np.abs(response).max()  # turned round, and of some gain
    response += 1e-5 * np.random.default_rng(3).standard_normal(count)
    soundfile.write(tmp_path / "drive.wav", np.column_stack([np.zeros(count), drive]), RATE, subtype="DOUBLE")
    soundfile.write(tmp_path / "charge.wav", response, RATE, subtype="DOUBLE")
    files = ("--drive", tmp_path / "drive.wav", "--response", tmp_path / "charge.wav")
    result = flex("thermometer", small_run.folder, *files, "--sensor", "A1", "--out", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["temperature_c"] == pytest.approx(33.3, abs=0.03)
    result = flex("thermometer", small_run.folder, *files, "--sensor", "A2", "--out", tmp_path)
    assert "A2, the patch used as sensor, is driven by up to" in result.output


def test_a_track_that_runs_beyond_the_laws_keeps_their_end_s_uncertainty(small_run):
    """The track is a forecast; through pauses near the end of the range it goes on beyond it."""
    panel = ListeningPanel(None, small_run.module.laws(), 0)
    assert panel.law_sigma(60.4) == panel.law_sigma(60.0)
    assert panel.law_sigma(-0.1) == panel.law_sigma(0.0)


def test_silence_tells_no_temperature_and_that_is_status_1(small_run, tmp_path):
    soundfile.write(tmp_path / "silence.wav", np.zeros(4 * RATE), RATE)
    words = ("--simulate", tmp_path / "silence.wav", "--temperature", 20, "--out", tmp_path)
    result = flex("thermometer", small_run.folder, *words)
    assert result.exit_code == 1
    assert "note: refused: silence in the band" in result.stderr
    assert "none of 3 stretches gives a temperature" in result.stderr
    assert [row["temperature_c"] for row in rows_of(tmp_path)] == ["", "", ""]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "name --drive and --response"),
        (("--drive", "{sound}"), "name --drive and --response"),
        (("--simulate", "{sound}"), "--simulate and --temperature belong together"),
        (("--drive", "{sound}", "--response", "{sound}", "--temperature", "20"), "belong together"),
        (("--simulate", "{sound}", "--drive", "{sound}", "--temperature", "20"), "takes the place of"),
        (("--simulate", "nowhere.wav", "--temperature", "20"), "--simulate nowhere.wav: does not exist"),
        (
            ("--simulate", "{sound}", "--temperature", "20", "--sensor", "A9"),
            "--sensor A9: no patch of this panel",
        ),
        (("--simulate", "{sound}", "--temperature", "70"), "outside what the filters cover"),
        (
            ("--simulate", "{sound}", "--temperature", "20", "--stretch", "20"),
            "of sound are too short for a stretch of 20 s",
        ),
        (("--drive", "{sound}", "--response", "{sound}"), "1 channels; the panel has 2 patches"),
    ],
)
def test_what_is_wrong_is_one_sentence_and_nothing_is_written(small_run, sound, tmp_path, words, said):
    typed = [word.format(sound=sound) for word in words]
    result = flex("thermometer", small_run.folder, *typed, "--out", tmp_path / "out")
    assert result.exit_code != 0
    assert said in result.output
    assert "Traceback" not in result.output
    assert not (tmp_path / "out").exists()


def test_the_library_reads_what_the_verb_reads(small_run, sound, tmp_path):
    ours = library.thermometer(small_run.folder, simulate=sound, temperature=20.3, seed=1, out=tmp_path / "ours")
    words = ("--simulate", sound, "--temperature", 20.3, "--seed", 1, "--out", tmp_path / "theirs", "--json")
    result = flex("thermometer", small_run.folder, *words)
    assert result.exit_code == 0, result.output
    assert ours.file.read_bytes() == (tmp_path / "theirs" / "thermometer.csv").read_bytes()
    assert ours.record()["temperature_c"] == json.loads(result.stdout)["temperature_c"]
    assert repr(ours).startswith("20.")
    with pytest.raises(ResultFileError, match="name drive and response"):
        library.thermometer(small_run.folder, drive=sound)
    with pytest.raises(ResultFileError, match=r"^stretch 0\.1: allowed are 0\.25 to 30"):
        library.thermometer(small_run.folder, simulate=sound, temperature=20, stretch=0.1)
