"""Signals that ask a program to end, held back while a voltage is out and let through where it is safe."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

NAMED = (
    *("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK", "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGALRM", "SIGVTALRM"),
    *("SIGPROF", "SIGXCPU", "SIGIO", "SIGPWR", "SIGSTKFLT"),
)
ENDING: tuple[int, ...] = tuple(int(getattr(signal, name)) for name in NAMED if hasattr(signal, name)) + (
    tuple(range(signal.SIGRTMIN, signal.SIGRTMAX + 1)) if hasattr(signal, "SIGRTMIN") else ()
)
"""Ctrl-C, a request to end, a lost terminal, Ctrl-Break (Windows), SIGQUIT, a limit of processor time, and every
other signal that ends a program unless it is handled; not those of a crash: then nothing can be relied on."""


def signal_name(number: int) -> str:
    """Return a signal's name; the real-time signals have none but their numbers."""
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


@contextmanager
def held_back() -> Iterator[Callable[[], None]]:
    """Hold every signal of `ENDING` back, so that what brings an output to 0 V always runs to its end.

    An exception in the middle of that work, as Ctrl-C ordinarily raises it, would leave the voltage
    standing; there is no moment in a ``finally`` at which it could not come.

    Yields
    ------
    callable
        Lets through what has come meanwhile: the handler that was there before is called and raises
        what it raises. A signal nobody handles ends the program by `SystemExit`, so that clean-up
        still happens. To be called where stopping is safe; called once more at the end. Outside the
        main thread, which no signal ever interrupts, it does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    held_signals: list[int] = []
    previous: dict[int, Any] = {}

    def remember(number: int, _: FrameType | None) -> None:
        held_signals.append(number)

    def let_through() -> None:
        while held_signals:
            number = held_signals.pop(0)
            handler = previous[number]
            if callable(handler):
                handler(number, None)
            elif handler is signal.SIG_DFL:
                raise SystemExit(128 + number)

    try:
        for wanted in ENDING:
            if signal.getsignal(wanted) is not None:  # None: set outside Python, and not to be given back
                previous[wanted] = signal.signal(wanted, remember)
        yield let_through
    finally:
        for held, handler in previous.items():
            signal.signal(held, handler)
        let_through()
