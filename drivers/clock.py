"""The clock a driver is handed: the machine's own, or a virtual one that jumps when somebody waits."""

import threading
import time
from typing import Protocol


class Clock(Protocol):
    """Seconds that only grow, and a way to wait for more of them."""

    def now(self) -> float:
        """Seconds since an arbitrary start."""
        ...

    def sleep(self, seconds: float) -> None:
        """Return once `seconds` have passed; at once where they are zero or negative."""
        ...


class SystemClock:
    """The machine's monotonic clock: a corrected time of day never moves a deadline."""

    def now(self) -> float:
        """Seconds of the monotonic clock."""
        return time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Block the calling thread."""
        if seconds > 0.0:
            time.sleep(seconds)


class VirtualClock:
    """Time that passes only when somebody sleeps: hours of oven in milliseconds of computer.

    Parameters
    ----------
    start : float
        First reading, s.
    """

    def __init__(self, start: float = 0.0) -> None:
        self._now = start
        self._lock = threading.Lock()

    def now(self) -> float:
        """Virtual seconds."""
        with self._lock:
            return self._now

    def sleep(self, seconds: float) -> None:
        """Move the clock on by `seconds` and return at once."""
        if seconds > 0.0:
            with self._lock:
                self._now += seconds
