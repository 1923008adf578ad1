"""An oven and a campaign, each in a process of its own, with the watchdog between them."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]


class ServedOven:
    """A simulated oven in real time, asked for its true state."""

    def __init__(self, child: "subprocess.Popen[str]") -> None:
        self._child = child
        self.address = self._line()

    def _line(self) -> str:
        assert self._child.stdout is not None
        return self._child.stdout.readline().strip()

    def state(self, word: str = "?") -> dict[str, Any]:
        assert self._child.stdin is not None
        self._child.stdin.write(f"{word}\n")
        self._child.stdin.flush()
        return dict(json.loads(self._line()))

    def seen(self, wanted: Callable[[dict[str, Any]], bool], within: float) -> float:
        """Return after how many seconds it is as wanted; fail if it is not within this time."""
        began = time.monotonic()
        while not wanted(self.state()):
            assert time.monotonic() - began < within, self.state()
            time.sleep(0.05)
        return time.monotonic() - began

    def end(self) -> None:
        """End its process."""
        self._child.kill()

    def off(self, within: float) -> float:
        """Return after how many seconds it is switched off."""
        return self.seen(lambda state: not state["regulating"], within)


class CampaignProcess:
    """A campaign's process, its watchdog's number, and what it says at its end."""

    def __init__(self, child: "subprocess.Popen[str]", folder: Path) -> None:
        self.child, self.folder = child, folder
        assert child.stdout is not None
        self.watchdog = int(child.stdout.readline())

    def left(self, within: float) -> dict[str, Any]:
        """Return how it left the rig."""
        out, _ = self.child.communicate(timeout=within)
        return dict(json.loads(out))

    def kill(self, *, watchdog: bool = False, number: int = signal.SIGKILL) -> None:
        os.kill(self.watchdog if watchdog else self.child.pid, number)

    @property
    def log(self) -> str:
        """What the watchdog has written."""
        file = self.folder / "watchdog.log"
        return file.read_text() if file.exists() else ""

    def watchdog_ended(self, within: float) -> bool:
        until = time.monotonic() + within
        while alive(self.watchdog) and time.monotonic() < until:
            time.sleep(0.05)
        return not alive(self.watchdog)


def alive(process: int) -> bool:
    """Whether a process is there and not a zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@contextmanager
def running(module: str, *words: str) -> Iterator["subprocess.Popen[str]"]:
    command = [sys.executable, "-m", f"tests.drivers.watchdog.{module}", *words]
    child = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    with child:
        try:
            yield child
        finally:
            child.kill()


@pytest.fixture
def oven_of() -> Iterator[Callable[..., ServedOven]]:
    """Return what starts an oven."""
    started = []

    def start(*words: str) -> ServedOven:
        context = running("served_oven", *words)
        started.append(context)
        return ServedOven(context.__enter__())

    yield start
    for context in started:
        context.__exit__(None, None, None)


@pytest.fixture
def oven(oven_of: Callable[..., ServedOven]) -> ServedOven:
    return oven_of()


@pytest.fixture
def campaign_on(tmp_path: Path) -> Iterator[Callable[[ServedOven, str], CampaignProcess]]:
    """Return what starts a campaign on an oven, and does a deed."""
    started: list[tuple[Any, CampaignProcess]] = []

    def start(oven: ServedOven, deed: str = "wait") -> CampaignProcess:
        context = running("campaign", oven.address, str(tmp_path), deed)
        campaign = CampaignProcess(context.__enter__(), tmp_path)
        started.append((context, campaign))
        return campaign

    yield start
    for context, campaign in started:
        for stopped in (campaign.watchdog, campaign.child.pid):
            with suppress(ProcessLookupError):
                os.kill(stopped, signal.SIGKILL)
        context.__exit__(None, None, None)
