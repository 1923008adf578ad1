"""Ctrl-C, SIGTERM and a lost terminal end a verb in one way: what it holds is closed; the status tells which."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from drivers.interruptions import ENDING

SIGNALLED = 128
"""Exit status of a process that a signal ended, less the signal's number."""


class EndSignals:
    """The signals of a verb; each raises KeyboardInterrupt in the main thread.

    Attributes
    ----------
    number : int
        Of the first that arrived; SIGINT's before.
    over : bool
        Whether the verb has ended: what arrives then interrupts nothing any more.
    """

    def __init__(self) -> None:
        self.number = int(signal.SIGINT)
        self.over = False
        self._arrived = False

    @property
    def status(self) -> int:
        """Exit status: 130 for Ctrl-C, 143 for SIGTERM."""
        return SIGNALLED + self.number

    def raise_interrupt(self, number: int, _: FrameType | None) -> None:
        """Note the first signal, and raise."""
        if not self._arrived:
            self._arrived, self.number = True, number
        if not self.over:
            raise KeyboardInterrupt


@contextmanager
def end_signals() -> Iterator[EndSignals]:
    """Let every signal that asks for an end raise KeyboardInterrupt meanwhile, as Ctrl-C does.

    Without it SIGTERM ends the process where it stands: unfinished files stay. One that was ignored when the
    program began, as ``nohup`` does, stays ignored. Outside the main thread nothing changes.
    """
    ends = EndSignals()
    usual = (signal.SIG_DFL, signal.default_int_handler)
    previous: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        previous = {number: signal.getsignal(number) for number in ENDING if signal.getsignal(number) in usual}
    for number in previous:
        signal.signal(number, ends.raise_interrupt)
    try:
        yield ends
    finally:
        ends.over = True  # a second Ctrl-C while handlers are put back was a traceback
        for number, handler in previous.items():
            signal.signal(number, handler)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Ignore these signals while an end is under way: of one Ctrl-C, worker processes pass on theirs, too."""
    ours = threading.current_thread() is threading.main_thread()
    previous = {number: signal.signal(number, signal.SIG_IGN) for number in ENDING} if ours else {}
    try:
        yield
    finally:
        for number, handler in previous.items():
            if handler is not None:
                signal.signal(number, handler)


@contextmanager
def held_back() -> Iterator[None]:
    """Let these signals wait until the block ends: the files of one result are written all, or none of them."""
    arrived: list[tuple[int, FrameType | None]] = []
    previous: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():
        previous = {number: signal.getsignal(number) for number in ENDING if callable(signal.getsignal(number))}
    for number in previous:
        signal.signal(number, lambda *told: arrived.append(told))
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        if arrived:
            previous[arrived[0][0]](*arrived[0])


def end_at_once() -> None:
    """Leave the signals to the system from now on: for a window, whose event loop lets no handler of ours run."""
    for number in ENDING:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, signal.SIG_DFL)
