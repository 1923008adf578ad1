"""The folder a rig writes into."""

import errno
import json
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.declaration.tolerances import Tolerances
from analysis.protocol.protocol import SweepSetPoint
from analysis.recordings.campaign import Sweep
from app.files.acquisition.campaign_folder import AcquiredCampaign, open_campaign
from app.files.acquisition.same_experiment import require_ours
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import Source, frozen_protocol, read_protocol, read_sweep_file, sweep_paths
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import read_acquired_experiment
from app.files.folder_lock import folder_lock

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "simulated-rig.toml"
Opened = Callable[..., AbstractContextManager[AcquiredCampaign]]


@pytest.fixture
def opened(tmp_path: Path) -> Opened:
    """Return a function that opens the campaign of the example, or of a changed one."""

    @contextmanager
    def make(folder: str = "campaign", **changes: Any) -> Iterator[AcquiredCampaign]:
        experiment = read_acquired_experiment(EXAMPLE)
        recorded = experiment.recorded(8533.0)
        acquired = experiment.model_dump(mode="json") | changes
        source = Source("mine.toml", changes.get("sha256", "0" * 64))
        acquired.pop("sha256", None)
        protocol = frozen_protocol("campaign", recorded, {source.file: source.sha256}, acquired)
        with folder_lock(tmp_path / folder):
            yield open_campaign(tmp_path / folder, protocol, recorded, source)

    return make


def point(step: int) -> SweepSetPoint:
    return SweepSetPoint(step, 10.0 * step, "up", 1.0, 0.0)


def sweep(step: int, plate: float | None = None) -> Sweep:
    rng = np.random.default_rng(step)
    drive, response = rng.standard_normal((2, 3, 500)).astype(np.float32)
    plate = 10.0 * step if plate is None else plate
    return Sweep(
        step, "up", 1.0, plate + 1.0, plate + 1.2, "2000-01-01T00:00:00+00:00", drive, response[None], plate, plate
    )


def test_sweeps_come_back_with_both_temperatures(opened: Opened, tmp_path: Path) -> None:
    with opened() as store:
        for step in range(7):
            store.keep(sweep(step, 10.0 * step + 0.1), point(step), 1)
        assert store.finished() == frozenset(range(7))
    campaign = load_campaign(tmp_path / "campaign")
    assert [round(one.temperature, 3) for one in campaign.sweeps] == [10.0 * step + 0.1 for step in range(7)]
    assert campaign.sweeps[3].oven_temperature_start == pytest.approx(31.1)
    np.testing.assert_array_equal(campaign.sweeps[2].responses, sweep(2).responses)
    assert "sweeps/0003_up_T+030.0.h5" in campaign.hashes


def test_a_finished_sweep_is_never_overwritten(opened: Opened, tmp_path: Path) -> None:
    with opened() as store:
        store.keep(sweep(1), point(1), 1)
        (path,) = sweep_paths(tmp_path / "campaign")
        before = path.read_bytes()
        with pytest.raises(FileExistsError):
            store.keep(sweep(1, 10.3), point(1), 2)
        assert path.read_bytes() == before


def test_rejected_sweeps_are_kept_apart_and_numbered(opened: Opened, tmp_path: Path) -> None:
    with opened() as store:
        store.put_aside(sweep(1), point(1), 1, ("too loud",))
        store.put_aside(sweep(1), point(1), 2, ("too loud", "too hot"))
        store.put_aside(sweep(1), point(1), 2, ("the log was lost",))
        assert store.finished() == frozenset()
    names = sorted(path.name for path in (tmp_path / "campaign" / "rejected").iterdir())
    assert names == [f"0001_up_T+010.0_attempt{end}.h5" for end in ("1", "2", "2x")]
    kept, problem = read_sweep_file(tmp_path / "campaign" / "rejected" / names[0], names[0])
    assert problem is None
    assert kept is not None


def test_taken_up_again_without_what_a_kill_left_unfinished(opened: Opened, tmp_path: Path) -> None:
    with opened() as store:
        store.keep(sweep(0), point(0), 1)
        store.log({"event": "finished", "step": 0})
    torn = tmp_path / "campaign" / "sweeps" / "0001_up_T+010.0.h5.part"
    torn.write_bytes(b"half a sweep")
    with opened(sha256="1" * 64) as store:  # another comment in the file is no other experiment
        assert store.finished() == frozenset({0})
        assert store.events() == [{"event": "finished", "step": 0}]
    assert not torn.exists()


def test_a_damaged_sweep_is_named_not_measured_over(opened: Opened, tmp_path: Path) -> None:
    with opened() as store:
        store.keep(sweep(0), point(0), 1)
    (path,) = sweep_paths(tmp_path / "campaign")
    damaged = bytearray(path.read_bytes())
    damaged[-200] ^= 0xFF
    path.write_bytes(bytes(damaged))
    with pytest.raises(CampaignFileError, match="move it out of the campaign"), opened():
        pass
    assert path.read_bytes() == bytes(damaged)


def test_another_experiment_is_refused_with_what_differs(opened: Opened) -> None:
    with opened() as store:
        store.keep(sweep(0), point(0), 1)
    simulation = read_acquired_experiment(EXAMPLE).model_dump(mode="json")["simulation"] | {"noise": 0.1}
    told = r"different: \[simulation\] noise, title; allowed"
    with pytest.raises(CampaignFileError, match=told), opened(title="another", simulation=simulation):
        pass


def declared(**changes: Any) -> dict[str, Any]:
    """Return the example's tables for a real rig with a thermometer, changed."""
    now = read_acquired_experiment(EXAMPLE).model_dump(mode="json")
    cards = now["cards"] | {"iepe": [], "grpc": None} | changes.get("cards", {})
    oven = now["oven"] | {"port": "/dev/ttyUSB0"} | changes.get("oven", {})
    thermometer = {"kind": "scpi", "port": "COM3", "terminator": "\n", "sensors": []} | changes.get(
        "thermometer", {}
    )
    rest = {table: now[table] | changes.get(table, {}) for table in ("programme", "limits", "sweep")}
    return {"rig": "real", "cards": cards, "oven": oven, "thermometer": thermometer, **rest}


OTHER_CHASSIS = {
    "output": "cDAQ2Mod2/ao0",
    "drive_input": "cDAQ2Mod1/ai0",
    "responses": ["cDAQ2Mod1/ai1"],
    "thermocouples": ["cDAQ2Mod3/ai0"],
}


@pytest.mark.parametrize(
    "changes",
    [
        {"oven": {"port": "/dev/ttyUSB1"}},
        {"oven": {"port": "socket://10.0.0.7:502", "baud_rate": 19200, "parity": "E", "stop_bits": 2}},
        {
            "oven": {
                "timeout": 2.5,
                "retries": 5,
                "gap_after_read": 0.1,
                "gap_after_write": 0.2,
                "lost_after": 30.0,
            }
        },
        {"oven": {"address": 7}},
        {"thermometer": {"port": "COM4", "terminator": "\r\n"}},
        {"cards": {"grpc": "lab:31763"}},
        {"cards": {"device": "another sound card"}},
        {"cards": {"responses": ["cDAQ1Mod1/ai2"]}},
        {"cards": {"responses": ["cDAQ1Mod1/ai2"], "iepe": ["cDAQ1Mod1/ai2"]}},
        {"cards": OTHER_CHASSIS},
        {"programme": {"poll_interval": 2.5}, "limits": {"lost_after": 60.0}},
    ],
    ids=str,
)
def test_wiring_may_change_at_any_time_and_is_logged(
    opened: Opened, tmp_path: Path, changes: dict[str, Any]
) -> None:
    before = declared(cards={"iepe": ["cDAQ1Mod1/ai1"]} if "iepe" in changes.get("cards", {}) else {})
    with opened(**before) as store:
        store.keep(sweep(0), point(0), 1)
    frozen = (tmp_path / "campaign" / "protocol.json").read_bytes()
    for _ in range(2):  # told once
        with opened(**declared(**changes)) as store:
            assert store.finished() == frozenset({0})
            (event,) = store.events()
            assert event["event"] == "wiring changed"
            named = {f"[{table}] {key}": value for table, keys in changes.items() for key, value in keys.items()}
            assert event["wiring"] == named
    with opened(**before) as store:
        assert [event["wiring"] for event in store.events()] == [named, {}]
    assert (tmp_path / "campaign" / "protocol.json").read_bytes() == frozen


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"oven": {"kind": "espec-p300"}}, r"\[oven\] kind"),
        ({"oven": {"maximum": 50.0}}, r"\[oven\] maximum"),
        ({"oven": {"decimals": 2}}, r"\[oven\] decimals"),
        ({"thermometer": {"sensors": [{"query": "T?"}]}}, r"\[thermometer\] sensors"),
        ({"cards": {"sample_rate": 10240.0}}, r"\[cards\] sample_rate"),
        ({"cards": {"input_range": 1.0}}, r"\[cards\] input_range"),
        ({"cards": {"coupling": "AC"}}, r"\[cards\] coupling"),
        ({"cards": {"thermocouple_type": "T"}}, r"\[cards\] thermocouple_type"),
        ({"cards": {"thermocouples": []}}, r"\[cards\] thermocouples"),
        ({"cards": {"iepe": ["cDAQ1Mod1/ai1"]}}, r"\[cards\] iepe"),
        (
            {"cards": {"drive_input": "cDAQ1Mod1/ai1", "responses": ["cDAQ1Mod1/ai0"]}},
            r"\[cards\] drive_input, \[cards\] responses",
        ),
        ({"cards": {"drive_input": "cDAQ1Mod1/ai1", "responses": ["cDAQ1Mod1/ai2"]}}, r"\[cards\] drive_input"),
        ({"programme": {"ramp_rate": 0.7}}, r"\[programme\] ramp_rate"),
        ({"limits": {"drift": 0.1}}, r"\[limits\] drift"),
    ],
    ids=str,
)
def test_what_decides_what_is_measured_may_not_change(opened: Opened, changes: dict[str, Any], told: str) -> None:
    with opened(**declared()) as store:
        store.keep(sweep(0), point(0), 1)
    with pytest.raises(CampaignFileError, match=f"different: {told}"), opened(**declared(**changes)):
        pass
    with opened(**declared()) as store:
        assert store.events() == []


def test_a_slot_of_the_simulated_rig_is_no_wiring(opened: Opened) -> None:
    with opened(**declared() | {"rig": "simulated"}) as store:
        store.keep(sweep(0), point(0), 1)
    with opened(**declared(cards=OTHER_CHASSIS) | {"rig": "simulated"}):
        pass
    moved = declared(cards={"output": "cDAQ1Mod5/ao0"}) | {"rig": "simulated"}
    with pytest.raises(CampaignFileError, match=r"different: \[cards\] output"), opened(**moved):
        pass


def test_an_experiment_may_change_while_nothing_was_measured(opened: Opened, tmp_path: Path) -> None:
    """After a test shot that was too loud, say; the log then begins anew, and with it the test shot."""
    folder = tmp_path / "campaign"
    for number, title in enumerate(("first", "second", "third")):
        with opened(title=title) as store:
            assert store.events() == []
            store.log({"event": "oven", "command": "safe", "leg": number})
        assert read_protocol(folder)[0]["acquired"]["title"] == title
    assert [read_events_of(folder / f"events-{n}.jsonl") for n in (1, 2)] == [[0], [1]]
    with opened(title="third") as store:
        assert len(store.events()) == 1


def read_events_of(path: Path) -> list[int]:
    return [json.loads(line)["leg"] for line in path.read_text().splitlines()]


@pytest.mark.parametrize("why", ["a sweep was rejected", "the oven may be on"])
def test_an_experiment_that_left_something_may_not_change(opened: Opened, why: str) -> None:
    with opened() as store:
        if why == "a sweep was rejected":
            store.put_aside(sweep(0), point(0), 1, ["loud"])
        else:
            store.log({"event": "oven", "command": "ramp", "target": 40.0})
    with pytest.raises(CampaignFileError, match="different: title"), opened(title="another"):
        pass


def test_a_campaign_begun_before_a_key_was_there_goes_on(opened: Opened) -> None:
    """Absent is as by default; another value is another experiment."""
    now = read_acquired_experiment(EXAMPLE).model_dump(mode="json")
    oven = now["oven"] | {"kind": "watlow-f4t", "rest_after": 1800.0, "program": None}
    slots = {"1": "NI-9234", "2": "NI-9260", "3": "NI-9211"}
    then = {
        "oven": {key: value for key, value in oven.items() if key not in ("rest_after", "program")},
        "simulation": now["simulation"] | {"modules": slots},
        "tolerances": {"oven_offset": 0.1},
    }
    known = Tolerances(oven_offset=0.1).model_dump(mode="json")  # a lag of the plate among them, which came later
    assert set(now["simulation"]["modules"]) > set(slots)
    with opened(**then) as store:
        store.keep(sweep(0), point(0), 1)
    with opened(oven=oven, tolerances=known):
        pass
    with (
        pytest.raises(CampaignFileError, match="rest_after"),
        opened(oven=oven | {"rest_after": 600.0}, tolerances=known),
    ):
        pass
    exact = known | {"plate_lag": 0.0}
    with pytest.raises(CampaignFileError, match=r"\[tolerances\] plate_lag"), opened(oven=oven, tolerances=exact):
        pass
    moved = now["simulation"] | {"modules": slots | {"4": "NI-9263"}}
    with (
        pytest.raises(CampaignFileError, match=r"modules\] 4"),
        opened(oven=oven, simulation=moved, tolerances=known),
    ):
        pass


def test_a_renamed_folder_goes_on(opened: Opened, tmp_path: Path) -> None:
    with opened() as store:
        store.keep(sweep(0), point(0), 1)
    (tmp_path / "campaign").rename(tmp_path / "left seat")
    protocol, experiment = read_protocol(tmp_path / "left seat")
    require_ours(tmp_path / "left seat", protocol | {"name": "left seat"})
    assert experiment.title


@pytest.mark.parametrize("damage", ['{"format": "camp', "[]", "\x00"])
def test_nobody_is_told_to_delete_what_was_measured(opened: Opened, tmp_path: Path, damage: str) -> None:
    with opened() as store:
        store.keep(sweep(0), point(0), 1)
    folder = tmp_path / "campaign"
    (folder / "readings.csv").touch()
    (folder / "protocol.json").write_text(damage, encoding="utf-8")
    with pytest.raises(CampaignFileError, match="keep the folder: what was measured is nowhere else") as told:
        load_campaign(folder)
    assert "delete the folder" not in str(told.value)
    assert "attribute" not in str(told.value)


def test_a_folder_of_somebody_elses_is_left_alone(opened: Opened, tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(CampaignFileError, match="is no campaign"), opened("thesis"):
        pass
    assert sorted(child.name for child in (tmp_path / "thesis").iterdir()) == ["chapter.txt"]


def test_a_second_process_is_kept_out(opened: Opened) -> None:
    with opened(), pytest.raises(CampaignFileError, match="another process"), opened():
        pass


def test_a_full_disk_leaves_nothing_half_written(
    opened: Opened, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = shutil.disk_usage(tmp_path)
    with opened() as store:
        store.keep(sweep(0), point(0), 1)
        with monkeypatch.context() as full:
            full.setattr(shutil, "disk_usage", lambda path: usage._replace(free=1000))
            with pytest.raises(OSError, match="are needed") as caught:
                store.keep(sweep(1), point(1), 1)
            assert caught.value.errno == errno.ENOSPC
        with monkeypatch.context() as failing:
            failing.setattr(os, "fsync", _no_space)
            with pytest.raises(OSError, match="No space"):
                store.keep(sweep(1), point(1), 1)
        assert store.finished() == frozenset({0})
        assert [path.name for path in (tmp_path / "campaign" / "sweeps").iterdir()] == ["0000_up_T+000.0.h5"]
        store.keep(sweep(1), point(1), 2)


def _no_space(handle: int) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_verifying_what_is_there_can_be_broken_off(opened: Opened, tmp_path: Path) -> None:
    """A campaign of many gigabytes takes a while, in which the oven may have to be brought to rest."""
    with opened() as store:
        for step in range(3):
            store.keep(sweep(step), point(step), 1)
    experiment = read_acquired_experiment(EXAMPLE)
    calls = iter([None, None, RuntimeError("enough")])

    def check() -> None:
        error = next(calls)
        if error is not None:
            raise error

    with pytest.raises(RuntimeError, match="enough"):
        AcquiredCampaign(tmp_path / "campaign", experiment.recorded(8533.0), Source("mine.toml", "0" * 64), check)


def test_volts_are_not_written_as_newtons(tmp_path: Path) -> None:
    experiment = read_acquired_experiment(EXAMPLE.with_name("exciter.toml")).recorded(4266.0)
    with pytest.raises(ValueError, match=r"\['shaker', 'Q1', 'acc', .* are not in volts; their sensitivities"):
        AcquiredCampaign(tmp_path, experiment, Source("mine.toml", "0" * 64))
