"""Requests to end the program: recorded at once, acted on where stopping is safe, with the rig brought to rest.

Why a campaign stopped before its end.
"""

import os
import signal
import sys
import threading
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, Self

from drivers.interruptions import ENDING, signal_name

if sys.platform == "win32":
    import ctypes
    from ctypes import wintypes

CONSOLE_ENDS = {2: "CTRL_CLOSE_EVENT", 5: "CTRL_LOGOFF_EVENT", 6: "CTRL_SHUTDOWN_EVENT"}
"""Console events that Windows sends before it ends the program, seconds later."""
NOT_STOPPED = (
    b"\nCtrl-Z: not stopped, the oven would be left without its campaign. "
    b"Ctrl-C ends the campaign with the rig at rest; flexura view can pause it.\n"
)


def _refuse_to_stop(number: int, frame: FrameType | None) -> None:
    """Say that Ctrl-Z has no effect."""
    with suppress(OSError):
        os.write(2, NOT_STOPPED)


STOPS: dict[str, Any] = {"SIGTSTP": _refuse_to_stop, "SIGTTIN": signal.SIG_IGN, "SIGTTOU": signal.SIG_IGN}
"""Signals that stop a program: Ctrl-Z, and the terminal's of a program in the background that reads or writes."""
GRACE = 30.0
"""Delay of the answer to Windows so that the rig can come to rest, s; Windows may not wait for it."""


class EndRequests:
    """Context manager that records Ctrl-C, SIGTERM and every other signal that would end the program.

    Also a lost terminal, Ctrl-Break and a closed Windows console. Ctrl-Z is not obeyed: a program that is stopped
    supervises nothing, and would have its oven switched off.

    Nothing is raised when a request arrives, because an exception at an arbitrary moment may hit a destructor, a
    library's callback, or the code that brings the rig to rest. It is raised by `check`, which is called wherever
    stopping is safe. A signal that was ignored when the program began, as ``nohup`` does, stays ignored.

    Attributes
    ----------
    arrived : str or None
        Name of the first request.
    number : int
        Number of its signal; 0 for a closed console, or if none has arrived.
    """

    def __init__(self) -> None:
        self.arrived: str | None = None
        self.number = 0
        self._before: dict[int, Any] = {}
        self._over = threading.Event()
        self._console: Any = None

    def __enter__(self) -> Self:
        """Install the signal handlers."""
        for number in ENDING:
            if signal.getsignal(number) not in (signal.SIG_IGN, None):  # None: installed outside Python
                self._before[number] = signal.signal(number, self._note)
        for name, handler in STOPS.items():
            stop = getattr(signal, name, None)
            if stop is not None and signal.getsignal(stop) not in (signal.SIG_IGN, None):
                self._before[stop] = signal.signal(stop, handler)
        if sys.platform == "win32":
            self._console = ctypes.WINFUNCTYPE(wintypes.BOOL, wintypes.DWORD)(self._console_ends)
            ctypes.windll.kernel32.SetConsoleCtrlHandler(self._console, True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Restore the previous handlers."""
        self._over.set()
        if sys.platform == "win32":
            ctypes.windll.kernel32.SetConsoleCtrlHandler(self._console, False)
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def check(self) -> None:
        """Raise RigInterrupted if a request has arrived."""
        if self.arrived is not None:
            raise RigInterrupted(self.arrived)

    def _note(self, number: int, _: FrameType | None) -> None:
        if self.arrived is None:
            self.number = number
            self.arrived = signal_name(number)

    def _console_ends(self, event: int) -> bool:
        """Record that Windows ends the program; called in a thread of its own, for which Windows waits."""
        if event not in CONSOLE_ENDS:
            return False  # Ctrl-C and Ctrl-Break arrive as signals
        self.arrived = self.arrived or CONSOLE_ENDS[event]
        self._over.wait(GRACE)
        return True


RESUME = "Then run the same command again: what is finished stays"


class RigStopped(Exception):  # noqa: N818 (not an error of the program)
    """The campaign cannot continue now; the same command resumes it.

    Attributes
    ----------
    what : str
        What happened, with the values seen.
    next_step : str
        What the user can do about it.
    """

    def __init__(self, what: str, next_step: str) -> None:
        self.what = what
        self.next_step = next_step
        super().__init__(what, next_step)

    def __str__(self) -> str:
        return f"{self.what.rstrip('.')}. {self.next_step.rstrip('.')}."


class RigInterrupted(KeyboardInterrupt):
    """The user ended the program; the same command resumes the campaign."""
