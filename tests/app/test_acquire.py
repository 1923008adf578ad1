"""flexura acquire on the simulated rig, and what the rest of the program makes of its campaigns."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
from click.testing import CliRunner, Result
from threadpoolctl import threadpool_limits

import app.rig.assembly
from app.commands import acquire
from app.files.acquisition.events import append_event, read_events
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import frozen_protocol, write_protocol
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import read_acquired_experiment
from app.files.folder_lock import folder_lock
from app.main import flexura, main
from app.rig import doctor
from app.rig.assembly import rig_places
from app.rig.simulated_rig import parts_around
from drivers.ni.cards import Action, DaqError
from drivers.ni.simulated.faults import Faults
from drivers.rig import session as rest
from drivers.rig.end_requests import RigInterrupted, RigStopped
from drivers.rig.occupancy import device_names, occupied
from drivers.rig.simulated import SimulatedParts
from drivers.rig.survey import Finding, FindingState

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "simulated-rig.toml"
ENDED_BY = [
    getattr(signal, "SIGHUP", None),
    *(pytest.param(one, marks=pytest.mark.slow) for one in (signal.SIGINT, signal.SIGTERM)),
]


def experiment(folder: Path, *changes: tuple[str, str]) -> Path:
    """Write the example with a narrow band, quick to reduce, and four temperatures; further changes by pattern."""
    usual = (
        (r"^band = .*", "band = [100.0, 600.0]"),
        (r"^duration = .*", "duration = 1.0"),
        (r"^lowest = .*", "lowest = 15.0"),
        (r"^highest = .*", "highest = 45.0"),
        (r"^soak_before = .*", "soak_before = 300.0"),
        (r"^served = true", "served = false"),
    )
    text = EXAMPLE.read_text(encoding="utf-8")
    for pattern, replacement in (*usual, *changes):
        text, count = re.subn(pattern, replacement, text, count=1, flags=re.MULTILINE)
        assert count == 1, pattern
    file = folder / "mine.toml"
    file.write_text(text, encoding="utf-8")
    return file


def run(*words: object) -> Result:
    with threadpool_limits(1):
        return CliRunner().invoke(flexura, [str(word) for word in words])


@pytest.fixture(scope="module")
def acquired(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Result]:
    """Return an experiment and its undisturbed campaign."""
    file = experiment(tmp_path_factory.mktemp("acquired"))
    result = run("acquire", file, "--json")
    return file, file.with_name("mine-campaign"), result


def test_says_what_came_of_it(acquired: tuple[Path, Path, Result]) -> None:
    _, folder, result = acquired
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert (told["state"], told["rig"], told["sweeps"], told["finished"]) == ("complete", "simulated", 4, 4)
    assert Path(told["campaign"]) == folder
    assert "4 sweeps in" in result.stderr
    with h5py.File(folder / "index.h5") as index:
        assert len(index) == 4
        assert index["0001_up_T+025.0/drive"].shape[0] == 3


def test_the_laws_put_in_come_back(acquired: tuple[Path, Path, Result], tmp_path: Path) -> None:
    file, folder, _ = acquired
    result = run("update", folder, "--out", tmp_path / "run", "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    simulation = read_acquired_experiment(file).simulation
    assert simulation is not None
    assert abs(told["gain"] - simulation.gain) < 3.0 * told["sigma_gain"]  # d31 is declared to 5 % only
    assert told["gain"] == pytest.approx(simulation.gain, rel=0.03)
    for row in told["temperatures"]:
        truth = simulation.laws.laws().at(row["temperature_c"])
        assert abs(row["youngs_modulus_pa"] - truth.youngs_modulus[0]) < 3.0 * row["sigma"]["youngs_modulus_pa"]
        assert row["youngs_modulus_pa"] == pytest.approx(truth.youngs_modulus[0], rel=0.015)
        assert row["poisson_ratio"] == pytest.approx(truth.poisson_ratio[0], abs=0.01)
        assert row["loss_factor"] == pytest.approx(truth.loss_factor[0], rel=0.03)
        assert row["misfit"] < 1.5 * row["noise_floor"]


def test_again_changes_nothing(acquired: tuple[Path, Path, Result]) -> None:
    file, folder, _ = acquired
    before = {path: path.read_bytes() for path in folder.rglob("*.h5")}
    result = run("acquire", file)
    assert result.exit_code == 0
    assert "0 of them now" in result.stderr
    assert {path: path.read_bytes() for path in folder.rglob("*.h5")} == before


def test_over_a_loopback_port_the_same_sweeps_are_measured(
    acquired: tuple[Path, Path, Result], tmp_path: Path
) -> None:
    _, folder, _ = acquired
    served = experiment(tmp_path, (r"^served = false", "served = true"), (r"^highest = .*", "highest = 25.0"))
    assert run("acquire", served, "--out", tmp_path / "served").exit_code == 0
    first_two = load_campaign(folder).sweeps[:2]
    for here, there in zip(first_two, load_campaign(tmp_path / "served").sweeps, strict=True):
        np.testing.assert_array_equal(here.responses, there.responses)
        assert here.temperature == there.temperature


def test_missing_sweeps_make_it_not_good_enough(tmp_path: Path) -> None:
    """Asked for more coherence than the noise leaves, every sweep is rejected and put aside."""
    file = experiment(
        tmp_path, (r"^noise = .*", "noise = 0.02"), (r"^retries = 2", "retries = 1\ncoherence = 0.99")
    )
    result = run("acquire", file, "--out", tmp_path / "noisy", "--json")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["missing"] == 4
    said = [line for line in result.stderr.splitlines() if " of 4 sweeps" in line]
    assert "given up" not in said[0]  # done are sweeps that are there and such that are not
    counted = [re.search(r"(\d) of 4 sweeps, .*, (\d) given up, ", line).groups() for line in said[1:]]
    assert counted == [(f"{n}", f"{n}") for n in (1, 2, 3)]  # the last ends the campaign
    assert len(list((tmp_path / "noisy" / "rejected").iterdir())) == 8
    reasons = {event["why"] for event in read_events(tmp_path / "noisy") if event["event"] == "missing"}
    assert all("not coherent" in reason for reason in reasons)


def test_laws_that_do_not_reach_over_the_sweeps_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = "temperature = [-10.0, 0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 52.0, 54.0]"
    file = experiment(tmp_path, (r"^highest = .*", "highest = 55.0"), (r"^temperature = .*", short))
    with pytest.raises(SystemExit) as left:
        main(["acquire", str(file)])
    assert left.value.code == 2
    assert "simulation.laws.temperature = -10 to 54 °C" in capsys.readouterr().err


def test_a_mistyped_port_is_no_alarm_where_nothing_was_ever_begun(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = experiment(tmp_path, (r"^port = .*", 'port = "/dev/ttyNONE7"'))
    with pytest.raises(SystemExit) as left:
        main(["acquire", str(file), "--rig", "real"])
    assert left.value.code == 2
    said = capsys.readouterr().err
    assert "oven.port = '/dev/ttyNONE7': this computer has no such port; there are: " in said
    assert "Nothing was asked of oven or cards" in said
    assert "NOT AT REST" not in said
    assert not (tmp_path / "mine-campaign").exists()


def test_the_real_rig_is_refused_where_there_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its port exists, and nothing answers there: whether the oven is at rest is not known."""
    monkeypatch.setattr(rest, "ATTEMPTS", 1)
    silent = tmp_path / "port"
    silent.touch()
    result = run("acquire", experiment(tmp_path, (r"^port = .*", f'port = "{silent}"')), "--rig", "ni", "--json")
    assert result.exit_code == 3
    told = json.loads(result.stdout)
    assert "the rig cannot be opened" in told["why"]
    assert "NI-DAQmx" in told["unsafe"][1]
    assert not (tmp_path / "mine-campaign").exists()


@pytest.mark.skipif(os.name == "nt", reason="signals as POSIX has them")
@pytest.mark.parametrize(
    "number",
    ENDED_BY,
)
def test_a_signal_brings_everything_to_rest_and_the_command_goes_on(
    acquired: tuple[Path, Path, Result], tmp_path: Path, number: signal.Signals
) -> None:
    file, out = acquired[0], tmp_path / "broken-off"
    command = [sys.executable, "-m", "flexura", "acquire", str(file), "--out", str(out)]
    with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as child:
        _wait_for(lambda: len(list(out.glob("sweeps/*.h5"))) >= 1, child)
        child.send_signal(number)
        _, said = child.communicate(timeout=60)
    assert child.returncode == 128 + number, said
    assert "Traceback" not in said
    assert "stopped; the drive is at 0 V and the oven at rest; run the same command again to continue" in said
    last = [event for event in read_events(out) if event["event"] == "oven"][-1]
    assert (last["command"], last["unsafe"]) == ("safe", [])
    done = {path.name: path.read_bytes() for path in out.glob("sweeps/*.h5")}
    assert 1 <= len(done) < 4
    extent = load_campaign(out).extent  # not to be taken for a whole one
    assert extent is not None
    assert (extent.state, extent.sweeps, extent.asked) == ("interrupted", len(done), 4)
    assert run("acquire", file, "--out", out).exit_code == 0
    assert {path.name: path.read_bytes() for path in out.glob("sweeps/*.h5") if path.name in done} == done
    assert len(load_campaign(out).sweeps) == 4


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="signals as POSIX has them")
def test_a_campaign_whose_output_nobody_reads_any_more_ends_as_usual(
    acquired: tuple[Path, Path, Result], tmp_path: Path
) -> None:
    """As where ``2>&1 | tee log`` is ended by the Ctrl-C that is meant for the campaign."""
    file, out = acquired[0], tmp_path / "broken-off"
    command = [sys.executable, "-m", "flexura", "acquire", str(file), "--out", str(out), "--json"]
    reader, writer = os.pipe()
    with subprocess.Popen(command, cwd=ROOT, stdout=writer, stderr=writer, text=True) as child:
        os.close(writer)
        os.read(reader, 1)
        os.close(reader)
        _wait_for(lambda: len(list(out.glob("sweeps/*.h5"))) >= 2, child)
        child.send_signal(signal.SIGINT)
        assert child.wait(60) == 130
    assert "the drive is at 0 V and the oven at rest" in (out / "ending.txt").read_text()
    result = run("acquire", file, "--out", out)
    assert result.exit_code == 0, result.output
    assert not (out / "ending.txt").exists()


def _wait_for(condition: Callable[[], bool], child: "subprocess.Popen[str]") -> None:
    deadline = time.monotonic() + 90.0
    while not condition():
        assert child.poll() is None, "the campaign ended by itself"
        assert time.monotonic() < deadline
        time.sleep(0.002)


@pytest.mark.parametrize(
    ("error", "unsafe", "status", "said"),
    [
        (RigInterrupted("SIGHUP"), (), 129, "stopped; the drive is at 0 V and the oven at rest; run the same"),
        (
            RigInterrupted("SIGHUP"),
            ("the oven",),
            3,
            "stopped; run the same command again to continue\nNOT AT REST: the",
        ),
        (RigStopped("lost", "Look"), ("the oven",), 3, "stopped: lost. Look.\nNOT AT REST: the oven"),
        (RigStopped("lost", "Look"), (), 1, "stopped: lost. Look.\n"),
        (OSError(28, "No space"), ("the drive",), 3, "Make room, then run this again\nNOT AT REST: the drive"),
        (
            ValueError("Cannot invoke RPC"),
            ("the drive",),
            3,
            "defect of the program: ValueError: Cannot invoke RPC\nNOT",
        ),
        (ValueError("odd"), (), 1, "Traceback"),
        (
            ValueError("odd"),
            (),
            1,
            "defect of the program; the drive is at 0 V and the oven at rest: ValueError: odd",
        ),
        (CampaignFileError(Path("x"), []), ("the oven",), 3, "NOT AT REST: the oven"),
    ],
)
def test_whatever_ends_a_campaign_is_told_with_how_the_rig_was_left(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
    unsafe: tuple[str, ...],
    status: int,
    said: str,
) -> None:
    def ended(session: Any, *_: object) -> None:
        session.unsafe = unsafe
        if isinstance(error, RigInterrupted):
            signal.raise_signal(signal.SIGHUP)
        raise error

    monkeypatch.setattr(acquire, "_acquire", ended)
    result = run("acquire", experiment(tmp_path), "--json")
    told = json.loads(result.stdout)
    assert (told["state"], told["unsafe"], result.exit_code) == ("stopped", list(unsafe), status)
    assert said in result.stderr


def test_an_end_before_the_simulated_plate_is_made_says_that_nothing_was_begun(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(app.rig.assembly, "rig_of", stopped)
    result = run("acquire", experiment(tmp_path), "--out", tmp_path / "mine")
    assert result.exit_code != 0
    assert "note: nothing was begun: the simulated plate was still being made" in result.output
    assert not (tmp_path / "mine").exists()


def test_a_second_process_does_not_touch_the_rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is another's: neither oven nor cards are opened, let alone brought to rest."""
    touched: list[str] = []
    monkeypatch.setattr(SimulatedParts, "_open_cards", lambda self: touched.append("cards"))
    monkeypatch.setattr(SimulatedParts, "_open_oven", lambda self: touched.append("oven"))
    with folder_lock(tmp_path / "mine-campaign"):
        result = run("acquire", experiment(tmp_path))
    assert isinstance(result.exception, SystemExit)
    assert result.exit_code != 0
    assert "another process is writing it" in result.output
    assert touched == []


def test_safe_needs_no_campaign(tmp_path: Path) -> None:
    file = experiment(tmp_path, (r"^hottest = .*", "hottest = 20.0"))  # which acquire would refuse
    result = run("safe", file, "--json")
    assert (result.exit_code, json.loads(result.stdout)) == (0, {"rig": "simulated", "unsafe": []})
    assert "the oven is at rest and the drive at 0 V" in result.stderr


def test_safe_says_what_it_could_not_reach(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rest, "ATTEMPTS", 1)
    result = run("safe", experiment(tmp_path), "--rig", "ni", "--json")
    assert result.exit_code == 3
    oven, drive = json.loads(result.stdout)["unsafe"]
    assert "the oven could not be brought to rest" in oven
    assert "turn the amplifier off" in drive
    assert result.stderr.count("NOT AT REST: ") == 2


def test_help_is_quick_to_say_what_it_does() -> None:
    result = run("acquire", "--help")
    assert result.exit_code == 0
    assert "taken up" in result.output or "take it up" in result.output
    assert acquire.command.name == "acquire"


def test_a_rig_in_use_is_left_alone_from_whatever_folder(tmp_path: Path) -> None:
    """Its process is named; neither another campaign nor `safe` touches it, and nothing is written."""
    file = experiment(tmp_path)
    places = rig_places(read_acquired_experiment(file), "real")
    assert places == ("oven at simulated", "cards cDAQ1")
    with occupied(places[:1], "flexura acquire, campaign mine"):
        again = run("acquire", file, "--rig", "real", "--out", tmp_path / "elsewhere", "--json")
        safe = run("safe", file, "--rig", "real", "--json")
    for result, status in ((again, 1), (safe, 3)):
        assert result.exit_code == status, result.output
        assert f"in use by process {os.getpid()} (flexura acquire, campaign mine, since 2" in result.stderr
    assert "NOT AT REST: the oven at simulated is in use" in safe.stderr
    assert json.loads(again.stdout)["unsafe"] == []
    assert not (tmp_path / "elsewhere").exists()


@pytest.mark.skipif(os.name == "nt", reason="links as POSIX has them")
def test_a_port_of_two_names_is_one_port(tmp_path: Path) -> None:
    (tmp_path / "ttyUSB0").touch()
    (tmp_path / "by-id").symlink_to(tmp_path / "ttyUSB0")
    places = []
    for name in ("ttyUSB0", "by-id"):
        file = experiment(tmp_path, (r'^port = "simulated"', f'port = "{tmp_path / name}"'))
        places.append(rig_places(read_acquired_experiment(file), "real"))
    assert all(device_names(one) & device_names(two) for one, two in zip(*places, strict=True))
    assert rig_places(read_acquired_experiment(file), "simulated") == ()


def test_a_test_shot_tells_what_can_be_said_before_a_campaign(
    acquired: tuple[Path, Path, Result], tmp_path: Path
) -> None:
    file, _, _ = acquired  # its twin is there
    result = run("acquire", file, "--test-shot", "--out", tmp_path / "new", "--json")
    assert result.exit_code == 0, result.output
    told = {row["what"]: row for row in json.loads(result.stdout)["findings"]}
    assert told["campaign"]["seen"].startswith("4 sweeps, about ")
    assert " MB needed for the " in told["disk"]["seen"]
    assert "of the range, coherence 1.000" in told["input of drive"]["seen"]
    assert [name for name in told if name.startswith("input of ")][1:]
    assert "ready for" in result.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("lost", "status", "found"),
    [
        ("in mid-shot", 3, "shot"),
        ("while it is closed", 3, "input of S1"),
        ("and back", 0, "input of S1"),
    ],
)
def test_a_test_shot_says_whether_the_drive_is_at_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lost: str, status: int, found: str
) -> None:
    """A networked chassis that is lost: its error where it is closed may be of any class."""
    file = experiment(tmp_path)
    declared = read_acquired_experiment(file)
    assert declared.simulation is not None
    parts = parts_around(declared, declared.simulation, lambda drive, *_: 0.3 * drive[None], file)
    rig = parts.rig()
    opened: list[Any] = []

    def open_cards() -> Any:
        if opened and lost != "and back":
            raise DaqError("opening", "Device lost.", -201003, Action.LOST_DEVICE, "look")
        opened.append(rig.open_cards())
        if lost == "in mid-shot":
            parts.server.inject(Faults(unplugged=(parts.clock.now() + 0.5, 1e9)))
        elif len(opened) == 1:
            close = opened[0].close

            def closed() -> None:
                close()
                raise ValueError("Cannot invoke RPC on closed channel!")

            opened[0].close = closed
        return opened[-1]

    monkeypatch.setattr(acquire, "_open", lambda *_: nullcontext(replace(rig, open_cards=open_cards)))
    result = run("acquire", file, "--test-shot", "--json")
    assert result.exit_code == status, result.output
    said = json.loads(result.stdout)
    assert said["ready"] is (status == 0)
    assert said["findings"][-1]["what"] == found
    assert ["turn the amplifier off" in what for what in said["unsafe"]] == [True] * (status == 3)
    assert ("NOT AT REST: the drive" in result.stderr) is (status == 3)


@pytest.mark.parametrize("verb", ["--test-shot", "--again"])
def test_a_cable_that_is_off_is_told_before_the_oven_moves(
    acquired: tuple[Path, Path, Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, verb: str
) -> None:
    inner = SimulatedParts._open_cards

    def broken(parts: SimulatedParts) -> Any:
        parts.server.inject(Faults(dead_inputs=frozenset({"cDAQ1Mod1/ai0"})))
        return inner(parts)

    monkeypatch.setattr(SimulatedParts, "_open_cards", broken)
    for runs in (1, 2):  # nor does the same command, run again
        result = run("acquire", acquired[0], verb, "--out", tmp_path / "new", "--json")
        assert result.exit_code == 1
        assert "the drive recorded is not the one played" in result.stdout
        if verb == "--again":
            told = [event["command"] for event in read_events(tmp_path / "new") if event["event"] == "oven"]
            assert told == ["safe"] * runs


def test_too_small_a_disk_is_refused_before_a_twin_is_built(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=50_100_000))
    monkeypatch.setattr(acquire, "_open", None)
    with pytest.raises(SystemExit) as left:
        main(["acquire", str(experiment(tmp_path))])
    assert left.value.code == 2
    assert re.search(r"50 MB free.*allowed: 5\d MB for the 4 sweeps to be made", capsys.readouterr().err)


REFUSED = {
    "the disk is full": "MB free",
    "the experiment was changed": "different: title",
    "the lock cannot be written": "cannot be written: Is a directory",
}


@pytest.mark.parametrize("refused", REFUSED)
def test_a_rig_left_on_comes_to_rest_also_where_its_campaign_is_not_taken_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], refused: str
) -> None:
    """A campaign was killed in its ramp; the same command finds the folder as it cannot be used."""
    file = experiment(tmp_path)
    declared = read_acquired_experiment(file)
    assert declared.simulation is not None
    parts = parts_around(declared, declared.simulation, lambda drive, *_: np.zeros((2, drive.size)), file)
    monkeypatch.setattr(app.rig.assembly, "_real_rig", lambda _: parts.rig())
    acquired = declared.model_dump(mode="json") | {"rig": "real"}
    if refused == "the disk is full":
        monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    elif refused == "the experiment was changed":
        acquired["title"] = "another"
    else:
        (tmp_path / "mine-campaign.lock").mkdir()
    folder, recorded = tmp_path / "mine-campaign", declared.recorded(parts.rig().open_cards().sample_rate)
    write_protocol(folder, frozen_protocol(folder.name, recorded, {}, acquired))
    append_event(folder, {"event": "oven", "command": "ramp", "target": 45.0})
    parts.rig().open_oven().ramp_to(45.0, 1.0)
    with pytest.raises(SystemExit) as left:
        main(["acquire", str(file), "--rig", "real"])
    assert left.value.code == 2
    assert REFUSED[refused] in capsys.readouterr().err
    assert not parts.body.regulating
    assert [event["command"] for event in read_events(folder)] == ["ramp", "safe"]


def test_nothing_is_reduced_where_a_shot_cannot_succeed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(acquire, "_open", None)
    full = Finding("disk", FindingState.BAD, "0.0 GB free", "make room")
    monkeypatch.setattr(doctor, "look_at_disk", lambda *_: full)
    result = run("acquire", experiment(tmp_path), "--test-shot")
    assert result.exit_code == 1
    assert "make room" in result.output
    assert "not ready: disk" in result.output
