"""A hammer test on a terminal: bells, colours and keys; none of them where there is no terminal."""

import os
import sys
from pathlib import Path

import pytest

from app.terminal.campaign import HammerScreen, hammer_keys
from drivers.hammer.campaign import AskedHit, ToldHit, no_key

PLACES = ((0.02, 0.03), (0.1, 0.12))
ASKED = AskedHit(0, 1, 2, 2, 5)


class Terminal:
    """A stream that says that it is a terminal, and keeps what is written."""

    encoding = "utf-8"

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        self.text += text
        return len(text)

    def flush(self) -> None:
        pass


def shown(screen: HammerScreen) -> None:
    screen.asked(ASKED)
    screen.told(ToldHit(ASKED, 7, 31.25, "", 0.9876))
    screen.told(ToldHit(ASKED, 8, 29.0, "double hit: 40 % of the force again 12.0 ms later", None))
    screen.said("hit 7 of point 2 undone: its file stays")


def test_on_a_terminal_a_hit_is_heard_and_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    shown(HammerScreen(PLACES, shown=True, keys=True))
    lines = terminal.text.splitlines()
    assert "u: undo the last hit" in lines[0]
    assert "Point 2 of 2 (0.100, 0.120) m: hit 2 of 5" in lines[1]
    assert "hit 2 accepted, 31.2 N, coherence 0.988" in lines[2]
    assert (lines[2].count("\a"), lines[3].count("\a"), lines[4].count("\a")) == (1, 2, 0)
    assert "\x1b[32m" in lines[2]
    assert "\x1b[31m" in lines[3]


def test_in_a_log_there_are_lines_alone(capsys: pytest.CaptureFixture[str]) -> None:
    screen = HammerScreen(PLACES, shown=True, keys=False)
    shown(screen)
    screen.asked(ASKED)  # the same point: a log does not repeat it
    said = capsys.readouterr()
    assert said.out == ""
    assert "\a" not in said.err
    assert "\x1b" not in said.err
    assert said.err.count("Point 2 of 2") == 1


def test_quiet_prints_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    shown(HammerScreen(PLACES, shown=False, keys=True))
    assert capsys.readouterr().err == ""


@pytest.mark.skipif(sys.platform == "win32", reason="terminals of POSIX")
def test_keys_are_taken_one_by_one_and_the_terminal_is_left_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    import pty
    import termios

    leader, follower = pty.openpty()
    before = termios.tcgetattr(follower)
    with os.fdopen(follower, "r") as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        with hammer_keys() as key:
            assert key() is None
            os.write(leader, b"uXSrq")
            taken = [key() for _ in range(6)]
        assert taken == ["undo", None, "skip", "repeat", "stop", None]
        assert termios.tcgetattr(stream.fileno()) == before
    os.close(leader)


def test_where_nobody_can_type_there_are_no_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path(os.devnull).open(encoding="utf-8") as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        with hammer_keys() as key:
            assert key is no_key
