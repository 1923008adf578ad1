"""What cannot be a measurement, or is declared wrong: a sentence each, with the next step."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.app.modal_test.conftest import RATE

T = np.arange(800) / RATE
GOOD = {"t": T, "f": np.exp(-(((T - 0.02) / 1e-3) ** 2)), "y": np.exp(-20 * T) * np.sin(600 * T)}
CHANNELS = {
    "t": '{ role = "time" }',
    "f": '{ role = "drive", unit = "N" }',
    "y": '{ role = "response", sensitivity = "100 mV/g", unit = "V" }',
}
FRF_CHANNELS = {"freq": '{ role = "frequency" }', "H": '{ role = "frf" }'}
LINES = np.arange(1.0, 201.0)
H = 1.0 / (50.0**2 - LINES**2 + 2j * LINES)
CONJUGATE = 1.0 / (50.0**2 - LINES**2 - 9j * LINES)

Arrays = dict[str, np.ndarray]
Flexura = Callable[..., tuple[int, str, str]]


def declared(folder: Path, kind: str, arrays: Arrays, channels: dict[str, str], more: str = "") -> Path:
    np.savez(folder / "a.npz", **arrays)
    table = "".join(f"{name} = {value}\n" for name, value in channels.items())
    (folder / "test.toml").write_text(
        f'format = "flexura-test/1"\nkind = "{kind}"\n{more}\n[channels]\n{table}[[record]]\nfile = "a.npz"\n',
        encoding="utf-8",
    )
    return folder / "test.toml"


def spoilt(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Arrays:
    return GOOD | {name: change(GOOD[name].copy())}


def with_nan(signal: np.ndarray) -> np.ndarray:
    signal[17] = np.nan
    return signal


@pytest.mark.parametrize(
    ("arrays", "channels", "message"),
    [
        (spoilt("y", lambda y: 0 * y), {}, "'y': zero throughout; look at cable and sensor"),
        (spoilt("y", lambda y: 0 * y + 2.5), {}, "constant at 245.166"),
        (spoilt("y", with_nan), {}, "sample 18 of 800 is not a finite number (1 in all); export"),
        (
            {name: values[:9] for name, values in GOOD.items()},
            {},
            "'f': 9 of at least 16 samples; export the whole",
        ),
        (spoilt("y", lambda y: y[:700]), {}, "[700, 800] samples; all have to be as long: export"),
        (
            spoilt("t", lambda t: np.delete(np.append(t, t[-1] + 0.1), 400)),
            {},
            "samples are missing, or it was resampled; record",
        ),
        (spoilt("t", lambda t: 0 * t + np.arange(800) // 2), {}, "times do not rise"),
        (spoilt("f", lambda f: 1e-9 * f), {"trigger": 1}, "lower the trigger"),
        (
            GOOD,
            {"y": '{ role = "response", unit = "V" }'},
            'no sensitivity; give sensitivity, for example "100 mV/g"',
        ),
        (GOOD, {"y": '{ role = "response", unit = "furlong" }'}, "unit 'furlong' is not known; allowed: V, mV"),
        (GOOD, {"y": '{ role = "response" }'}, 'the file gives no unit; give unit, for example unit = "V"'),
        (GOOD, {"z": '{ role = "response", unit = "g" }'}, "no channel 'z'; it holds: t, f, y. Correct its name"),
        (GOOD, {"y": '{ role = "drive", unit = "N" }'}, "one with the role response are needed"),
        (GOOD, {"t": '{ role = "unused" }'}, "the files give no sample rate; give sample_rate"),
        (GOOD, {"y": '{ role = "respone", unit = "g" }'}, "'drive' or 'response'"),
    ],
)
def test_signals_that_are_no_measurement(
    tmp_path: Path, arrays: Arrays, channels: dict[str, object], message: str, run_flexura: Flexura
) -> None:
    changed = {name: text for name, text in channels.items() if name != "trigger"}
    table = {name: str(changed.get(name, text)) for name, text in (CHANNELS | changed).items()}
    more = "hammer = { trigger = 5.0 }" if "trigger" in channels else ""
    status, _, told = run_flexura("identify", declared(tmp_path, "hammer", arrays, table, more))
    assert status == 2, told
    assert message in told
    assert sorted(child.name for child in tmp_path.iterdir()) == ["a.npz", "test.toml"]


@pytest.mark.parametrize(
    ("frequency", "h", "message"),
    [
        (LINES, 0 * H, "zero on every line; check the channel"),
        (LINES, 0 * H + 1.0 + 1.0j, "the same value on every line"),
        (LINES, np.abs(H), "real values; an FRF needs its phase: export complex values"),
        (LINES, np.abs(H) + 0j, "real values; an FRF needs its phase"),
        (LINES, np.where(LINES == 9, np.nan, H), "not finite; export it again"),
        (
            LINES,
            1.0 / (50.0**2 - LINES**2 - 9j * LINES),
            "the phase rises through resonances, as with the time convention exp(-jwt)",
        ),
        (LINES, 1e300 * H, "allowed: 1e-50 to 1e+50: correct their units"),
        (LINES[:1], H[:1], "no column of numbers"),
        (LINES[:5], H[:5], "5 lines above 0 Hz; 8 at least"),
        (np.round(LINES / 3) * 3, H, "3 Hz occurs twice; export more digits"),
        (LINES - 100.0, H, "frequencies below 0 Hz; export the one-sided FRF"),
        (np.roll(LINES, 9), H, "frequencies go up and down; sort the lines"),
        (LINES[:150], H, "200 values at 150 frequencies; export both together"),
    ],
)
def test_frfs_that_are_none(
    tmp_path: Path, frequency: np.ndarray, h: np.ndarray, message: str, run_flexura: Flexura
) -> None:
    path = declared(tmp_path, "frf", {"freq": frequency, "H": h}, FRF_CHANNELS)
    status, _, told = run_flexura("identify", path)
    assert status == 2, told
    assert message in told


@pytest.mark.parametrize(
    ("coherence", "message"),
    [
        (np.full(200, 1.5), "coherence 'c': coherence from 1.5 to 1.5; 0 to 1 allowed; give it the role unused"),
        (np.full(150, 0.9), "150 values, the FRF 200; export both alike"),
    ],
)
def test_coherences_that_are_none(
    tmp_path: Path, coherence: np.ndarray, message: str, run_flexura: Flexura
) -> None:
    channels = FRF_CHANNELS | {"c": '{ role = "coherence" }'}
    path = declared(tmp_path, "frf", {"freq": LINES, "H": H, "c": coherence}, channels)
    status, _, told = run_flexura("identify", path)
    assert status == 2, told
    assert message in told


def test_a_coherence_of_one_throughout_is_noted(tmp_path: Path, run_flexura: Flexura) -> None:
    channels = FRF_CHANNELS | {"c": '{ role = "coherence" }'}
    path = declared(tmp_path, "frf", {"freq": LINES, "H": H, "c": np.ones(200)}, channels)
    status, _, told = run_flexura("identify", path)
    assert status in (0, 1), told
    assert "coherence 1 on every line, as after one average, gives no noise" in told


def test_a_table_is_declared_before_it_is_identified(tmp_path: Path, run_flexura: Flexura) -> None:
    np.savetxt(tmp_path / "hits.csv", np.random.default_rng(0).random((9, 3)), delimiter=",")
    status, _, told = run_flexura("identify", tmp_path / "hits.csv")
    assert status == 2
    assert f"declared first: flexura new test {tmp_path / 'hits.csv'}" in told


def test_eight_lines_are_enough(tmp_path: Path, run_flexura: Flexura) -> None:
    few = slice(46, 54)
    path = declared(tmp_path, "frf", {"freq": LINES[few], "H": H[few]}, FRF_CHANNELS)
    assert run_flexura("identify", path, "--out", tmp_path / "run", "-q") == (0, "", "")
    assert run_flexura("report", tmp_path / "run", "-q")[0] == 0


def test_noise_alone_has_no_modes_and_a_whole_run_folder(tmp_path: Path, run_flexura: Flexura) -> None:
    """Status 1, and files that the report takes."""
    noise = np.random.default_rng(0).standard_normal((2, 2, 200))
    channels = {"freq": '{ role = "frequency" }', '"H[1]"': '{ role = "frf" }', '"H[2]"': '{ role = "frf" }'}
    path = declared(tmp_path, "frf", {"freq": LINES, "H": noise[0] + 1j * noise[1]}, channels)
    status, out, told = run_flexura("identify", path, "--out", tmp_path / "run", "--json")
    assert (status, json.loads(out)["modes"]) == (1, []), told
    assert "\n    55\n" not in (tmp_path / "run" / "modes.uff").read_text(encoding="ascii")  # geometry, no shape
    assert run_flexura("report", tmp_path / "run", "-q")[0] == 0


def test_a_band_without_lines_and_words_that_do_not_fit(tmp_path: Path, run_flexura: Flexura) -> None:
    path = declared(tmp_path, "frf", {"freq": LINES, "H": H}, FRF_CHANNELS)
    status, _, told = run_flexura("identify", path, "--band", 500, 600)
    assert status == 2
    assert "Allowed: within 1 to 200 Hz, at least 8 Hz wide" in told
    for words in (("--shared-poles",), ("--export", "x.uff")):
        status, _, told = run_flexura("identify", path, *words)
        assert status == 2
        assert "always share poles" in told


def test_verbs_that_need_a_campaign_say_what_takes_a_test(tmp_path: Path, run_flexura: Flexura) -> None:
    path = declared(tmp_path, "frf", {"freq": LINES, "H": H}, FRF_CHANNELS)
    for given in (path, tmp_path):
        status, _, told = run_flexura("update", given)
        assert status == 2
        assert f"declares a modal test; flexura identify {given} finds its modes" in told
        assert f"flexura new plate {path}" in told


def test_a_place_for_results_is_tried_before_anything_is_read(tmp_path: Path, run_flexura: Flexura) -> None:
    """The file holds no FRF: that would be the message, were it read first."""
    frfs, taken = tmp_path / "frfs.uff", tmp_path / "taken"
    frfs.write_text("nothing\n", encoding="utf-8")
    taken.write_text("a file", encoding="utf-8")
    status, _, err = run_flexura("identify", frfs, "--shared-poles", "--out", taken / "run")
    assert status == 2
    assert "name another with --out" in err
    status, _, err = run_flexura("identify", frfs, "--shared-poles", "--out", tmp_path / "new" / "run")
    assert status == 2
    assert "--out" not in err
    assert not (tmp_path / "new").exists()


def test_an_unknown_unit_of_frfs_is_named_with_its_key(tmp_path: Path, run_flexura: Flexura) -> None:
    path = declared(tmp_path, "frf", {"freq": LINES, "H": H}, FRF_CHANNELS, 'frf = { response = "furlong" }')
    status, _, told = run_flexura("identify", path)
    assert status == 2
    assert "frf.response: unit 'furlong' is not known; allowed: V, mV" in told


def test_two_frfs_between_the_same_ends_are_refused(tmp_path: Path, run_flexura: Flexura) -> None:
    """Their residues would share one place of the shapes."""
    channels = FRF_CHANNELS | {"H2": '{ role = "frf", at = "1:+z" }'}
    path = declared(tmp_path, "frf", {"freq": LINES, "H": H, "H2": -H}, channels)
    status, _, told = run_flexura("identify", path)
    assert status == 2
    assert "node 1:+3 answers node 1:+3 more than once" in told
    assert "say where each was measured, by `at`" in told


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ('format = "flexura-test/1"\nkind = [\n', "my.toml: line 2"),
        (
            'format = "flexura-test/2"\n',
            "format = 'flexura-test/2'; allowed: \"flexura-test/1\" of a modal",
        ),
        ('kind = "hammer"\n', "my.toml: format = None; allowed"),
    ],
)
def test_a_declaration_of_any_name_is_told_what_is_wrong_with_it(
    tmp_path: Path, content: str, message: str, run_flexura: Flexura
) -> None:
    (tmp_path / "my.toml").write_text(content, encoding="utf-8")
    status, _, told = run_flexura("identify", tmp_path / "my.toml")
    assert status == 2
    assert message in " ".join(told.split())
