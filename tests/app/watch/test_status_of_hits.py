"""How hammer tests stand: alive, stopped, gone, complete; at which point, and what to do next."""

import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from app.files.acquisition.events import read_events
from app.files.acquisition.hammer_folder import said_of_missing_hits
from app.files.declarations.hammer_experiment import HammerExperiment, read_hammer_experiment
from app.files.folder_lock import folder_lock
from app.watch.news import NewsOfCampaign
from app.watch.status import CampaignStatus
from app.watch.watcher import WatchedFolder, Watcher
from drivers.hammer.campaign import Key
from tests.app.hammer_bench import acquire, experiment, text_with_oven
from tests.app.watch.conftest import add

Flexura = Callable[..., tuple[int, str, str]]


def status(folder: Path) -> CampaignStatus:
    return WatchedFolder(folder, folder.name).look(time.time())


def two_hits(**hand: float) -> HammerExperiment:
    declared = experiment(double_hits=0.0, overloads=0.0, **hand)
    return declared.model_copy(update={"hammer": declared.hammer.model_copy(update={"hits": 2})})


def stopped_after(count: int, folder: Path) -> Callable[[], Key | None]:
    keys: Iterator[Key | None] = iter(["stop"])
    return lambda: next(keys, None) if len(list((folder / "hits").glob("*.h5"))) == count else None


def test_one_that_is_complete(tmp_path: Path, run_flexura: Flexura) -> None:
    folder = tmp_path / "hits"
    acquire(two_hits(), folder)
    found = status(folder)
    assert (found.state, found.kind, found.finished, found.missing, found.total) == ("complete", "hits", 18, 0, 18)
    assert (found.rest, found.unsafe, found.exit_status) == ("at rest", (), 0)
    code, out, err = run_flexura("status", folder)
    assert code == 0, err
    assert out.startswith("hits: complete; 18 of 18 hits; plate 21.00 °C; flexura identify ")
    assert said_of_missing_hits(folder, [f"hits/{one.name}" for one in (folder / "hits").iterdir()]) == []


def test_one_that_was_stopped_and_one_under_way(tmp_path: Path, run_flexura: Flexura) -> None:
    folder = tmp_path / "hits"
    acquire(two_hits(), folder, stopped_after(5, folder))
    found = status(folder)
    assert (found.state, found.finished, found.exit_status) == ("stopped", 5, 1)
    assert found.next_step == "the same flexura acquire goes on"
    code, _, err = run_flexura("identify", folder, "--band", 60, 600, "--out", tmp_path / "run", "--quiet")
    assert code == 0, err
    assert "note: hammer test: 5 of 18 hits, at 3 of 9 points: it was interrupted" in " ".join(err.split())
    with folder_lock(folder):
        found = status(folder)
        assert (found.state, found.exit_status) == ("running", 5)
        assert found.next_step == "hit the plate: hit 2 of 2 at point 3 of 9"
        code, out, err = run_flexura("status", folder, "--json")
        assert code == 5, err
        (record,) = json.loads(out)
        assert (record["finished"], record["total"], record["kind"]) == (5, 18, "hits")


def test_rejected_and_skipped_hits_are_counted(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    keys: Iterator[Key | None] = iter(["skip"])
    declared = experiment(double_hits=0.3, overloads=0.1)
    one = declared.model_copy(update={"hammer": declared.hammer.model_copy(update={"hits": 1})})
    outcome, _, _ = acquire(one, folder, lambda: next(keys, None))
    found = status(folder)
    assert (found.state, found.finished, found.missing, found.rejected) == ("complete", 8, 1, outcome.rejected)
    assert found.rejected
    assert found.exit_status == 1
    assert "--again asks for the 1 skipped points" in found.line


def test_one_whose_process_is_gone_while_the_oven_is_on(tmp_path: Path) -> None:
    file, folder = tmp_path / "oven.toml", tmp_path / "hits"
    file.write_text(text_with_oven().replace("hits = 2", "hits = 1"), encoding="utf-8")
    declared = read_hammer_experiment(file)
    acquire(declared, folder, stopped_after(3, folder))
    assert (status(folder).state, status(folder).rest) == ("stopped", "at rest")
    lines = (folder / "events.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
    assert '"safe"' in lines[-1]
    (folder / "events.jsonl").write_text("".join(lines[:-1]), encoding="utf-8")
    begun = json.loads((folder / "hammer.json").read_text(encoding="utf-8"))
    begun["acquired"]["rig"] = "real"
    (folder / "hammer.json").write_text(json.dumps(begun), encoding="utf-8")
    gone = status(folder)
    assert (gone.state, gone.rest, gone.exit_status) == ("silent", "follows the programme", 4)
    assert "look at the oven" in gone.line
    assert (gone.coldest, gone.hottest, gone.set_point) == (-10.0, 70.0, 25.0)
    news = NewsOfCampaign()
    assert [one.kind for one in news.of(gone)] == ["silent"]
    date = read_events(folder)[-1]["date"][:19] + "+00:00"
    log = folder / "watchdog.log"
    log.write_text(f"{date} NOT AT REST: the oven: it cannot be switched off.\n", encoding="utf-8")
    hot = status(folder)
    assert hot.exit_status == 3
    assert "it cannot be switched off" in hot.unsafe[0]
    log.write_text(log.read_text() + f"{date} the oven is at rest\n", encoding="utf-8")
    assert (status(folder).state, status(folder).rest) == ("stopped", "at rest")


def test_doubts_are_counted(tmp_path: Path) -> None:
    folder = tmp_path / "hits"
    acquire(two_hits(), folder)
    add(folder, {"event": "temperature in doubt", "step": 3, "what": ["about 0.7 K too high"]})
    assert status(folder).doubted == 1
    assert "the temperature of 1 in doubt" in status(folder).line


def test_the_page_and_its_watcher_take_both_kinds(tmp_path: Path, finished: Path, run_flexura: Flexura) -> None:
    folder = tmp_path / "hits"
    acquire(two_hits(), folder)
    watcher = Watcher([folder, finished], lambda news: None)
    hits, sweeps = watcher.look()
    assert (hits.kind, sweeps.kind) == ("hits", "sweeps")
    json.dumps(watcher.record(), allow_nan=False)
    assert watcher.charts(0) is None
    assert watcher.charts(1) is not None
    code, _, err = run_flexura("status", tmp_path)
    assert code == 2
    assert "hammer.json" in err


def test_doctor_knows_hammer_tests(tmp_path: Path, run_flexura: Flexura) -> None:
    file = tmp_path / "oven.toml"
    file.write_text(text_with_oven(), encoding="utf-8")
    code, out, err = run_flexura("doctor", file, "--json")
    assert code == 0, err
    found = {one["what"]: one["seen"] for one in json.loads(out)["findings"]}
    assert found["campaign"] == "at 3 temperatures, 9 points, 2 hits each"
    assert "MB needed for the 54 hits to be made" in found["disk"]
