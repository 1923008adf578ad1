"""A recording becomes a campaign folder: same content, same bytes, and only ever whole."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from analysis.recordings.campaign import Campaign
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import _digest, read_protocol, write_index, write_protocol
from app.files.campaigns.import_recording import import_recording
from app.files.campaigns.loading import load_campaign
from app.files.campaigns.recorded import read_recorded_campaign
from app.files.disk_room import UnwrittenFileError
from app.files.folder_lock import folder_lock
from app.files.provenance import sha256

SHARED = Path(__file__).resolve().parents[3] / "shared/data/campaigns"
ROOT = Path(__file__).resolve().parents[2]
Run = Callable[..., tuple[int, str, str]]


def same(a: Campaign, b: Campaign) -> bool:
    """Whether two campaigns hold the same experiment and the same sweeps, sample by sample."""
    return (a.name, a.experiment, len(a.sweeps)) == (b.name, b.experiment, len(b.sweeps)) and all(
        replace(x, drive=y.drive, responses=y.responses) == y
        and np.array_equal(x.drive, y.drive)
        and np.array_equal(x.responses, y.responses)
        for x, y in zip(a.sweeps, b.sweeps, strict=True)
    )


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.fixture
def recorded(tiny: Any, tmp_path: Path) -> Path:
    folder: Path = tiny.write(tmp_path / "plate")
    return folder


def test_campaign_folder_holds_what_was_recorded(recorded: Path, run_flexura: Run) -> None:
    status, output, message = run_flexura("import", recorded)
    out = recorded.with_name("plate-campaign")
    assert (status, output) == (0, "")
    assert "tiny plate: 6 sweeps, 10 to 30 °C, imported into" in message
    assert sorted(p.name for p in out.parent.iterdir()) == ["plate", "plate-campaign"]
    assert sorted(p.name for p in (out / "sweeps").iterdir()) == [
        "0000_up_T+010.0.h5",
        "0001_up_T+020.0.h5",
        "0002_up_T+030.0.h5",
        "0003_down_T+030.0.h5",
        "0004_down_T+020.0.h5",
        "0005_down_T+010.0.h5",
    ]
    loaded = load_campaign(out)
    assert same(loaded, read_recorded_campaign(recorded))
    assert loaded.sweeps[2].responses.shape == (2, 2, 1536)
    assert loaded.hashes["protocol.json"] == sha256(out / "protocol.json")
    assert len(loaded.hashes) == 7


def test_every_sweep_says_where_it_came_from(recorded: Path) -> None:
    out = import_recording(recorded).folder
    with h5py.File(out / "sweeps" / "0003_down_T+030.0.h5") as file:
        assert file.attrs["source_file"] == "sweeps/003.tdms"
        assert file.attrs["source_sha256"] == sha256(recorded / "sweeps" / "003.tdms")
        assert json.loads(file.attrs["sensors"]) == ["S1", "S2"]
        assert file["drive"].attrs["unit"] == "V"


def test_recording_without_its_people_names_reads_the_same(tiny: Any, tmp_path: Path) -> None:
    """File names are for people: the order comes from the properties."""
    plain = read_recorded_campaign(tiny.write(tmp_path / "a" / "plate"))
    tiny.files = {f"{name[:3][::-1]}x.TDMS": file for name, file in reversed(tiny.files.items())}
    assert same(read_recorded_campaign(tiny.write(tmp_path / "b" / "plate")), plain)


def test_steps_may_skip_numbers(tiny: Any, tmp_path: Path) -> None:
    """A selection from a longer recording keeps the numbers it had."""
    for n, file in enumerate(tiny.files.values()):
        file.properties["step"] = 4 * n + 1
    campaign = read_recorded_campaign(tiny.write(tmp_path / "plate"))
    assert [sweep.step for sweep in campaign.sweeps] == [1, 5, 9, 13, 17, 21]


def test_several_levels_at_each_temperature(tiny: Any, tmp_path: Path) -> None:
    tiny.toml = tiny.toml.replace("levels = [1.0]", "levels = [0.5, 1.0]").replace('["up", "down"]', '["up"]')
    for n, file in enumerate(tiny.files.values()):
        temperature, level = (10.0, 20.0, 30.0)[n // 2], (0.5, 1.0)[n % 2]
        given = {"direction": "up", "level": level}
        file.properties |= given | {"oven_temperature_start": temperature, "oven_temperature_end": temperature}
        file.groups = {
            g: {c: (level * s).astype(np.float32) for c, s in cs.items()} for g, cs in file.groups.items()
        }
    out = import_recording(tiny.write(tmp_path / "plate")).folder
    campaign = load_campaign(out)
    assert [(sweep.oven_temperature, sweep.level) for sweep in campaign.sweeps][:3] == [
        (10, 0.5),
        (10, 1),
        (20, 0.5),
    ]


def test_json_is_all_that_stands_on_stdout(recorded: Path, run_flexura: Run) -> None:
    status, output, _ = run_flexura("import", recorded, "--json")
    said = json.loads(output)
    assert (status, said["state"], said["sweeps"], said["sensors"]) == (0, "imported", 6, ["S1", "S2"])
    assert said["inputs"]["campaign.toml"] == sha256(recorded / "campaign.toml")
    assert load_campaign(Path(said["campaign"])).name == "plate"


def test_importing_twice_changes_nothing(recorded: Path, run_flexura: Run) -> None:
    out = import_recording(recorded).folder
    before = content(out), [p.stat().st_mtime_ns for p in sorted(out.rglob("*"))]
    status, _, message = run_flexura("import", recorded)
    assert status == 0
    assert "unchanged" in message
    assert (content(out), [p.stat().st_mtime_ns for p in sorted(out.rglob("*"))]) == before


def test_two_imports_have_the_same_bytes(recorded: Path, tmp_path: Path) -> None:
    a = import_recording(recorded, tmp_path / "a").folder
    b = import_recording(recorded, tmp_path / "b").folder
    assert content(a) == content(b)


def test_another_campaign_in_the_place_is_refused(recorded: Path, run_flexura: Run) -> None:
    out = import_recording(recorded).folder
    before = content(out)
    toml = recorded / "campaign.toml"
    toml.write_text(toml.read_text().replace("mass = 0.13", "mass = 0.131"))
    status, _, message = run_flexura("import", recorded)
    assert status == 2
    assert "holds another campaign ('plate'" in message
    assert "--out" in message
    assert content(out) == before


@pytest.mark.parametrize("kind", ["a file", "a folder in use", "under a file", "inside the recording", "itself"])
def test_place_that_cannot_be_had(recorded: Path, run_flexura: Run, kind: str) -> None:
    notes = recorded.parent / "notes"
    if kind == "a folder in use":
        notes.mkdir()
        (notes / "x").write_text("mine")
    else:
        notes.write_text("mine")
    out = {"under a file": notes / "deep" / "out", "inside the recording": recorded / "out", "itself": recorded}
    before = content(recorded.parent)
    status, _, message = run_flexura("import", recorded, "--out", out.get(kind, notes))
    assert status == 2
    assert "--out" in message
    assert content(recorded.parent) == before


def test_empty_folder_is_taken(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    assert import_recording(recorded, tmp_path / "out").state == "imported"


def test_imported_campaign_is_not_imported_again(recorded: Path, run_flexura: Run) -> None:
    status, _, message = run_flexura("import", import_recording(recorded).folder)
    assert status == 2
    assert "flexura identify" in message


def test_an_import_from_before_a_tolerance_was_known_is_the_same_campaign(recorded: Path) -> None:
    """It was "another campaign": the digest of its protocol lacked a key that came later."""
    declaration = recorded / "campaign.toml"
    text = declaration.read_text(encoding="utf-8") + "\n[tolerances]\noven_offset = 0.1\n"
    declaration.write_text(text, encoding="utf-8")
    out = import_recording(recorded).folder
    protocol, _ = read_protocol(out)
    del protocol["sha256"], protocol["experiment"]["tolerances"]["plate_lag"]
    write_protocol(out, protocol | {"sha256": _digest(protocol)})
    before = content(out)
    assert import_recording(recorded).state == "unchanged"
    assert content(out) == before
    declaration.write_text(text.replace("oven_offset = 0.1", "oven_offset = 0.2"), encoding="utf-8")
    with pytest.raises(CampaignFileError, match="holds another campaign"):
        import_recording(recorded)


def test_what_sweeps_carry_says_what_was_read(tiny: Any, tmp_path: Path) -> None:
    """One ramp by the air has a lag that nothing tells; with readings of the plate it has none."""
    for name in ("air", "plate"):
        for file in tiny.files.values() if name == "plate" else ():
            for end in ("start", "end"):
                file.properties[f"plate_temperature_{end}"] = file.properties[f"oven_temperature_{end}"]
        folder = tiny.write(tmp_path / name)
        assert load_campaign(folder).experiment.oven.reading == name
        assert load_campaign(import_recording(folder).folder).experiment.oven.reading == name


def test_missing_sweeps_are_noted_when_allowed(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    del tiny.files["001.tdms"], tiny.files["005.tdms"]
    recorded = tiny.write(tmp_path / "plate")
    status, output, message = run_flexura("import", recorded, "--allow-missing", "--json")
    assert status == 0
    assert json.loads(output)["missing"] == ["20 °C up 1 V", "10 °C down 1 V"]
    assert "note: missing 20 °C up 1 V" in message
    out = Path(json.loads(output)["campaign"])
    events = [json.loads(line) for line in (out / "events.jsonl").read_text(encoding="utf-8").splitlines()]
    assert {"event": "missing", "place": "10 °C down 1 V"} in events
    assert [sweep.step for sweep in load_campaign(out).sweeps] == [0, 2, 3, 4]


def test_a_clipped_sweep_is_left_out_and_noted_when_allowed(tiny: Any, tmp_path: Path, run_flexura: Run) -> None:
    clipped = tiny.files["001.tdms"].groups["repeat 2"]
    clipped["S1"] = np.clip(clipped["S1"], -0.05, 0.05)
    recorded = tiny.write(tmp_path / "plate")
    status, _, message = run_flexura("import", recorded)
    assert status == 2
    assert "001.tdms: repeat 2/S1 = " in message
    assert "import with --allow-missing to leave the sweep out" in message
    status, output, message = run_flexura("import", recorded, "--allow-missing", "--json")
    assert status == 0
    assert "note: left out sweeps/001.tdms: repeat 2/S1 = " in message
    assert json.loads(output)["missing"] == ["20 °C up 1 V"]
    out = Path(json.loads(output)["campaign"])
    assert [sweep.step for sweep in load_campaign(out).sweeps] == [0, 2, 3, 4, 5]
    assert "left out" in (out / "events.jsonl").read_text(encoding="utf-8")
    status, _, message = run_flexura("import", recorded, "--allow-missing")
    assert "unchanged" in message


def test_allowed_or_not_a_damaged_file_and_nothing_but_clipped_ones_are_refused(
    tiny: Any, tmp_path: Path, run_flexura: Run
) -> None:
    tiny.files["001.tdms"].groups["repeat 2"]["S1"] = tiny.files["001.tdms"].groups["repeat 2"]["S1"][:-3]
    status, _, message = run_flexura("import", tiny.write(tmp_path / "damaged"), "--allow-missing")
    assert status == 2
    assert "unequal" in message
    tiny.files = {"000.tdms": tiny.files["000.tdms"]}
    tiny.files["000.tdms"].groups["repeat 1"]["S1"] *= 0.0
    status, _, message = run_flexura("import", tiny.write(tmp_path / "silent"), "--allow-missing")
    assert status == 2
    assert "0 to 0 V throughout" in message


def test_index_leads_to_every_sweep_and_can_be_made_anew(recorded: Path) -> None:
    out = import_recording(recorded).folder
    before = (out / "index.h5").read_bytes()
    with h5py.File(out / "index.h5") as index:
        assert len(index) == 6
        assert index["0004_down_T+020.0/responses"].shape == (2, 2, 1536)
    (out / "index.h5").unlink()
    assert load_campaign(out)
    write_index(out)
    assert (out / "index.h5").read_bytes() == before


def edited_protocol(out: Path) -> None:
    text = (out / "protocol.json").read_text()
    (out / "protocol.json").write_text(text.replace('"mass": 0.13', '"mass": 0.14'))


def flipped_byte(out: Path) -> None:
    path = out / "sweeps" / "0002_up_T+030.0.h5"
    whole = bytearray(path.read_bytes())
    whole[-5000] ^= 1
    path.write_bytes(whole)


def halved(out: Path) -> None:
    path = out / "sweeps" / "0002_up_T+030.0.h5"
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def lost(out: Path) -> None:
    (out / "sweeps" / "0002_up_T+030.0.h5").unlink()


def doubled(out: Path) -> None:
    shutil.copy(out / "sweeps" / "0002_up_T+030.0.h5", out / "sweeps" / "0009_up_T+030.0.h5")


def broken_event(out: Path) -> None:
    (out / "events.jsonl").write_text('{"event": "impor\n{"event": "imported"}\n')


DAMAGE = [
    (edited_protocol, "protocol.json: sha256 = not that of the content"),
    (flipped_byte, "sweeps/0002_up_T+030.0.h5: unreadable (damaged, cut short or edited"),
    (halved, "sweeps/0002_up_T+030.0.h5: unreadable"),
    (lost, "missing = 30 °C up 1 V"),
    (doubled, "sweeps/0009_up_T+030.0.h5: step = 2"),
    (broken_event, "events.jsonl: line 1 = "),
]


@pytest.mark.parametrize(("damage", "said"), DAMAGE, ids=[damage.__name__ for damage, _ in DAMAGE])
def test_damaged_campaign_is_refused(recorded: Path, damage: Callable[[Path], None], said: str) -> None:
    out = import_recording(recorded).folder
    damage(out)
    with pytest.raises(CampaignFileError) as refusal:
        load_campaign(out)
    assert said in str(refusal.value)
    with pytest.raises(CampaignFileError):
        import_recording(recorded)


def test_torn_last_event_is_ignored(recorded: Path) -> None:
    out = import_recording(recorded).folder
    with (out / "events.jsonl").open("a") as file:
        file.write('{"event": "half a li')
    assert load_campaign(out).name == "plate"


def test_second_writer_is_kept_out(recorded: Path, tmp_path: Path) -> None:
    with folder_lock(tmp_path / "out"), pytest.raises(CampaignFileError, match="another process is writing it"):
        import_recording(recorded, tmp_path / "out")
    assert import_recording(recorded, tmp_path / "out").state == "imported"
    assert not list(tmp_path.glob("*.lock"))


def test_stranger_in_the_place_of_the_unfinished_folder(recorded: Path, tmp_path: Path) -> None:
    (tmp_path / "out.part").mkdir()
    (tmp_path / "out.part" / "thesis.tex").write_text("mine")
    with pytest.raises(CampaignFileError, match=r"holds thesis\.tex"):
        import_recording(recorded, tmp_path / "out")
    assert (tmp_path / "out.part" / "thesis.tex").read_text() == "mine"


def test_unfinished_import_of_another_recording_is_replaced(recorded: Path, tmp_path: Path) -> None:
    first = import_recording(recorded, tmp_path / "out").folder
    first.rename(tmp_path / "out.part")
    toml = recorded / "campaign.toml"
    toml.write_text(toml.read_text().replace("mass = 0.13", "mass = 0.131"))
    assert import_recording(recorded, tmp_path / "out").state == "imported"
    assert load_campaign(tmp_path / "out").experiment.plate.mass == 0.131


def test_full_disk_leaves_nothing(recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, calls = os.fsync, iter(range(8))

    def fills_up(handle: int) -> None:
        if next(calls, None) is None:
            raise OSError(28, "No space left on device")
        real(handle)

    monkeypatch.setattr(os, "fsync", fills_up)
    with pytest.raises(UnwrittenFileError, match="No space left"):
        import_recording(recorded, tmp_path / "out")
    assert [p.name for p in tmp_path.iterdir()] == ["plate"]


CHILD = """
import sys
from pathlib import Path
from app.files.campaigns.import_recording import import_recording
print("ready", flush=True)
import_recording(Path(sys.argv[1]), Path(sys.argv[2]))
print("done", flush=True)
"""


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL is POSIX")
def test_killed_import_is_completed_bit_by_bit(recorded: Path, tmp_path: Path) -> None:
    started = time.perf_counter()
    undisturbed = content(import_recording(recorded, tmp_path / "undisturbed").folder)
    span = time.perf_counter() - started
    rng = np.random.default_rng(20)
    states = []
    for n in range(15):
        out = tmp_path / f"out{n}"
        command = [sys.executable, "-c", CHILD, str(recorded), str(out)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=ROOT) as child:
            assert child.stdout is not None
            assert child.stdout.readline() == "ready\n"
            part = tmp_path / f"out{n}.part"
            while n == 0 and child.poll() is None and not list(part.glob("sweeps/*.h5")):
                time.sleep(0.001)  # one kill comes in the middle, however busy the machine is
            time.sleep(rng.uniform(0.0, 1.2 * span) if n else 0.0)
            child.send_signal(signal.SIGKILL)
        if out.exists():
            assert content(out) == undisturbed  # a folder of the final name is whole, whenever the kill came
        imported = import_recording(recorded, out)
        states.append(imported.state)
        assert content(out) == undisturbed
        assert not list(tmp_path.glob("*.part"))
        assert not list(tmp_path.glob("*.lock"))
    assert "completed" in states


@pytest.mark.parametrize("whole", [0, 2, 5])
def test_resumed_import_keeps_the_sweeps_that_are_whole(recorded: Path, tmp_path: Path, whole: int) -> None:
    undisturbed = content(import_recording(recorded, tmp_path / "undisturbed").folder)
    partial = tmp_path / "out.part"
    shutil.copytree(tmp_path / "undisturbed", partial)
    sweeps = sorted((partial / "sweeps").iterdir())
    for path in sweeps[whole:]:
        path.with_name(path.name + ".part").write_bytes(path.read_bytes()[:4000])
        path.unlink()
    (partial / "index.h5").unlink()
    (partial / "events.jsonl").write_text('{"event": "imp')
    kept = {path: path.stat().st_mtime_ns for path in sweeps[:whole]}
    imported = import_recording(recorded, tmp_path / "out")
    assert imported.state == "completed"
    assert content(tmp_path / "out") == undisturbed
    for path, written in kept.items():
        assert (tmp_path / "out" / "sweeps" / path.name).stat().st_mtime_ns == written


@pytest.mark.shared
@pytest.mark.parametrize(
    ("name", "sweeps", "sensors"),
    [("pp-plate-nominal", 31, 1), ("pp-plate-orthotropic", 31, 1), ("pp-plate-two-effects", 32, 3)],
)
def test_campaigns_of_another_maker(
    tmp_path: Path, run_flexura: Run, name: str, sweeps: int, sensors: int
) -> None:
    if not SHARED.is_dir():
        pytest.skip("the recorded campaigns are not beside this checkout")
    status, output, message = run_flexura("import", SHARED / name, "--out", tmp_path / "out", "--json")
    assert status == 0, message
    assert json.loads(output)["sweeps"] == sweeps
    campaign = load_campaign(tmp_path / "out")
    assert same(campaign, load_campaign(SHARED / name))
    assert {sweep.responses.shape[0] for sweep in campaign.sweeps} == {sensors}
    assert all(np.abs(sweep.drive).max() == pytest.approx(1.0, abs=1e-3) for sweep in campaign.sweeps)
