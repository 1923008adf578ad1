"""A hammer test at the set-points of an oven: held, rejected where the plate drifts, taken up again, at rest."""

import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from analysis.arrays import Real
from analysis.recordings.frf import campaign_frf
from app.chain.work import campaign_hashes
from app.files.acquisition.events import append_event, read_events
from app.files.atomic import atomic_hdf5
from app.files.campaign_error import CampaignFileError
from app.files.declarations.hammer_experiment import HammerExperiment, read_hammer_experiment
from app.files.declarations.plate import read_plate_measurement
from app.files.hdf5_file import opened_hdf5
from app.main import flexura
from app.modal_test.declared_test import declared_frfs
from app.plate_frfs.given_campaign import read_plate
from app.rig.assembly import SimulatedHammerRig
from drivers.hammer.campaign import HeldPlate, Key
from drivers.hammer.judged_hit import HitTemperature
from drivers.ni.daqmx import EndlessInputs
from drivers.rig.end_requests import RigStopped
from tests.app.hammer_bench import EXAMPLE, acquire, text_with_oven


@pytest.fixture
def declared(tmp_path: Path) -> HammerExperiment:
    file = tmp_path / "oven.toml"
    file.write_text(text_with_oven(), encoding="utf-8")
    return read_hammer_experiment(file)


def test_every_set_point_is_held_while_it_is_hit(declared: HammerExperiment, tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    outcome, _, parts = acquire(declared, folder)
    assert (outcome.accepted, outcome.missing) == (3 * 9 * 2, 0)
    found = [event for event in read_events(folder) if event["event"] == "hit"]
    for event in found:
        target = (25.0, 35.0, 30.0)[event["set_point"]]
        assert event["temperature"] == pytest.approx(target, abs=0.5)
    commands = [(e["command"], e.get("target")) for e in read_events(folder) if e["event"] == "oven"]
    assert commands == [("ramp", 25.0), ("ramp", 35.0), ("ramp", 30.0), ("safe", None)]
    assert parts.oven is not None
    assert not parts.oven.body.regulating
    said, rest = read_plate_measurement(folder / "plate.toml")
    assert [one.file for one in said.frf] == [f"set-point-{number}.toml" for number in (1, 2, 3)]
    assert rest["oven"]["room_temperature"] == 22.0
    campaign = read_plate(folder)
    assert np.round([sweep.temperature for sweep in campaign.sweeps]).tolist() == [25.0, 30.0, 35.0]


def test_stopped_at_the_second_set_point_and_taken_up_again(declared: HammerExperiment, tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    keys: Iterator[Key | None] = iter(["stop"])
    enough = 9 * 2 + 5

    def key() -> Key | None:
        kept = list((folder / "hits").glob("*.h5")) if folder.exists() else []
        return next(keys, None) if len(kept) == enough else None

    outcome, _, _ = acquire(declared, folder, key)
    assert outcome.stopped
    assert outcome.accepted == enough
    before = {path.name: path.read_bytes() for path in (folder / "hits").glob("*.h5")}
    outcome, heard, _ = acquire(declared, folder)
    assert (outcome.accepted, outcome.made_now) == (54, 54 - enough)
    assert (heard.places[0].set_point, heard.places[0].point) == (1, 2)
    assert before.items() <= {path.name: path.read_bytes() for path in (folder / "hits").glob("*.h5")}.items()
    times = [event["time"] for event in read_events(folder)]
    assert times == sorted(times)  # simulated time goes on


def test_a_hit_on_a_plate_that_drifted_is_rejected_and_the_set_point_settled_again(
    declared: HammerExperiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "hits"
    true, asked = HeldPlate.temperature, iter([HitTemperature(26.0), HitTemperature(float("nan"))])
    monkeypatch.setattr(HeldPlate, "temperature", lambda self: next(asked, None) or true(self))
    outcome, heard, _ = acquire(declared, folder)
    assert outcome.missing == 0
    said = [hit.rejected for hit in heard.hits[:2]]
    assert "the plate is at 26.00 °C; 24.5 to 25.5 °C wanted" in said[0]
    assert "no temperature" in said[1]
    ramps = [e["target"] for e in read_events(folder) if e.get("command") == "ramp"]
    assert ramps == [25.0, 25.0, 25.0, 35.0, 30.0]


def test_an_oven_that_cannot_hold_is_told(
    declared: HammerExperiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(HeldPlate, "temperature", lambda self: HitTemperature(27.0))
    with pytest.raises(RigStopped, match="Can the oven hold it"):
        acquire(declared, tmp_path / "hits")


def test_set_points_close_together_and_a_single_one(tmp_path: Path) -> None:
    for number, temperatures in enumerate(("[25.0, 26.5]", "[25.0]")):
        file = tmp_path / "close.toml"
        file.write_text(text_with_oven().replace("[25.0, 35.0, 30.0]", temperatures), encoding="utf-8")
        declared = read_hammer_experiment(file)
        few = declared.model_copy(update={"hammer": declared.hammer.model_copy(update={"hits": 1})})
        outcome, _, _ = acquire(few, tmp_path / f"hits-{number}")
        assert (outcome.accepted, outcome.missing) == (9 * (2 - number), 0)


def test_a_thermocouple_that_drifts_puts_hits_in_doubt(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each hit is within half a kelvin, or is told, also where the set-points are held loosely."""
    file = tmp_path / "oven.toml"
    file.write_text(text_with_oven().replace("soak = 300.0", "soak = 300.0\nwithin = 2.0"), encoding="utf-8")
    read_in = read_hammer_experiment(file)
    declared = read_in.model_copy(update={"hammer": read_in.hammer.model_copy(update={"hits": 1})})
    true: dict[int, float] = {}
    read, mark = EndlessInputs.temperatures, HeldPlate.mark
    rigs: list[SimulatedHammerRig] = []

    def drifting(self: EndlessInputs) -> Real:
        return read(self) + 4.0 * rigs[-1].clock.now() / 3600.0

    def noted(self: HeldPlate, number: int) -> None:
        assert rigs[-1].oven is not None
        true[number] = rigs[-1].oven.body.plate
        mark(self, number)

    monkeypatch.setattr(EndlessInputs, "temperatures", drifting)
    monkeypatch.setattr(HeldPlate, "mark", noted)
    with pytest.raises(RigStopped, match="it drifts"):  # in the end it does not come to rest at a set-point
        acquire(declared, tmp_path / "hits", prepare=rigs.append)
    events = read_events(tmp_path / "hits")
    labels = {event["step"]: event["temperature"] for event in events if event["event"] == "hit"}
    told = {event["step"] for event in events if event["event"] == "hit" and event.get("doubt")}
    told |= {event["step"] for event in events if event["event"] == "temperature in doubt" and "step" in event}
    wrong = {step for step, label in labels.items() if abs(label - true[step]) > 0.5}
    assert wrong
    assert wrong <= told
    for path in (tmp_path / "hits" / "hits").glob("*.h5"):
        with opened_hdf5(path) as file:
            at_once = {e["step"]: e["doubt"] for e in events if e["event"] == "hit" and e.get("doubt")}
            assert file.attrs.get("doubt") == at_once.get(int(file.attrs["number"]))
    said = "\n".join(note for note in read_plate(tmp_path / "hits").notes if "in doubt" in note)
    assert [step for step in sorted(wrong) if f"hit {step} (point" in said]
    assert all(int(number) in told for number in re.findall(r"hit (\d+) \(point", said))


def test_a_sound_thermocouple_is_not_doubted(declared: HammerExperiment, tmp_path: Path) -> None:
    outcome, heard, _ = acquire(declared, tmp_path / "hits")
    assert outcome.doubted == 0
    assert not [hit.doubt for hit in heard.hits if hit.doubt]
    assert "in doubt" not in "".join(read_plate(tmp_path / "hits").notes)


def test_verbs_repeat_doubts_of_the_hits_that_count(declared: HammerExperiment, tmp_path: Path) -> None:
    """Those in a hit's file, those that came later, which are in the log alone; not those of hits undone since."""
    folder, keys = tmp_path / "hits", iter(["undo"])
    acquire(declared, folder, lambda: next(keys, None) if list(folder.glob("hits/*.h5")) else None)
    undone = [event["step"] for event in read_events(folder) if event["event"] == "hit undone"]
    assert undone == [0]
    path = sorted((folder / "hits").glob("*.h5"))[20]
    with opened_hdf5(path) as file, atomic_hdf5(path) as doubted:
        for name, value in {**file.attrs, "doubt": "reads 25.0 °C; 44.1 °C is likely"}.items():
            doubted.attrs[name] = value
        for name in file:
            file.copy(name, doubted)
        number, point = int(file.attrs["number"]), int(file.attrs["point"])
    before = campaign_hashes(folder)
    for step, why in ((0, "undone"), (3, "drifts")):
        append_event(folder, {"event": "temperature in doubt", "step": step, "what": [why], "leg": 0})
    append_event(folder, {"event": "temperature in doubt", "what": ["told live, of no hit"], "leg": 0})
    assert campaign_hashes(folder) != before  # `flexura run` makes its results anew
    campaign = read_plate(folder)
    said = [note for note in campaign.notes if "in doubt" in note]
    assert len(said) == 2
    assert re.fullmatch(r"the temperature of hit 3 \(point 2, 2[45]\.\d °C\) is in doubt: drifts", said[0])
    assert said[1].startswith(f"the temperature of hit {number} (point {point + 1}, ")
    assert said[1].endswith("reads 25.0 °C; 44.1 °C is likely")
    assert campaign_frf(campaign).notes[: len(campaign.notes)] == campaign.notes  # what update and gap say
    assert said[0] in declared_frfs(folder / "set-point-1.toml", lambda *_: None).notes  # what identify says


def test_an_oven_is_not_held_for_ever_where_nobody_hits(
    declared: HammerExperiment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("drivers.hammer.campaign.LONGEST_PAUSE", 60.0)
    rigs: list[SimulatedHammerRig] = []

    def gone(parts: SimulatedHammerRig) -> None:
        rigs.append(parts)
        parts.hammer.ask = lambda point, number: None  # type: ignore[method-assign]

    with pytest.raises(RigStopped, match="nobody has hit the plate for 1 min"):
        acquire(declared, tmp_path / "hits", prepare=gone)
    assert rigs[0].oven is not None
    assert not rigs[0].oven.body.regulating


def test_a_heater_that_is_welded_on_is_not_at_rest(declared: HammerExperiment, tmp_path: Path) -> None:
    def weld(parts: SimulatedHammerRig) -> None:
        assert parts.oven is not None
        body = parts.oven.body
        rest = body._rest

        def welded() -> None:
            rest()
            body._power = 600.0

        body._rest = welded  # type: ignore[method-assign]

    keys: Iterator[Key | None] = iter(["stop"])
    unsafe: list[str] = []
    acquire(declared, tmp_path / "hits", lambda: next(keys, None), prepare=weld, unsafe=unsafe)
    assert "reads back as switched off, but" in unsafe[0]
    left = [event for event in read_events(tmp_path / "hits") if event.get("command") == "safe"]
    assert left[-1]["unsafe"] == unsafe


def test_room_and_port_are_looked_for_before_the_oven_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_flexura: Callable[..., tuple[int, str, str]]
) -> None:
    file = tmp_path / "oven.toml"
    text = text_with_oven().replace('port = "simulated"', 'port = "/dev/ttyNOBODY"')
    file.write_text(text, encoding="utf-8")
    status, _, said = run_flexura("acquire", file, "--rig", "real", "--out", tmp_path / "hits")
    assert status == 2
    assert "this computer has no such port" in said
    monkeypatch.setattr(shutil, "disk_usage", lambda _: type("Usage", (), {"free": 51_000_000}))
    status, _, said = run_flexura("acquire", file, "--out", tmp_path / "hits")
    assert status == 2
    assert "51 MB free" in said
    assert "for the 54 hits to be made" in said
    assert not (tmp_path / "hits").exists()


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("temperatures = [25.0, 35.0, 30.0]", "temperatures = [25.0, 75.0]", "oven.maximum"),
        ("temperatures = [25.0, 35.0, 30.0]", "temperatures = [25.0, 25.0]", "twice"),
        ("ramp_rate = 3.0", "ramp_rate = 5.0", "oven.max_rate"),
        ("hottest = 70.0", "hottest = 150.0", "limits.hottest"),
        ("soak = 300.0", "soak = 300.0\npoll_interval = 60.0", "at most 50 s"),
        ('kind = "watlow-f4t"', 'kind = "watlow"', "oven.kind"),
        ('thermocouples = ["cDAQ1Mod3/ai0"]\n', "", "what measures it"),
        ("[limits]\ncoldest = -10.0\nhottest = 70.0\n", "", "[limits] is missing"),
    ],
)
def test_what_does_not_go_together_is_refused(before: str, after: str, said: str, tmp_path: Path) -> None:
    text = text_with_oven()
    assert text.count(before) == 1
    file = tmp_path / "wrong.toml"
    file.write_text(text.replace(before, after), encoding="utf-8")
    with pytest.raises(CampaignFileError) as raised:
        read_hammer_experiment(file)
    assert said in str(raised.value)


@pytest.mark.slow
def test_laws_over_temperature_from_hits(tmp_path: Path) -> None:
    file, folder = tmp_path / "oven.toml", tmp_path / "hits"
    file.write_text(text_with_oven(), encoding="utf-8")
    done = CliRunner().invoke(flexura, ["acquire", str(file), "--out", str(folder), "-q"])
    assert done.exit_code == 0, done.stderr
    done = CliRunner().invoke(flexura, ["update", str(folder), "--out", str(tmp_path / "laws"), "--json"])
    assert done.exit_code == 0, done.stderr
    rows = json.loads(done.stdout)["temperatures"]
    simulation = read_hammer_experiment(file).simulation
    assert simulation is not None
    assert len(rows) == 3
    for row in rows:
        true = simulation.laws.laws().at([row["temperature_c"]])
        assert row["youngs_modulus_pa"] == pytest.approx(float(true.youngs_modulus[0]), rel=0.01)
        assert row["loss_factor"] == pytest.approx(float(true.loss_factor[0]), rel=0.03)


def test_safe_brings_its_oven_to_rest_and_says_where_there_is_none(tmp_path: Path) -> None:
    file = tmp_path / "oven.toml"
    file.write_text(text_with_oven(), encoding="utf-8")
    done = CliRunner().invoke(flexura, ["safe", str(file), "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout) == {"rig": "simulated", "unsafe": []}
    assert "the oven is at rest" in done.stderr
    done = CliRunner().invoke(flexura, ["safe", str(EXAMPLE)])
    assert done.exit_code == 0
    assert "nothing is heated or driven" in done.stderr
