"""The watchdog's process: owns the oven's port, and outlives the campaign until the oven is at rest.

Started by `drivers.watchdog.remote_oven`. It belongs to no terminal and ignores every signal that can be ignored;
SIGTERM, as a computer that shuts down sends it, brings the oven to rest. It ends when the campaign has closed the
oven, or has died, and the oven is at rest.
"""

import contextlib
import gc
import json
import logging
import math
import os
import queue
import signal
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from drivers.clock import SystemClock
from drivers.interruptions import ENDING, signal_name
from drivers.ovens.error import OvenError
from drivers.ovens.settings import oven_settings
from drivers.own_process import module_command
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.watchdog.frames import BEAT, Messages, WatchdogSettings, packed, received
from drivers.watchdog.guard import State
from drivers.watchdog.supervision import SupervisedOven

STOPPED = 4.0
"""Time for which a campaign whose process is stopped (Ctrl-Z, SIGSTOP) may be silent, s."""
ZERO_WITHIN = 60.0
"""Longest time that bringing the drive to 0 V may take, s."""
UNHEARD = 15.0
"""A campaign that was ended has so long to say it itself, s; then the watchdog says it."""
GONE = "the campaign's process has ended without bringing the oven to rest"

log = logging.getLogger(__name__)


class Herald:
    """Says what people have to know, on the terminal and in a file, without ever waiting for either.

    Parameters
    ----------
    file : str or None
        Appended to.
    """

    def __init__(self, file: str | None) -> None:
        self._file = file
        self._said: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._done = threading.Event()
        self._done.set()
        threading.Thread(target=self._speak, daemon=True).start()

    def say(self, message: str) -> None:
        """Say a message, in a thread of its own: a terminal may be stopped, a folder may hang."""
        self._done.clear()
        self._said.put(f"{datetime.now().astimezone().isoformat(sep=' ', timespec='seconds')} {message}\n")

    def wait(self, seconds: float) -> None:
        """Wait until everything is said, but no longer than this."""
        self._done.wait(seconds)

    def _speak(self) -> None:
        while True:
            message = self._said.get()
            with contextlib.suppress(OSError):
                os.write(2, f"flexura watchdog: {message}".encode())
            if self._file is not None:
                with contextlib.suppress(OSError), Path(self._file).open("a", encoding="utf-8") as file:
                    file.write(message)
            if self._said.empty():
                self._done.set()


class ParentProcess:
    """What the watchdog knows of the campaign's process.

    Attributes
    ----------
    left : bool
        Whether it has closed the oven: what follows is the watchdog's own.
    """

    def __init__(self, settings: WatchdogSettings) -> None:
        self._parent = settings.parent
        self._ending = frozenset(settings.ending)
        self._trouble: RigStopped | None = None
        self._beat = time.monotonic()
        self.gone = threading.Event()
        self.left = False
        if settings.signals is not None:
            threading.Thread(target=self._hear_signals, args=(settings.signals,), daemon=True).start()

    def beaten(self) -> None:
        """Record that it is alive."""
        self._beat = time.monotonic()

    def fail(self, what: str, next_step: str = RESUME) -> None:
        """Record what ends it; only the first counts."""
        self._trouble = self._trouble or RigStopped(what, next_step)

    def end(self) -> None:
        """Record that its end of the pipe is closed."""
        if not self.left:
            self.fail(GONE)
        self.gone.set()

    def check(self) -> None:
        """Raise RigStopped if it is to end, is dead or is stopped; called once a second by the supervision."""
        if not self.left and os.name != "nt" and os.getppid() != self._parent:
            self.end()  # a process it has forked may hold the pipe open
        silent = time.monotonic() - self._beat
        if self._trouble is None and silent > STOPPED and _is_stopped(self._parent):
            self.fail(f"the campaign's process has been stopped (SIGSTOP, Ctrl-Z) for {silent:.0f} s")
        if self._trouble is not None:
            raise self._trouble

    def _hear_signals(self, descriptor: int) -> None:
        """Read the numbers of the signals, which arrive even while the campaign's interpreter is blocked."""
        while data := os.read(descriptor, 64):
            for number in data:
                if number in self._ending:
                    self.fail(f"asked to end: {signal_name(number)}")


def _is_stopped(process: int) -> bool:
    """Whether Linux says that a process is stopped; False where it does not say."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] in ("T", "t")
    except (OSError, IndexError):
        return False


class Watchdog:
    """The oven, the campaign and the lines between.

    Parameters
    ----------
    settings : WatchdogSettings
    answers : Messages
    """

    def __init__(self, settings: WatchdogSettings, answers: Messages) -> None:
        self._settings = settings
        self._answers = answers
        self._herald = Herald(settings.log)
        self._campaign = ParentProcess(settings)
        self._commands: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        clock = SystemClock()
        declared = oven_settings(settings.oven)
        oven = declared.open(clock)
        self._oven = SupervisedOven(
            oven,
            settings.limits,
            clock,
            self._campaign.check,
            settings.rest,
            reopen=lambda: declared.open(clock),
            tell=self._herald.say,
        )
        self._oven.begin()
        signal.signal(signal.SIGTERM, lambda *_: self._campaign.fail("the watchdog was asked to end: SIGTERM"))
        answers.send(ready=[oven.limits.minimum, oven.limits.maximum, oven.limits.max_rate])
        clock.every(BEAT, self._beat)

    def run(self) -> int:
        """Obey until the campaign has left or gone, then look after the oven; return the exit status."""
        threading.Thread(target=self._listen, daemon=True).start()
        ended: float | None = None
        while not self._campaign.gone.is_set():
            with contextlib.suppress(queue.Empty):
                self._obey(self._commands.get(timeout=BEAT))
            if self._oven.wrong is None or ended == math.inf:
                continue
            ended = time.monotonic() if ended is None else ended
            if time.monotonic() - ended > UNHEARD:
                ended = math.inf
                self._herald.say(f"{self._oven.wrong} The oven: {self._oven.state}. The campaign does not answer.")
        if not self._campaign.left:
            self._herald.say(f"{GONE}; the oven is being brought to rest")
        return self._linger()

    def _listen(self) -> None:
        while (line := received(sys.stdin.buffer)) is not None:
            self._campaign.beaten()
            if "age" in line:
                self._oven.alive(float(line["age"]))
            else:
                self._commands.put(line)
        self._campaign.end()

    def _obey(self, line: dict[str, Any]) -> None:
        verbs: dict[str, Callable[..., Any]] = {
            "temperature": self._oven.temperature,
            "bounds": self._oven.bounds,
            "ramp_to": self._ramp_to,
            "hold": self._oven.hold,
            "safe": self._oven.safe,
            "leave": self._leave,
        }
        try:
            value = verbs[line["do"]](*line.get("with", ()))
        except Exception as error:  # noqa: BLE001 (whatever it is, the campaign has to hear it)
            self._answers.send(to=line["number"], error=packed(error))
        else:
            self._answers.send(to=line["number"], value=value)

    def _ramp_to(self, target: float, rate: float) -> list[float]:
        taken = self._oven.ramp_to(target, rate)
        return [taken.target, taken.rate]

    def _leave(self) -> str:
        self._campaign.left = True
        return str(self._oven.state)

    def _beat(self) -> None:
        wrong = self._oven.wrong
        self._answers.send(state=str(self._oven.state), wrong=None if wrong is None else packed(wrong))

    def _linger(self) -> int:
        """Look after the oven until it is at rest, for an hour at most."""
        if not self._campaign.left:
            # the supervision finds by itself that the campaign is gone; meanwhile the drive
            self._zero_drive()
        elif self._oven.state is State.WATCHING:  # left without a word: as a test shot leaves it
            self._oven.end()
            self._oven.close()
            return 0
        self._sign_locks()
        until = time.monotonic() + self._settings.linger
        while self._oven.state is not State.AT_REST and time.monotonic() < until:
            time.sleep(0.2)
        at_rest = self._oven.state is State.AT_REST
        self._oven.end()
        if not self._campaign.left or not at_rest:
            self._herald.say("the oven is at rest" if at_rest else "NOT AT REST: the oven. The watchdog ends.")
        self._oven.close()
        self._herald.wait(5.0)
        return 0 if at_rest else 3

    def _sign_locks(self) -> None:
        """Write into the files of the rig's locks who holds them now: whoever wants the rig is told that."""
        since = datetime.now().astimezone().isoformat(sep=" ", timespec="minutes")
        signed = f"process {os.getpid()} (the watchdog, until the oven is at rest, since {since})".encode()
        for lock in self._settings.locks:
            with contextlib.suppress(OSError):
                if stat.S_ISREG(os.fstat(lock).st_mode):
                    os.pwrite(lock, signed, 0)
                    os.ftruncate(lock, len(signed))

    def _zero_drive(self) -> None:
        """Bring the drive to 0 V, in a process of its own: its driver is large, and may crash."""
        if self._settings.cards is None:
            return
        try:
            done = subprocess.run(  # noqa: S603 (a module of ours)
                module_command("drivers.watchdog.zero_drive"),
                input=json.dumps(dict(self._settings.cards)).encode(),
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                timeout=ZERO_WITHIN,
                check=False,
            )
            failed = done.stdout.decode(errors="replace").strip() if done.returncode else ""
        except (OSError, subprocess.TimeoutExpired) as error:
            failed = f"{error}"
        if failed:
            self._herald.say(f"NOT AT REST: {failed}")


def main() -> int:
    """Read the settings, open the oven, and watch it."""
    others = (getattr(signal, name, None) for name in ("SIGTSTP", "SIGTTIN", "SIGTTOU", "SIGPIPE", "SIGXFSZ"))
    for number in (*ENDING, *(int(one) for one in others if one is not None)):
        signal.signal(number, signal.SIG_IGN)  # SIGTERM is heard later, when there is something to bring to rest
    line = received(sys.stdin.buffer)
    if line is None:
        return 1
    answers = Messages(sys.stdout.buffer)
    try:
        watchdog = Watchdog(WatchdogSettings.model_validate(line), answers)
    except OvenError as error:
        answers.send(failed=packed(error))
        return 1
    gc.freeze()  # nothing made so far is ever searched for garbage again
    return watchdog.run()


if __name__ == "__main__":
    sys.exit(main())
