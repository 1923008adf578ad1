"""Times are local, with their offset, wherever people read them, and UTC in files."""

import ast
import json
import re
import sys
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest

from app.rig.doctor import _clock
from app.terminal.campaign import campaign_screen
from app.watch.words import local, said_at
from drivers.rig.campaign import Moment
from drivers.rig.occupancy import RigInUse, occupied
from drivers.rig.readings import Reading
from drivers.watchdog.process import Herald

ROOT = Path(__file__).resolve().parents[2]
OFFSET = r"\+05:?30"
"""Of Kolkata, which no computer of a test stands at by chance; nothing is UTC there."""
FOR_MACHINES = {
    "app/files/campaigns/tdms_sweep.py": "reads dates of files",
    "app/files/acquisition/events.py": "reads dates of logs",
    "app/modal_test/edit_journal.py": "journal.jsonl",
    "app/modal_test/declared_test.py": "day of a declaration, no time of day",
    "app/report/plate_sections.py": "day of a declaration, no time of day",
    "app/watch/status.py": "status --json, and the page, whose script makes them local",
    "drivers/rig/station.py": "events.jsonl",
    "drivers/rig/session.py": "events.jsonl",
    "drivers/hammer/campaign.py": "events.jsonl and hits",
}
"""Modules that format times as they stand in files, or days."""
FORMATS = ("isoformat", "strftime", "ctime", "asctime")


@pytest.fixture
def kolkata(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Let this computer stand in Kolkata."""
    if sys.platform == "win32":
        pytest.skip("Windows has no tzset")
    monkeypatch.setenv("TZ", "Asia/Kolkata")
    time.tzset()
    yield
    monkeypatch.undo()
    time.tzset()


def test_whatever_is_not_written_into_a_file_is_made_local_where_it_is_formatted() -> None:
    """Every place in the source that formats a time: made local in the same expression, or known as a file's."""
    astray = []
    for folder in ("app", "drivers", "analysis", "simulation", "flexura"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            source = path.read_text(encoding="utf-8")
            for node in ast.walk(ast.parse(source)):
                if (
                    isinstance(node, ast.Call)
                    and isinstance(node.func, ast.Attribute)
                    and node.func.attr in FORMATS
                ):
                    text = ast.get_source_segment(source, node) or ""
                    if "astimezone()" not in text and name not in FOR_MACHINES:
                        astray.append(f"{name}:{node.lineno}: {text}")
    assert astray == []


@pytest.mark.usefixtures("kolkata")
def test_lines_of_a_log_that_is_no_terminal_say_when(capsys: pytest.CaptureFixture[str]) -> None:
    with campaign_screen(clock_is_virtual=False) as show:
        show(Moment("ramp", 20.0, 1, 8, 60.0, "2026-03-01T08:00:00+00:00", Reading(20.0, 20.0)))
    said = capsys.readouterr().err
    assert re.match(rf"{datetime.now():%Y-%m-%d %H}:\d\d:\d\d {OFFSET} 1 of 8 sweeps", said)


@pytest.mark.usefixtures("kolkata")
def test_dates_of_the_log_are_said_local_those_of_a_simulated_rig_as_its_clock_has_them() -> None:
    assert local("2026-03-01T08:00:05+00:00") == "2026-03-01 13:30:05 +0530"
    assert said_at("2000-01-01T08:00:05+00:00", simulated=True) == "08:00:05 simulated"
    assert said_at("2026-03-01T08:00:05+00:00", simulated=False) == "2026-03-01 13:30:05 +0530"


@pytest.mark.usefixtures("kolkata")
def test_what_the_watchdog_says_has_its_time(tmp_path: Path) -> None:
    herald = Herald(str(tmp_path / "said.log"))
    herald.say("the oven is at rest")
    herald.wait(10.0)
    assert re.match(rf"\d{{4}}-\d\d-\d\d \d\d:\d\d:\d\d{OFFSET} the oven", (tmp_path / "said.log").read_text())


@pytest.mark.usefixtures("kolkata")
def test_who_holds_the_rig_is_said_with_since_when(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.rig.occupancy.lock_folder", lambda: tmp_path)
    with (
        occupied(["oven at COM7"], "flexura acquire"),
        pytest.raises(RigInUse, match=rf"since .*{OFFSET}"),
        occupied(["oven at COM7"], "flexura safe"),
    ):
        pass


@pytest.mark.usefixtures("kolkata")
def test_doctor_says_the_time_of_day_as_the_clock_on_the_wall_has_it(tmp_path: Path) -> None:
    assert re.search(rf"{datetime.now():%Y-%m-%dT%H}:\d\d:\d\d{OFFSET}", _clock(tmp_path).seen)


@pytest.mark.usefixtures("kolkata")
def test_the_journal_of_changes_is_utc(tmp_path: Path) -> None:
    from app.modal_test.edit_journal import EditJournal

    journal = EditJournal(tmp_path)
    (tmp_path / "edits").mkdir()
    journal._note("done", "mode dropped", 1)
    (line,) = (json.loads(text) for text in (tmp_path / "edits" / "journal.jsonl").read_text().splitlines())
    assert abs((datetime.fromisoformat(line["date"]) - datetime.now(UTC)).total_seconds()) < 60.0
    assert line["date"].endswith("+00:00")
