"""``flexura render`` on a small panel."""

import base64
import csv
import io
import json

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.cbook import STEP_LOOKUP_MAP
from scipy.io import wavfile

import flexura as library
from analysis.rendering.renderer import FieldContrast
from app.files.bad_file import ResultFileError
from app.files.results.laws_file import load_laws
from app.files.results.panel_files import load_compensation, load_panel
from app.main import flexura
from app.report.panel_sections import players
from app.report.sound import along_the_way
from app.sound.rendering import ListenersOfPanel
from app.sound.trace import TraceMoment
from app.twins.panel_twin import panel_twin

soundfile = pytest.importorskip("soundfile")
RATE = 4_000


def flex(*words):
    return CliRunner().invoke(flexura, [str(word) for word in words])


@pytest.fixture(scope="module")
def signal():
    return 0.3 * np.random.default_rng(4).standard_normal(5 * RATE + 123)


@pytest.fixture
def sound(tmp_path, signal):
    path = tmp_path / "noise.wav"
    soundfile.write(path, signal, RATE, subtype="DOUBLE")
    return path


def test_at_a_steady_temperature_it_is_one_convolution(small_run, sound, signal, tmp_path):
    out = tmp_path / "out"
    words = ("--temperature", 31.3, "--method", "network", "--out", out, "--json")
    result = flex("render", sound, small_run.folder, *words)
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    _, found = load_compensation(small_run.folder / "compensation.h5")
    taps = found.trained.networks.taps(31.3)[0]
    rate, rendered = wavfile.read(out / "noise-rendered.wav")
    expected = np.array([np.convolve(row, signal) for row in taps])
    assert rate == RATE
    assert rendered.shape == (len(signal) + taps.shape[1] - 1, 2)
    np.testing.assert_allclose(rendered.T, expected, atol=1e-6 * np.abs(expected).max())
    assert told["largest_v"] == pytest.approx(dict(zip(("A1", "A2"), np.abs(expected).max(axis=1), strict=True)))
    assert (told["changes"], told["latency_samples"]) == (0, 512 + found.filters.delay)
    assert told["real_time_factor"] > 0.0
    assert sorted(path.name for path in out.iterdir()) == ["noise-rendered.csv", "noise-rendered.wav"]


def test_filters_follow_and_the_field_shows_what_it_is_worth(small_run, sound, tmp_path):
    result = flex(
        "render", sound, small_run.folder, "--temperature", "5:55", "--out", tmp_path, "--block", 64, "--picture"
    )
    assert result.exit_code == 0, result.output
    assert (tmp_path / "noise-rendered.png").read_bytes().startswith(b"\x89PNG")
    with (tmp_path / "noise-rendered.csv").open(encoding="utf-8") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    assert [row["time_s"] for row in rows] == pytest.approx([*range(5), 5.0 + 123 / RATE], abs=0.02)
    assert rows[-1]["temperature_c"] == pytest.approx(55.0, abs=0.2)
    assert "5.0 s at 5.0 to 5" in result.stderr  # 55 less what rises within the last block
    for row in rows:
        assert row["temperature_c"] == pytest.approx(5.0 + 50.0 * row["time_s"] / (5.0 + 123 / RATE), abs=0.01)
        assert abs(row["temperature_c"] - row["filters_c"]) < 0.75  # a step, and what passes during a fade
        assert row["contrast_worst"] <= row["contrast_sound"] <= 1.0
    assert rows[0]["contrast_mean"] == rows[0]["kept_mean"]
    assert rows[-1]["contrast_mean"] > rows[-1]["kept_mean"] + 0.05
    assert "times real time" in result.stderr


@pytest.mark.parametrize("seconds", [0.4, 1.2, 59.7])
def test_beginning_and_end_of_a_sound_are_looked_at_and_none_in_between_twice(small_run, tmp_path, seconds):
    noise = 0.3 * np.random.default_rng(5).standard_normal(round(seconds * RATE))
    soundfile.write(tmp_path / "some.wav", noise, RATE)
    result = flex("render", tmp_path / "some.wav", small_run.folder, "--temperature", "5:55", "--json")
    assert result.exit_code == 0, result.output
    time = np.array([moment["time_s"] for moment in json.loads(result.stdout)["moments"]])
    assert (time[0], time[-1]) == (0.0, pytest.approx(seconds, abs=512 / RATE + 1e-9))
    assert len(time) <= 62
    assert len(time) == 2 or np.diff(time).min() > 0.35
    for path in small_run.folder.glob("some-rendered.*"):
        path.unlink()


def test_the_picture_s_filters_lag_no_more_than_those_looked_at():
    """A step held from one moment to the next would seem to lag by what the panel warms in a second."""
    same = FieldContrast(0.9, 0.8, 0.85)
    moments = [TraceMoment(t, 20.0 + 6.0 * t, 19.8 + 6.0 * t, same, same) for t in np.arange(4.0)]
    above = along_the_way(moments).axes[0]
    panel, filters = above.lines
    fine = np.linspace(0.0, 3.0, 61)
    drawn = []
    for line in (panel, filters):
        x, y = STEP_LOOKUP_MAP[line.get_drawstyle()](*line.get_data())
        drawn.append(np.interp(fine, x, y))
    assert np.abs(drawn[0] - drawn[1]).max() == pytest.approx(0.2)


def test_the_result_says_what_it_was_made_from_and_is_the_same_again(small_run, sound, tmp_path):
    words = ("render", sound, small_run.folder, "--temperature", "20:30", "--out", tmp_path)
    assert flex(*words).exit_code == 0
    first = (tmp_path / "noise-rendered.wav").read_bytes()
    comment = first.index(b"ICMT") + 8
    stamp = json.loads(first[comment : first.index(b"\0", comment)])
    assert stamp["settings"]["temperature"] == "20:30"
    assert stamp["format"] == "flexura-filters/1"
    assert flex(*words).exit_code == 0
    assert (tmp_path / "noise-rendered.wav").read_bytes() == first


def test_flac_and_stereo_are_read_and_averaged(small_run, signal, tmp_path):
    left, right = tmp_path / "left.flac", tmp_path / "both.flac"
    soundfile.write(left, 0.5 * signal, RATE)
    soundfile.write(right, np.column_stack([signal * 0.4, signal * 0.6]), RATE)
    for path in (left, right):
        result = flex("render", path, small_run.folder, "--temperature", 20, "--out", tmp_path)
        assert result.exit_code == 0, result.output
    assert "the mean of its 2 channels is played" in result.stderr
    one, two = (wavfile.read(tmp_path / f"{name}-rendered.wav")[1] for name in ("left", "both"))
    np.testing.assert_allclose(one, two, atol=2e-4 * np.abs(one).max())


def test_more_volts_than_an_actuator_is_rated_for_are_said(small_run, sound, signal, tmp_path):
    words = ("--temperature", 20, "--out", tmp_path, "--json")
    told = json.loads(flex("render", sound, small_run.folder, *words).stdout)
    share = max(told["largest_v"][name] / told["rated_v"][name] for name in ("A1", "A2"))
    loud = tmp_path / "loud.wav"
    for level, said in ((0.99 / share, False), (1.25 / share, True)):
        soundfile.write(loud, level * signal, RATE, subtype="DOUBLE")
        result = flex("render", loud, small_run.folder, *words)
        assert result.exit_code == 0, result.output
        assert ("it is rated for" in result.stderr) == said
    level = float(result.stderr.partition("play this sound at ")[2].partition(" of its level or less")[0])
    assert 0.799 <= level <= 0.8  # rounded down: what is advised is no more than allowed


def test_silence_is_played_and_said(small_run, tmp_path):
    soundfile.write(tmp_path / "silence.wav", np.zeros(2 * RATE), RATE)
    result = flex("render", tmp_path / "silence.wav", small_run.folder, "--temperature", 20, "--json")
    assert result.exit_code == 0, result.output
    assert "silent in the panel's band" in result.stderr
    assert json.loads(result.stdout)["moments"][0]["contrast_sound"] is None
    for path in small_run.folder.glob("silence-rendered.*"):
        path.unlink()


def _write(path, samples, rate=RATE, **words):
    soundfile.write(path, samples, rate, **words)
    return path


@pytest.mark.parametrize(
    ("make", "temperature", "said"),
    [
        (
            lambda p: _write(p, np.zeros(100), 44_100),
            "20",
            "make filters of its rate: flexura focus with --sample-rate 44100, and after it flexura compensate",
        ),
        (
            lambda p: _write(p, np.append(np.zeros(900), np.nan), subtype="FLOAT"),
            "20",
            "sample 900, at 0.225 s, is NaN",
        ),
        (lambda p: _write(p, np.append(np.zeros(90), np.inf), subtype="FLOAT"), "20", "is infinite"),
        (lambda p: _write(p, np.zeros(0)), "20", "holds no samples"),
        (lambda p: p.write_bytes(b""), "20", "cannot be read as sound"),
        (lambda p: p.write_bytes(b"RIFF no sound at all"), "20", "cannot be read as sound"),
        (lambda p: p, "20", "a.wav: does not exist"),
        (
            lambda p: _write(p, np.zeros(100)),
            "20:61",
            "--temperature 61 °C is outside what the filters cover, 0 to 60",
        ),
        (lambda p: _write(p, np.zeros(100)), "warm", "neither °C"),
    ],
)
def test_what_is_wrong_is_one_sentence_and_nothing_is_written(small_run, tmp_path, make, temperature, said):
    path, out = tmp_path / "a.wav", tmp_path / "new" / "out"
    make(path)
    result = flex("render", path, small_run.folder, "--temperature", temperature, "--out", out)
    assert result.exit_code != 0
    assert said in result.output
    assert "Traceback" not in result.output
    assert not out.parent.exists()


def test_a_folder_that_was_there_stays_when_the_sound_is_refused(small_run, tmp_path):
    path, out = _write(tmp_path / "a.wav", np.append(np.zeros(900), np.nan), subtype="FLOAT"), tmp_path / "out"
    out.mkdir()
    assert "is NaN" in flex("render", path, small_run.folder, "--temperature", "20", "--out", out).output
    assert list(out.iterdir()) == []


def test_one_filter_is_played_as_far_as_the_laws_reach(small_run, sound, tmp_path):
    made = small_run.module.write_laws(tmp_path / "run", small_run.module.laws(10.0, 50.0))
    assert flex("focus", made, "--panel", small_run.panel, "--temperature", 20).exit_code == 0
    result = flex("render", sound, made, "--temperature", "20:55", "--out", tmp_path / "out")
    assert "--temperature 55 °C is outside what the laws cover, 10 to 50 °C" in result.output
    assert result.exit_code == 1
    assert not (tmp_path / "out").exists()


def test_a_file_that_was_cut_short_is_refused(small_run, sound, tmp_path):
    flac = tmp_path / "cut.flac"
    soundfile.write(flac, soundfile.read(sound)[0], RATE)
    held = flac.read_bytes()
    flac.write_bytes(held[: len(held) // 2])
    out = tmp_path / "out"
    result = flex("render", flac, small_run.folder, "--temperature", 20, "--out", out)
    assert result.exit_code != 0
    assert "cut.flac" in result.output
    assert not out.exists()


def test_the_renderer_s_blocks_do_not_matter(small_run, sound, tmp_path):
    found = []
    for block in (16, 4096):
        out = tmp_path / str(block)
        assert (
            flex("render", sound, small_run.folder, "--temperature", 40, "--block", block, "--out", out).exit_code
            == 0
        )
        found.append(wavfile.read(out / "noise-rendered.wav")[1])
    np.testing.assert_allclose(*found, atol=1e-6 * np.abs(found[0]).max())


def test_the_sound_at_listeners_is_the_panels_response_to_the_volts_in_pascals(small_run, sound, signal, tmp_path):
    out = tmp_path / "out"
    result = flex("render", sound, small_run.folder, "--temperature", 31.3, "--out", out, "--heard", "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    names = ["noise-heard.wav", "noise-heard-kept.wav", "noise-binaural.wav", "noise-binaural-kept.wav"]
    assert told["heard"] == [str(out / name) for name in names]
    assert "pascals (1 Pa per unit) at axis" in result.stderr
    heard, kept, ears, _ = (wavfile.read(out / name)[1] for name in names)
    volts = wavfile.read(out / "noise-rendered.wav")[1]
    np.testing.assert_array_equal(heard, kept)  # at a steady temperature they are the same filters
    assert told["loudest_pa"] == pytest.approx(np.abs(heard).max())
    panel, laws = load_panel(small_run.folder / "filters.h5"), load_laws(small_run.folder / "laws.h5")
    known = panel.plate.grown(laws)
    twin = panel_twin(panel, known, lambda _stage, _share: None)
    count = 40_000
    every = np.fft.rfftfreq(count, 1.0 / RATE)
    band = (every > panel.filters.band[0]) & (every < panel.filters.band[1])
    transfer = ListenersOfPanel.of(twin, panel, known).response(31.3, every[band])
    exact = np.einsum("lfn,fn->fl", transfer, np.fft.rfft(volts, count, axis=0)[band])
    for found, expected in ((heard[:, None], exact[:, :1]), (ears, exact[:, 1:])):
        spectrum = np.fft.rfft(found, count, axis=0)[band]
        error = np.linalg.norm(spectrum - expected) / np.linalg.norm(expected)
        assert error < 0.01
    np.testing.assert_allclose(ears[:, 0], ears[:, 1], atol=0.3 * np.abs(ears).max())  # it looks at the panel
    comment = (out / names[0]).read_bytes()
    place = comment.index(b"ICMT") + 8
    assert json.loads(comment[place : comment.index(b"\0", place)])["unit"] == "Pa"


def test_filters_that_follow_sound_more_even_than_those_of_the_beginning(small_run, sound, tmp_path):
    result = flex("render", sound, small_run.folder, "--temperature", "20:55", "--out", tmp_path, "--heard")
    assert result.exit_code == 0, result.output
    heard, kept = (wavfile.read(tmp_path / f"noise-{name}.wav")[1] for name in ("heard", "heard-kept"))
    assert heard.shape == kept.shape
    np.testing.assert_allclose(heard[:400], kept[:400], atol=1e-3 * np.abs(heard).max())
    assert np.abs(heard - kept)[-20_000:].max() > 0.05 * np.abs(heard).max()


def test_the_report_plays_both_pieces_from_within(small_run, sound, tmp_path):
    assert players(tmp_path) == []
    flex("render", sound, small_run.folder, "--temperature", "20:55", "--out", tmp_path, "--heard")
    before, after = players(tmp_path)
    assert "kept" in before.text
    assert "follow" in after.text
    pieces = [wavfile.read(io.BytesIO(base64.b64decode(one.data)))[1] for one in (before, after)]
    assert max(np.abs(piece).max() for piece in pieces) == pytest.approx(0.9 * 32_767, rel=0.02)
    assert not np.array_equal(*pieces)
    assert after.html().startswith("<figure><h3>after")
    assert 'src="data:audio/wav;base64,' in after.html()
    (tmp_path / "noise-heard.wav").write_bytes(b"RIFF and then nothing")
    with pytest.raises(
        ResultFileError, match=r"noise-heard.wav: cannot be read as sound .* flexura render --heard"
    ):
        players(tmp_path)


def test_the_library_writes_what_the_verb_writes(small_run, sound, tmp_path):
    ours = library.render(sound, small_run.folder, temperature="20:40", heard=True, out=tmp_path / "ours")
    words = ("--temperature", "20:40", "--heard", "--out", tmp_path / "theirs", "--json")
    result = flex("render", sound, small_run.folder, *words)
    assert result.exit_code == 0, result.output
    names = sorted(path.name for path in (tmp_path / "theirs").iterdir())
    assert names == sorted(path.name for path in (tmp_path / "ours").iterdir())
    assert len(names) == 6
    for name in names:
        assert (tmp_path / "ours" / name).read_bytes() == (tmp_path / "theirs" / name).read_bytes()
    assert ours.record()["moments"] == json.loads(result.stdout)["moments"]
    assert "contrast" in repr(ours)
    with pytest.raises(ResultFileError, match="one of temperature and weather"):
        library.render(sound, small_run.folder)
    with pytest.raises(ResultFileError, match=r"^block 8: allowed are 16 to 65536 samples"):
        library.render(sound, small_run.folder, temperature=20, block=8)
