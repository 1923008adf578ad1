"""How campaigns stand, in fields, in a line, and as exit status."""

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from app.files.folder_lock import folder_lock
from app.watch.status import CampaignStatus
from app.watch.watcher import WatchedFolder, names
from app.watch.words import in_words
from tests.app.watch.conftest import Campaign, add, age

Flexura = Callable[..., tuple[int, str, str]]
AT_REST = {"event": "oven", "command": "safe", "purpose": "RigStopped: a door was opened", "unsafe": []}
PATIENCE = 60.0 + 3 * (0.5 + 0.2 + 0.5) + 5.0
"""A sweep of three repeats with what the cards need, an interval between readings, and the margin, s."""


def status(folder: Path, later: float = 0.0) -> CampaignStatus:
    return WatchedFolder(folder, folder.name).look(time.time() + later)


def test_a_campaign_that_is_complete(finished: Path) -> None:
    found = status(finished, later=1e6)
    assert (found.state, found.finished, found.missing, found.total) == ("complete", 6, 0, 6)
    assert (found.rest, found.unsafe, found.exit_status) == ("at rest", (), 0)
    assert found.plate == pytest.approx(34.0, abs=0.4)
    assert found.line.startswith(f"complete; 6 of 6 sweeps; plate {found.plate:.2f} °C, air ")


def test_one_under_way_knows_temperatures_limits_and_its_end(campaign: Campaign) -> None:
    folder = campaign("going", events=6, readings=100)
    found = status(folder)
    assert (found.state, found.exit_status, found.rest) == ("running", 5, "follows the programme")
    assert (found.coldest, found.hottest) == (-10.0, 70.0)
    line = (folder / "readings.csv").read_text().splitlines()[-1].split(",")
    assert (found.read, found.air, found.seconds_left) == (line[0], float(line[1]), float(line[-1]))
    assert found.ends is not None
    assert found.ends > line[0]
    assert found.set_point == pytest.approx(found.air, abs=1.0)  # the oven follows its ramp
    assert "of simulated time" in found.line


@pytest.mark.parametrize(("later", "state"), [(0.9 * PATIENCE, "running"), (1.05 * PATIENCE, "silent")])
def test_silence_begins_after_a_sweep_and_a_margin(campaign: Campaign, later: float, state: str) -> None:
    found = status(campaign("dead"), later)
    assert found.state == state
    assert found.patience == pytest.approx(PATIENCE)
    assert found.exit_status == (4 if state == "silent" else 5)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nobody says who is gone")
def test_one_that_was_killed_is_silent_at_once(campaign: Campaign) -> None:
    """Not after a minute; of a process on another computer nobody here can tell."""
    folder = campaign("killed")
    with folder_lock(folder):
        assert status(folder).state == "running"
        held = (lock := folder.with_name("killed.lock")).read_text()
    owner = json.loads(held) | {"begun": 1}
    lock.write_text(json.dumps(owner))
    found = status(folder)
    assert (found.state, found.abandoned, found.exit_status) == ("silent", True, 4)
    assert found.line.startswith("silent: its process is gone without a word for ")
    assert found.line.endswith("the same flexura acquire continues it")
    lock.write_text(json.dumps(owner | {"system": "elsewhere"}))
    assert status(folder).state == "running"


def test_a_rig_in_trouble_has_the_time_that_it_needs_to_overcome_it(campaign: Campaign) -> None:
    lost = [
        {"event": "trouble", "what": "the cards are lost"},
        {"event": "oven", "command": "hold", "purpose": "cards lost"},
    ]
    folder = campaign("lost-cards", more=lost)
    assert status(folder, PATIENCE + 100.0).state == "running"
    assert status(folder).trouble == "the cards are lost"
    assert status(folder, PATIENCE + 130.0).state == "silent"
    add(folder, {"event": "recovered", "what": "the cards are back"})
    assert status(folder).trouble == ""
    assert status(folder, PATIENCE + 100.0).state == "silent"


def test_a_campaign_that_is_continued_runs_before_its_first_ramp(campaign: Campaign) -> None:
    folder = campaign("again", more=[AT_REST])
    found = status(folder)
    assert (found.state, found.exit_status, found.ending) == ("stopped", 1, "a door was opened")
    add(folder, {"event": "resumed", "finished": 1})
    assert status(folder).state == "running"


@pytest.mark.parametrize(
    ("logged", "said"),
    [
        ("RigInterrupted: SIGINT", "Ctrl-C; the same command continues it"),
        ("RigInterrupted: SIGTERM", "kill; the same command continues it"),
        ("RigInterrupted: the console was closed", "the console was closed; the same command continues it"),
        ("OSError: [Errno 28] 0 MB are free, 50 MB are needed: 'a'", "0 MB are free, 50 MB are needed: 'a'"),
        ("OvenError: the oven does not answer", "the oven does not answer"),
        ("KeyError: 'a'", "KeyError: 'a'"),
    ],
)
def test_why_a_campaign_ended_is_said_in_the_words_of_people(campaign: Campaign, logged: str, said: str) -> None:
    found = status(campaign("ended", more=[{**AT_REST, "purpose": logged}]))
    assert (found.ending, found.line.partition("; 1 of 6")[0]) == (said, f"stopped: {said}")
    assert in_words({**AT_REST, "purpose": logged}) == f"oven at rest, drive at 0 V: {said}"


def test_what_is_not_at_rest_comes_before_everything(campaign: Campaign, finished: Path) -> None:
    unsafe = [{**AT_REST, "purpose": "the end", "unsafe": ["the oven: it does not answer"]}]
    found = status(campaign("hot", events=None, more=unsafe))
    assert (found.state, found.exit_status) == ("complete", 3)
    assert found.line.startswith("NOT AT REST: the oven: it does not answer; complete")


def test_the_watchdog_has_the_last_word_on_the_oven(campaign: Campaign) -> None:
    folder = campaign("watchdog")
    protocol = json.loads((folder / "protocol.json").read_text())
    protocol["acquired"]["rig"] = "real"
    from app.files.campaigns.folder import _digest

    del protocol["sha256"]
    (folder / "protocol.json").write_text(json.dumps(protocol | {"sha256": _digest(protocol)}))
    log = folder / "watchdog.log"
    log.write_text("2030-01-01 01:00:00+00:00 NOT AT REST: the oven: it cannot be switched off. Go there.\n")
    assert status(folder).unsafe == ("the oven: it cannot be switched off. Go there.",)
    assert status(folder).exit_status == 3
    with log.open("a") as file:
        file.write("2030-01-01 01:01:00+00:00 the oven is at rest\n\x00\x00no line of it\n")
    assert (status(folder).unsafe, status(folder).rest) == ((), "at rest")


def test_sweeps_given_up_count_once_and_not_if_made_later(campaign: Campaign) -> None:
    given_up = {"event": "missing", "step": 3, "place": "30 °C up 1 V", "why": "passed"}
    folder = campaign("given-up", events=None, more=[{**given_up, "step": 7}, {**given_up, "step": 7}])
    assert status(folder).missing == 1
    assert status(folder).exit_status == 1
    assert "complete with sweeps missing; 6 of 6 sweeps, 1 given up" in status(folder).line
    add(folder, {"event": "finished", "step": 7, "place": "x", "attempt": 1, "temperature": 30.0})
    assert status(folder).missing == 0


@pytest.mark.parametrize(("gone", "left"), [("*", 0), ("0003*", 5)])
def test_sweeps_that_are_not_there_any_more_are_told(campaign: Campaign, gone: str, left: int) -> None:
    """It was "complete; 6 of 6 sweeps" with an empty folder."""
    folder = campaign("lost", events=None)
    for path in list((folder / "sweeps").glob(gone)):
        path.unlink()
    found = status(folder)
    assert (found.state, found.finished, found.exit_status) == ("complete", left, 1)
    assert found.line.startswith(f"complete with sweeps missing; {left} of 6 sweeps")
    assert f"sweeps/: {6 - left} of 6 that were recorded are not there any more" in found.line


def test_a_log_that_is_away_is_told_and_sweeps_are_counted_by_their_files(campaign: Campaign) -> None:
    """It was "not begun; 0 of 6 sweeps", with hours left."""
    folder = campaign("without", events=None)
    (folder / "events.jsonl").unlink()
    found = status(folder)
    assert (found.state, found.finished, found.exit_status) == ("stopped", 6, 1)
    assert "events.jsonl: not there, or it cannot be read" in found.line


def test_a_campaign_is_told_once_and_its_lock_is_none(campaign: Campaign, run_flexura: Flexura) -> None:
    folder = campaign("going")
    lock = folder.with_name("going.lock")
    lock.touch()
    code, out, err = run_flexura("status", str(folder), f"{folder}/", str(lock))
    assert (code, out.count("going:"), err) == (5, 1, "")


def test_a_folder_that_cannot_be_read_does_not_hide_the_others(
    campaign: Campaign, tmp_path: Path, run_flexura: Flexura, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(path: Path) -> bool:
        if path.name == "noread":
            raise PermissionError(13, "Permission denied", str(path))
        return (path / "protocol.json").is_file()

    monkeypatch.setattr("app.files.campaigns.kind.is_campaign_folder", denied)
    (tmp_path / "noread").mkdir()
    code, out, err = run_flexura("status", str(tmp_path / "noread"), str(campaign("going")))
    assert (code, err) == (2, f"Error: {tmp_path / 'noread'}: cannot be read: Permission denied\n")
    assert out.startswith("going: running")


def test_a_folder_that_disappears_and_comes_back(campaign: Campaign) -> None:
    folder = campaign("fleeting")
    watched = WatchedFolder(folder, "fleeting")
    assert watched.look(time.time()).state == "running"
    folder.rename(folder.with_name("away"))
    found = watched.look(time.time())
    assert (found.state, found.exit_status) == ("gone", 4)
    assert "the folder cannot be read" in found.line
    assert watched.charts() is None
    folder.with_name("away").rename(folder)
    assert watched.look(time.time()).state == "running"


def test_a_log_that_was_begun_anew_is_read_anew(campaign: Campaign, finished: Path) -> None:
    folder = campaign("anew")
    watched = WatchedFolder(folder, "anew")
    watched.look(time.time())
    lines = (finished / "events.jsonl").read_text().splitlines(keepends=True)
    (folder / "events.jsonl").write_text(lines[0])
    (folder / "protocol.json").write_bytes((finished / "protocol.json").read_bytes())  # as put_log_aside does
    assert watched.look(time.time()).finished == 0


def test_names_are_told_apart() -> None:
    assert names([Path("/a/one"), Path("/a/two")]) == ("one", "two")
    assert names([Path("/a/x/one"), Path("/b/x/one"), Path("/b/two")]) == ("a/x/one", "b/x/one", "two")
    assert names([Path("/a/\x1b[31mred\nline")]) == (" [31mred line",) or "\x1b" not in names([Path("/a/\x1b")])[0]


def test_events_of_every_kind_are_sentences() -> None:
    ramp = {"event": "oven", "command": "ramp", "target": 64.0, "rate": 0.4, "purpose": "leg"}
    for event, words in (
        (ramp, "oven: ramp to 64 °C at 0.4 K/min, the leg's ramp"),
        ({**AT_REST, "purpose": "the end"}, "oven at rest, drive at 0 V: the campaign has ended"),
        ({"event": "missing", "place": "3 °C", "why": "passed"}, "given up: 3 °C: passed"),
        (
            {"event": "rejected", "place": "3 °C", "attempt": 2, "faults": ["a", "b"]},
            "rejected: 3 °C, attempt 2: a; b",
        ),
        ({"event": "new kind", "date": "d", "some": [1]}, "new kind: some [1]"),
        ({"event": "trouble", "what": "\x1b[2Jgone\u202e"}, "trouble:  [2Jgone"),
    ):
        assert in_words(event) == words


def test_the_verb_says_it_with_its_exit_status(campaign: Campaign, finished: Path, run_flexura: Flexura) -> None:
    folder = campaign("stopped", more=[AT_REST])
    code, out, err = run_flexura("status", str(folder))
    assert (code, err) == (1, "")
    assert out.startswith("stopped: stopped: a door was opened; 1 of 6 sweeps")
    code, out, _ = run_flexura("status", str(finished), str(folder), "--json")
    assert code == 1
    assert [one["state"] for one in json.loads(out)] == ["complete", "stopped"]
    dead = campaign("dead")
    age(dead, 3600.0)
    assert run_flexura("status", str(finished), str(folder), str(dead))[0] == 4
    assert run_flexura("status", str(finished), "--quiet") == (0, "", "")


def test_a_name_that_is_no_campaign_does_not_hide_the_others(
    campaign: Campaign, finished: Path, tmp_path: Path, run_flexura: Flexura
) -> None:
    unsafe = campaign("unsafe", more=[AT_REST | {"unsafe": ["oven"]}])
    none = str(tmp_path / "mistyped")
    code, out, err = run_flexura("status", none, str(finished), "--json")
    assert (code, [one["state"] for one in json.loads(out)]) == (2, ["complete", "refused"])
    assert err == f"Error: {none}: does not exist; allowed: a folder with protocol.json or hammer.json, " + (
        "as flexura acquire makes it\n"
    )
    code, out, err = run_flexura("status", str(unsafe), none)
    assert code == 3
    assert "NOT AT REST" in out
    assert "mistyped: does not exist" in err


def test_what_is_no_campaign_is_refused_in_a_sentence(tmp_path: Path, run_flexura: Flexura) -> None:
    for folder, words in ((tmp_path / "none", "does not exist"), (tmp_path, "is no campaign of flexura acquire")):
        for verb in ("status", "watch"):
            code, out, err = run_flexura(verb, str(folder))
            assert (code, out) == (2, "")
            assert words in err
            assert err.count("\n") == 1


def test_a_folder_of_campaigns_names_them(campaign: Campaign, tmp_path: Path, run_flexura: Flexura) -> None:
    campaign("left rig")
    campaign("right")
    code, _, err = run_flexura("status", str(tmp_path))
    assert code == 2
    assert f"It holds such: '{tmp_path / 'left rig'}', {tmp_path / 'right'}" in err
