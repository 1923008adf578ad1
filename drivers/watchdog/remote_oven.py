"""The oven as the campaign's process has it: every command goes to the watchdog's process.

If that dies or falls silent, it is killed, and the oven is brought to rest from here, by a second path: the port
is opened once more.
"""

import io
import itertools
import logging
import math
import os
import queue
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

from drivers.interruptions import ENDING
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.oven import Oven, OvenLimits, SetPoint
from drivers.own_process import module_command, own_surroundings
from drivers.rig.end_requests import RESUME, RigStopped
from drivers.watchdog.frames import BEAT, Messages, WatchdogSettings, received, unpacked

SILENT = 12.0
"""A watchdog that says nothing for longer counts as dead, s; it beats once a second."""
START_WITHIN = 60.0
"""Longest time from the start of the process to the first answer of the oven, s."""
ANSWER_WITHIN = 180.0
"""Longest time of one command, s: a slow line with all its repetitions."""
LEAVE_WITHIN = 5.0
"""Longest time that the watchdog may take to let go, s."""
SAYS_WHY = 2.0
"""Longest time from a pipe that is closed until the thread that hears has said what became of the process, s."""

log = logging.getLogger(__name__)


class RemoteOven:
    """Starts the watchdog and passes commands on; see `SupervisedOven`, which runs there.

    Parameters
    ----------
    settings : WatchdogSettings
        Its `parent`, `signals` and `ending` are filled in here.
    open_oven : callable
        Opens the oven in this process, if the watchdog has died.
    asked_to_end : callable
        Raises if the campaign is to end.
    inherited : sequence of int
        Descriptors, of locks, that the watchdog holds open as long as it lives.

    Raises
    ------
    OvenError
        If the oven cannot be opened.
    RigStopped
        If the process cannot be started.
    """

    poll_within = math.inf

    def __init__(
        self,
        settings: WatchdogSettings,
        open_oven: Callable[[], Oven],
        asked_to_end: Callable[[], None],
        inherited: Sequence[int] = (),
    ) -> None:
        self._open_oven = open_oven
        self._asked_to_end = asked_to_end
        self._numbers = itertools.count(1)
        self._waiting: dict[int, queue.SimpleQueue[dict[str, Any]]] = {}
        self._wrong: RigStopped | None = None
        self._lost = threading.Event()
        self._second_path = threading.Lock()
        self._own: Oven | None = None
        self._resting = self._left = False
        self._user = self._heard = time.monotonic()
        self._signals, self._wakeup_before = -1, -1
        ours = self._start(settings, inherited)
        self._ready: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        threading.Thread(target=self._hear, name="watchdog's answers", daemon=True).start()
        self._open(ours)

    def _start(self, settings: WatchdogSettings, inherited: Sequence[int]) -> WatchdogSettings:
        """Start the process; return the settings it gets."""
        passed = list(inherited)
        filled: dict[str, Any] = {"parent": os.getpid(), "locks": tuple(inherited)}
        ear = -1
        if os.name != "nt":
            ear, self._signals = os.pipe()
            os.set_blocking(self._signals, False)
            handled = tuple(int(n) for n in ENDING if callable(signal.getsignal(n)))
            filled |= {"signals": ear, "ending": handled}
            passed.append(ear)
        options: dict[str, Any] = {"pass_fds": passed, "start_new_session": True} if os.name != "nt" else {}
        try:
            self._process = subprocess.Popen(  # noqa: S603 (a module of ours)
                module_command("drivers.watchdog.process"),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                env=own_surroundings(),
                **options,
            )
        except OSError as error:
            raise RigStopped(f"the watchdog's process cannot be started: {error}", RESUME) from error
        finally:
            if ear >= 0:
                os.close(ear)
        assert self._process.stdin is not None and self._process.stdout is not None  # noqa: S101, PT018 (asked for)
        self._lines = Messages(self._process.stdin)  # type: ignore[arg-type]
        self._answers = io.BufferedReader(self._process.stdout)  # type: ignore[type-var]
        return settings.model_copy(update=filled)

    def _open(self, settings: WatchdogSettings) -> None:
        """Wait until the watchdog has opened the oven."""
        self._lines.send(**settings.model_dump(mode="json"))
        try:
            first = self._ready.get(timeout=START_WITHIN)
        except queue.Empty:
            first = {}
        if "ready" not in first:
            self._left = True
            self._end_process()
            self._let_go()
            if "failed" in first:
                raise unpacked(first["failed"])
            raise RigStopped("the watchdog's process does not start", f"Run flexura doctor. {RESUME}")
        self._limits = OvenLimits(*first["ready"])
        if self._signals >= 0 and threading.current_thread() is threading.main_thread():
            # Python writes a signal's number there in C, at once, even while a library blocks the interpreter
            self._wakeup_before = signal.set_wakeup_fd(self._signals, warn_on_full_buffer=False)
        threading.Thread(target=self._beat, name="watchdog's beat", daemon=True).start()

    @property
    def limits(self) -> OvenLimits:
        """Limits to which set-points are clamped."""
        return self._limits

    @property
    def process(self) -> int:
        """Number of the watchdog's process."""
        return self._process.pid

    def end(self) -> None:
        """Do nothing: the watchdog watches until the oven is at rest."""

    def restored(self, restore: Callable[[Oven], None]) -> None:
        """Do nothing: a real oven's state needs no restoring."""

    def check(self) -> None:
        """Record that the campaign is alive; raise if it is to end or the watchdog ended it."""
        self._user = time.monotonic()
        self._asked_to_end()
        if self._wrong is not None:
            raise self._wrong

    def temperature(self) -> float:
        """Air temperature, degrees Celsius."""
        if self._own is not None and self._resting:
            return self._own.temperature()
        return float(self._called("temperature"))

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest set-point that the controller itself takes, °C; infinite if unknown."""
        low, high = self._called("bounds")
        return float(low), float(high)

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Start a ramp and return it as accepted."""
        return SetPoint(*self._called("ramp_to", target, rate))

    def hold(self) -> float:
        """Stop the ramp and hold the present temperature, which is returned."""
        return float(self._called("hold"))

    def safe(self) -> None:
        """Switch the oven off; OvenError if that cannot be verified."""
        self._resting = True
        if not self._lost.is_set():
            try:
                self._called("safe")
            except RigStopped:
                if not self._lost.is_set():
                    raise
            else:
                return
        self._rest_from_here()

    def close(self) -> None:
        """Let the watchdog go: it ends when the oven is at rest. One that does not answer is killed."""
        if self._left:
            return
        self._left = True
        if not self._lost.is_set():
            try:
                self._asked("leave", within=LEAVE_WITHIN)
            except (RigStopped, OvenError):
                self._end_process()
        with self._second_path:
            if self._own is not None:
                self._own.close()
                self._own = None
        self._let_go()

    def _let_go(self) -> None:
        if self._signals >= 0:
            if threading.current_thread() is threading.main_thread():
                signal.set_wakeup_fd(self._wakeup_before)
            os.close(self._signals)
            self._signals = -1
        self._lines.close()

    def _called(self, verb: str, *values: float) -> Any:
        if not self._resting:
            self.check()
        return self._asked(verb, *values)

    def _asked(self, verb: str, *values: float, within: float = ANSWER_WITHIN) -> Any:
        number, answers = next(self._numbers), queue.SimpleQueue[dict[str, Any]]()
        self._waiting[number] = answers
        deadline = time.monotonic() + within
        try:
            sent = self._lines.send(do=verb, number=number, **{"with": values})
            if not sent:
                self._lost.wait(SAYS_WHY)  # the pipe is closed: what became of the process is known in a moment
            while sent and not self._lost.is_set() and time.monotonic() < deadline:
                try:
                    answer = answers.get(timeout=0.5)
                except queue.Empty:
                    if not self._resting and verb != "leave":
                        self.check()  # a request to end, or the supervision's own end, is not kept waiting
                    continue
                if "error" in answer:
                    raise unpacked(answer["error"])
                return answer["value"]
        finally:
            del self._waiting[number]
        raise self._wrong or RigStopped("the watchdog's process does not answer", RESUME)

    def _hear(self) -> None:
        """Read what the watchdog says until it is gone."""
        while (line := received(self._answers)) is not None:
            self._heard = time.monotonic()
            if "to" in line:
                waiting = self._waiting.get(line["to"])
                if waiting is not None:
                    waiting.put(line)
            elif "state" in line:
                if line["wrong"] is not None and self._wrong is None:
                    error = unpacked(line["wrong"])
                    self._wrong = error if isinstance(error, RigStopped) else RigStopped(str(error), RESUME)
            else:
                self._ready.put(line)
        self._ready.put({})
        self._lose("the watchdog's process has died")
        self._answers.close()
        self._process.wait()

    def _beat(self) -> None:
        """Tell the watchdog that this process is alive, and see that it is."""
        while not self._left and not self._lost.wait(BEAT):
            self._lines.send(age=time.monotonic() - self._user)
            if time.monotonic() - self._heard > SILENT:
                self._end_process()
                self._lose(f"the watchdog's process has said nothing for {SILENT:g} s and was ended")

    def _lose(self, why: str) -> None:
        """End the campaign, whose watchdog is gone, and bring the oven to rest at once, in this thread."""
        if self._left or self._lost.is_set():
            return
        self._wrong = self._wrong or RigStopped(why, f"The oven was brought to rest by the campaign. {RESUME}")
        self._lost.set()
        for attempt in range(3):
            try:
                self._rest_from_here()
            except Exception as error:  # noqa: BLE001 (tried again, and once more as the session ends)
                log.warning("%s; the oven could not be brought to rest (attempt %d): %s", why, attempt + 1, error)
                time.sleep(1.0)
            else:
                return

    def _rest_from_here(self) -> None:
        """Switch the oven off by the second path."""
        self._end_process()  # a process that is only stopped keeps the port
        with self._second_path:
            if self._left and self._own is None:
                raise OvenError(Fault.PORT, "it was closed already", "Open it again.")
            if self._own is None:
                self._own = self._open_oven()
            self._own.safe()

    def _end_process(self) -> None:
        self._process.kill()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            log.warning("the watchdog's process %d cannot be ended", self._process.pid)
