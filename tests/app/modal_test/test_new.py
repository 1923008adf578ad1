"""Declarations that ``flexura new`` writes are read by the verbs they are for."""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, RootObject, TdmsWriter

from app.files.campaigns.channels import RecorderLayout, read_experiment
from app.files.declarations.modal_test import read_modal_test
from tests.app.modal_test.conftest import Beam, hammer_files

Flexura = Callable[..., tuple[int, str, str]]


def test_a_hammer_test_is_declared_from_its_files(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    hammer_files(tmp_path, beam, seconds=1.0, count=1).unlink()
    files = sorted(tmp_path.glob("*.csv"))
    words = ["--roving", "Hammer", "--drive", "Hammer=2.25 mV/N", "--response", "Acc=100 mV/g", "--json"]
    status, out, err = run_flexura("new", "test", *files, *words)
    assert status == 0, err
    assert json.loads(out)["channels"] == {"Time": "time", "Hammer": "drive", "Acc": "response"}
    test = read_modal_test(tmp_path / "test.toml")
    assert (test.kind, len(test.record), test.title) == ("hammer", 5, tmp_path.name)
    assert run_flexura("new", "test", *files, "--roving", "Hammer", "--out", tmp_path / "beam.toml", "-q")[0] == 0
    assert read_modal_test(tmp_path / "beam.toml").title == "beam"
    assert test.record[3].at == {"Hammer": "4:+z"}
    assert test.channels["Acc"].calibration("V").quantity == "acceleration"
    status, _, err = run_flexura("new", "test", *files)
    assert status == 2
    assert "is there already; name another or remove it" in err


def test_volts_without_a_sensitivity_are_named(tmp_path: Path, beam: Beam, run_flexura: Flexura) -> None:
    hammer_files(tmp_path, beam, seconds=1.0, count=1).unlink()
    status, _, err = run_flexura("new", "test", tmp_path / "point1.csv", "--out", tmp_path / "a.toml")
    assert status == 0
    assert "note: channel 'Acc' is in volts: give its sensitivity" in err
    status, _, err = run_flexura("identify", tmp_path / "a.toml")
    assert status == 2
    assert 'channels.Acc: in V, and no sensitivity; give sensitivity, for example "100 mV/g"' in err


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("Nm", "Hammer=Nm: unit 'Nm' is not known; allowed: V, mV"),
        ("0 mV/N", "Hammer=0 mV/N: sensitivity '0 mV/N': a number other than 0"),
        ("5 pC/N", "Hammer=5 pC/N: sensitivity '5 pC/N' gives pC, but the file is in V"),
    ],
)
def test_a_calibration_that_is_none_is_refused_at_once(
    tmp_path: Path, beam: Beam, run_flexura: Flexura, given: str, message: str
) -> None:
    hammer_files(tmp_path, beam, seconds=1.0, count=1).unlink()
    status, _, err = run_flexura("new", "test", tmp_path / "point1.csv", "--drive", f"Hammer={given}")
    assert status == 2
    assert message in err
    assert not (tmp_path / "test.toml").exists()


def test_tables_of_single_frfs_are_declared_with_a_moved_hammer(tmp_path: Path, run_flexura: Flexura) -> None:
    for name in ("a.txt", "b.txt"):
        np.savetxt(tmp_path / name, np.random.default_rng(0).random((9, 3)), header="Freq Real Imag", comments="")
    status, _, err = run_flexura("new", "test", tmp_path / "a.txt", tmp_path / "b.txt", "--roving", "reference")
    assert status == 0, err
    test = read_modal_test(tmp_path / "test.toml")
    assert (test.kind, test.record[1].at) == ("frf", {"reference": "2:+z"})


@pytest.mark.parametrize("step", [1, -1])
def test_an_frf_without_names_may_have_uneven_lines(tmp_path: Path, run_flexura: Flexura, step: int) -> None:
    """Lines of a sine stepped up or down; the column of a record's times, though, is even and rises."""
    lines = np.concatenate([np.arange(20.0, 90.0, 4.0), np.arange(90.0, 110.0, 0.5), np.arange(110.0, 200.0, 4.0)])
    lines = lines[::step]
    h = 1.0 / (100.0**2 - lines**2 + 4j * lines)
    np.savetxt(tmp_path / "a.csv", np.column_stack([lines, h.real, h.imag]), delimiter=",")
    status, _, told = run_flexura("new", "test", tmp_path / "a.csv", "--kind", "frf", "--out", tmp_path / "test")
    assert status == 0, told
    roles = {name: one.role for name, one in read_modal_test(tmp_path / "test" / "test.toml").channels.items()}
    assert roles == {"1": "frequency", "2": "real", "3": "imaginary"}


def test_frfs_in_an_array_of_three_axes_have_their_response_and_reference(
    tmp_path: Path, run_flexura: Flexura
) -> None:
    np.savez(tmp_path / "a.npz", freq=np.arange(1.0, 50.0), H=np.ones((49, 3, 2)) * 1j)
    assert run_flexura("new", "test", tmp_path / "a.npz", "-q") == (0, "", "")
    channels = read_modal_test(tmp_path / "test.toml").channels
    assert [(one.at, one.reference) for one in channels.values() if one.role == "frf"] == [
        (f"{k}:+z", f"{m}:+z") for k in (1, 2, 3) for m in (1, 2)
    ]


def test_frfs_with_points_are_declared(tmp_path: Path, run_flexura: Flexura) -> None:
    np.savez(tmp_path / "a.npz", freq=np.arange(1.0, 50.0), H=np.ones((3, 49)) * 1j)
    (tmp_path / "points.csv").write_text("node,x,y,z\n1,0,0,0\n2,0.1,0,0\n3,0.2,0,0.5\n", encoding="utf-8")
    words = ("--points", tmp_path / "points.csv", "--frf-units", "mm/s", "N", "-q")
    assert run_flexura("new", "test", tmp_path / "a.npz", *words) == (0, "", "")
    test = read_modal_test(tmp_path / "test.toml")
    assert (test.kind, test.frf.response) == ("frf", "mm/s")
    assert [test.channels[f"H[{n}]"].at for n in (1, 2, 3)] == ["1:+z", "2:+z", "3:+z"]
    assert test.points["3"] == (0.2, 0.0, 0.5)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("nan,0,0,0", "row 2: node nan at 0, 0, 0; allowed: a whole number from 1"),
        ("2,nan,0,0", "row 2: node 2 at nan, 0, 0; allowed: a whole number from 1"),
        ("2.5,0,0,0", "row 2: node 2.5 at"),
        ("1,0,0,0", "row 2: node 1 occurs twice"),
    ],
)
def test_places_that_are_none_are_named(tmp_path: Path, row: str, message: str, run_flexura: Flexura) -> None:
    np.savez(tmp_path / "a.npz", freq=np.arange(1.0, 50.0), H=np.ones(49) * 1j)
    (tmp_path / "points.csv").write_text(f"1,0,0,0\n{row}\n", encoding="utf-8")
    status, _, err = run_flexura("new", "test", tmp_path / "a.npz", "--points", tmp_path / "points.csv")
    assert status == 2
    assert message in err
    assert not (tmp_path / "test.toml").exists()


def test_the_sample_rate_is_not_taken_from_an_offset(tmp_path: Path, run_flexura: Flexura) -> None:
    noise = np.random.default_rng(0).standard_normal((2, 99))
    np.savez(tmp_path / "a.npz", offset=3.0, fs=1000.0, force=noise[0], acc=noise[1])
    status, _, err = run_flexura("new", "test", tmp_path / "a.npz")
    assert status == 0, err
    assert read_modal_test(tmp_path / "test.toml").sample_rate == "fs"


def test_a_channel_s_own_name_goes_before_a_pattern(tmp_path: Path, run_flexura: Flexura) -> None:
    np.savez(tmp_path / "a.npz", fs=1000.0, force=np.ones(99), acc=np.ones((2, 99)))
    words = ("--drive", "force=N", "--response", "acc*=V", "--response", "acc[2]=100 mV/g")
    status, _, err = run_flexura("new", "test", tmp_path / "a.npz", *words)
    assert status == 0, err
    channels = read_modal_test(tmp_path / "test.toml").channels
    assert [channels[f"acc[{n}]"].sensitivity for n in (1, 2)] == [None, "100 mV/g"]


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path, run_flexura: Flexura) -> None:
    np.savez(tmp_path / "a.npz", fs=1000.0, force=np.ones(99), acc=np.ones(99))
    for words in (("test", tmp_path / "a.npz"), ("campaign",)):
        status, _, err = run_flexura("new", *words, "--out", tmp_path / "a.npz" / "deeper")
        assert status == 2
        assert "cannot be written (Not a directory)" in err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("test",), "type: flexura new test FILE"),
        (("test", "absent.csv"), "absent.csv: does not exist"),
        (("test", "FILE", "--drive", "Hamer"), "no channel 'Hamer'; it holds: 1, 2"),
        (("test", "FILE", "--kind", "hammer"), "name it with --drive NAME=SENSITIVITY"),
        (("campaign", "FILE"), "sweeps of a campaign are TDMS files"),
    ],
)
def test_what_cannot_be_declared_says_what_to_type(
    tmp_path: Path, words: tuple[str, ...], message: str, run_flexura: Flexura
) -> None:
    np.savetxt(tmp_path / "a.csv", np.ones((9, 2)), delimiter=",")
    status, _, err = run_flexura("new", *(str(tmp_path / "a.csv") if word == "FILE" else word for word in words))
    assert status == 2
    assert message in err
    assert [child.name for child in tmp_path.iterdir()] == ["a.csv"]


def test_a_campaign_to_start_from_can_be_read(tmp_path: Path, run_flexura: Flexura) -> None:
    folder = tmp_path / "mine"
    status, _, err = run_flexura("new", "campaign", "--plate", 0.4, 0.3, 0.003, 0.33, "--out", folder)
    assert status == 0
    assert "flexura import" in err
    plate = read_experiment(folder).plate
    assert (plate.length_x, plate.mass) == (0.4, 0.33)
    status, _, err = run_flexura("new", "campaign", "--out", folder)
    assert status == 2
    assert "is there already" in err


CHANNELS = {"Room": "V", "cDAQ1Mod1/ai0": "V", "cDAQ1Mod2/ai0": "V", "Accel": "", "Bare": ""}
"""Of a recorder, with the units that its files tell; the room is recorded at a hundredth of the rate."""


def recorder_files(folder: Path, *, groups: tuple[str, ...]) -> list[Path]:
    """Two sweeps as a recorder leaves them: channels of its own names and rates."""
    folder.mkdir(parents=True)
    samples = np.random.default_rng(0).normal(size=20480)
    for name in ("plate_20.5C.tdms", "last.tdms"):
        objects = [
            ChannelObject(
                group,
                channel,
                samples,
                {"wf_increment": (300.0 if channel == "Room" else 3.0) / 25600.0}
                | ({"unit_string": unit} if unit else {}),
            )
            for group in groups
            for channel, unit in CHANNELS.items()
        ]
        with TdmsWriter(folder / name) as writer:
            writer.write_segment([RootObject({}), *objects])
    return sorted(folder.iterdir())


@pytest.mark.parametrize("groups", [("Log",), ("first", "second", "third")])
def test_a_campaign_is_declared_from_a_recorders_files(
    tmp_path: Path, run_flexura: Flexura, groups: tuple[str, ...]
) -> None:
    folder = tmp_path / "plate"
    files = recorder_files(folder / "sweeps", groups=groups)
    words = ["--drive", "cDAQ1Mod1/ai0=50 mV/V", "--response", "Accel=100 mV/g", "--unused", "Room"]
    status, _, err = run_flexura("new", "campaign", *files, *words, "--out", folder)
    assert status == 0, err
    assert "'Accel' is read at S2: declare a patch or sensor of that id" in err
    assert "'Bare': the file gives no unit; V is assumed" in err
    assert "'Accel': the file gives no unit" not in err
    assert "'last.tdms': its name gives no temperature" in err
    table = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))
    assert table["acquisition"]["sample_rate"] == pytest.approx(25600.0 / 3.0)
    layout = RecorderLayout(channels=table["channels"], sweeps=table["sweeps"])
    assert list(layout.channels) == list(CHANNELS)
    assert layout.channels["Accel"].sensitivity == "100 mV/g"
    assert [one.temperature for one in layout.sweeps.values()] == [20.0, 20.5]
    assert "no channel" not in str(
        layout.problems("campaign.toml", read_experiment(folder), [f.name for f in files])
    )


def test_sweeps_that_lie_elsewhere_are_told_where_they_belong(tmp_path: Path, run_flexura: Flexura) -> None:
    """Nothing said so before import found none; without --out the declaration was in the current folder."""
    files = recorder_files(tmp_path / "plate" / "sweeps", groups=("Log",))
    words = ["--drive", "cDAQ1Mod1/ai0=50 mV/V"]
    status, _, err = run_flexura("new", "campaign", *files, *words)
    assert status == 0
    assert (tmp_path / "plate" / "campaign.toml").is_file()
    assert "sweeps are read from" not in err
    files = recorder_files(tmp_path / "log", groups=("Log",))
    status, _, err = run_flexura("new", "campaign", *files, *words)
    assert status == 0
    assert (tmp_path / "log" / "campaign.toml").is_file()
    assert f"sweeps are read from {tmp_path / 'log' / 'sweeps'}: put 2 files there" in " ".join(err.split())


def test_a_recorder_without_a_drive_is_told_how_to_name_it(tmp_path: Path, run_flexura: Flexura) -> None:
    files = recorder_files(tmp_path / "plate" / "sweeps", groups=("Log",))
    status, _, err = run_flexura("new", "campaign", *files, "--out", tmp_path / "plate")
    assert status == 2
    assert "one drive needed, found none; name it with --drive NAME. It holds: Room, cDAQ1Mod1/ai0" in err


def test_the_file_that_is_no_sweep_is_named(tmp_path: Path, run_flexura: Flexura) -> None:
    files = recorder_files(tmp_path / "plate" / "sweeps", groups=("Log",))
    (tmp_path / "notes.csv").write_text("1,2")
    status, _, err = run_flexura("new", "campaign", *files, tmp_path / "notes.csv", "--out", tmp_path / "plate")
    assert status == 2
    assert "notes.csv: sweeps of a campaign are TDMS files" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("campaign", "--kind", "hammer"), "--kind: belongs to a test"),
        (("campaign", "--rate", 1000.0), "--rate: belongs to a test"),
        (("campaign", "--roving", "Hammer"), "--roving: belongs to a test"),
        (("campaign", "--points", "FILE"), "--points: belongs to a test"),
        (("campaign", "--frf-units", "m/s2", "N"), "--frf-units: belongs to a test"),
        (("campaign", "--drive", "Force"), "--drive: names a channel of the recorders TDMS files"),
        (("test", "FILE", "--plate", 0.4, 0.3, 0.003, 0.33), "--plate: belongs to a campaign"),
    ],
)
def test_an_option_of_the_other_kind_is_refused(
    tmp_path: Path, words: tuple[object, ...], said: str, run_flexura: Flexura
) -> None:
    file = tmp_path / "a.csv"
    file.write_text("1,2\n", encoding="utf-8")
    status, _, err = run_flexura("new", *(file if word == "FILE" else word for word in words), "--out", tmp_path)
    assert status == 2
    assert said in " ".join(err.replace("'", "").split())
    assert not list(tmp_path.glob("*.toml"))
