"""The clock that a driver gets as an argument: the computer's, or a virtual one that advances during a wait."""

import math
import threading
import time
from collections.abc import Callable
from typing import Protocol

Stop = Callable[[], None]


class Clock(Protocol):
    """Seconds that only grow, and a way to wait for more of them."""

    def now(self) -> float:
        """Seconds since an arbitrary start."""
        ...

    def sleep(self, seconds: float) -> None:
        """Return once `seconds` have passed; at once where they are zero or negative."""
        ...

    def every(self, seconds: float, action: Callable[[], None]) -> Stop:
        """Call `action`, which must not raise, every so many seconds, whatever the caller does meanwhile.

        Returns
        -------
        callable
            Ends it.
        """
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

    def every(self, seconds: float, action: Callable[[], None]) -> Stop:
        """Call `action` in a thread of its own."""
        over = threading.Event()

        def repeat() -> None:
            while not over.wait(seconds):
                action()

        threading.Thread(target=repeat, name="supervision", daemon=True).start()
        return over.set


class VirtualClock:
    """Time that advances only during `sleep`: hours of an oven in milliseconds of the computer.

    Periodic actions are called within the `sleep` that passes their time, at whole multiples of the period.

    Parameters
    ----------
    start : float
        First reading, s.
    """

    def __init__(self, start: float = 0.0) -> None:
        self._now = start
        self._lock = threading.Lock()
        self._repeated: dict[object, tuple[float, float, Callable[[], None]]] = {}
        self._calling = False

    def now(self) -> float:
        """Virtual seconds."""
        with self._lock:
            return self._now

    def sleep(self, seconds: float) -> None:
        """Move the clock on by `seconds` and return at once."""
        if seconds <= 0.0:
            return
        if not self._repeated or self._calling:  # time that passes in what is repeated begins nothing anew
            with self._lock:
                self._now += seconds
            return
        end = self.now() + seconds
        while (due := self._next(end)) is not None:
            self._call(due)
        with self._lock:
            self._now = max(self._now, end)

    def every(self, seconds: float, action: Callable[[], None]) -> Stop:
        """Call `action` within the `sleep` that passes the time at which it is due."""
        key = object()
        self._repeated[key] = (self._after(seconds), seconds, action)
        return lambda: self._repeated.pop(key, None) and None

    def _after(self, seconds: float) -> float:
        """Return the next whole multiple."""
        return (math.floor(self.now() / seconds + 1e-6) + 1) * seconds

    def _next(self, end: float) -> object | None:
        """Return what is due first, if it is due by `end`."""
        first = min(self._repeated, key=lambda key: self._repeated[key][0], default=None)
        return first if first is not None and self._repeated[first][0] <= end else None

    def _call(self, key: object) -> None:
        moment, seconds, action = self._repeated[key]
        with self._lock:
            self._now = max(self._now, moment)
        self._calling = True
        try:
            action()
        finally:
            self._calling = False
            if key in self._repeated:
                self._repeated[key] = (self._after(seconds), seconds, action)
