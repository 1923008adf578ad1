"""What the watcher beside a campaign says reaches the campaign's process, which never waits for it for long."""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from app.watch import beside
from app.watch.beside import watched_beside
from app.watch.watching import LONGEST_NOTE, MOST_NOTES

ADDRESS = "print(json.dumps({'url': 'http://x/'}, indent=1), flush=True)\n"
Watching = Callable[..., list[str]]


@pytest.fixture
def watch(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Watching:
    """Return a function that has a campaign watched by a program, until both have ended; what was said."""

    def of(
        program: str, *, notify: tuple[str, ...] = ("x://y",), campaign: Callable[[], None] = lambda: None
    ) -> list[str]:
        said: list[str] = []
        command = [sys.executable, "-c", f"import json, os, sys, time\n{program}"]
        monkeypatch.setattr(beside, "module_command", lambda *_: command)
        with watched_beside(tmp_path, notify, (), said.append):
            campaign()
        return said

    return of


def test_what_could_not_be_told_is_said_and_waited_for(watch: Watching) -> None:
    said = watch("print('a warning', file=sys.stderr)\n" + ADDRESS + "sys.stdin.read(); print('not told')")
    assert said == ["watched at http://x/", "not told"]


def test_a_watcher_that_cannot_begin_says_why(watch: Watching) -> None:
    assert watch("print('first'); print('Error: no port is free')") == ["not watched: Error: no port is free"]
    assert watch("") == ["not watched: the watcher ended without a word"]
    assert watch("print('}')") == ["not watched: }"]


def test_the_wait_is_short_and_there_only_where_something_is_told(
    watch: Watching, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(beside, "TOLD_WITHIN", 0.3)
    hangs = ADDRESS + "time.sleep(5)"
    assert watch(hangs)[-1].startswith("whether the end of the campaign could be told is not known yet")
    assert not [one for one in watch(hangs, notify=()) if "not known" in one]


def test_a_campaign_that_failed_is_not_held_up(watch: Watching) -> None:
    def fails() -> None:
        raise KeyError

    began = time.monotonic()
    with pytest.raises(KeyError):
        watch("time.sleep(60)", campaign=fails)
    assert time.monotonic() - began < beside.TOLD_WITHIN


def test_a_watcher_that_ends_before_the_campaign_is_missed(watch: Watching) -> None:
    said = watch(ADDRESS, campaign=lambda: time.sleep(2.0))
    assert said == ["watched at http://x/", "the watcher has ended; nothing more is told of this campaign"]


NOTING = """
import time
from app.watch.watching import CampaignsProcess
process = CampaignsProcess()
process.leave_streams()
for number in range(500):
    process.note(f"{number}: " + "ü\\n" * 500)
process.end()
process.note("too late")
assert process.left.wait(30.0)
"""


def test_notes_fill_no_pipe_and_need_no_reader() -> None:
    """Nobody reads, then nobody is there: the watcher does not notice."""
    words: dict[str, Any] = {"cwd": Path(__file__).parents[3], "stdin": subprocess.PIPE, "stderr": subprocess.PIPE}
    child = subprocess.Popen([sys.executable, "-c", NOTING], **words)
    child.stdin.close()
    assert child.wait(30.0) == 0
    with child.stderr as stream:
        lines = stream.read().splitlines(keepends=True)
    assert len(lines) == MOST_NOTES
    assert sum(map(len, lines)) < 4096
    assert max(map(len, lines)) <= LONGEST_NOTE + 1
    assert lines[-1] == b"more could not be told; the page counts them\n"
    child = subprocess.Popen([sys.executable, "-c", NOTING], **words)
    child.stderr.close()
    child.stdin.close()
    assert child.wait(30.0) == 0
