"""Independent work on all processors, by copies of this process that share its memory.

A linearised sweep is thousands of small array operations, between which threads wait for Python's lock: two
threads took as long as one, for 1.6 times its processor time. Processes of their own would each need the twin, of
some hundred megabytes; a fork has it already.
"""

import gc
import multiprocessing
import os
import signal
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, Pipe
from typing import Any

MOST_PROCESSES = 8
"""A comparison of 16 sweeps has no more work at a time, and each takes some hundred megabytes of its own."""
LEFT_TO_THE_PARENT = (signal.SIGINT, signal.SIGTERM)
"""Signals whose handlers belong to the process that was started: they write its last lines, and end its copies."""


def processors() -> int:
    """Return how many processors this process may use: a job scheduler may grant fewer than there are."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # systems other than Linux
        return os.cpu_count() or 1


class ForkedExecutor(ThreadPoolExecutor):
    """Executor whose `map` works in copies of this process.

    What a function changes in a copy is lost: only what it returns comes back, in whole. So what is submitted
    singly runs in threads. In a worker process, whose siblings have the other processors, `map` uses none but its
    own; on systems where copies are not safe, threads.

    Parameters
    ----------
    processes : int, optional
        By default all processors of this process, `MOST_PROCESSES` at most.
    """

    def __init__(self, processes: int | None = None) -> None:
        super().__init__(2)
        alone = multiprocessing.parent_process() is None
        self.processes = processes or (min(processors(), MOST_PROCESSES) if alone else 1)

    def map(
        self,
        fn: Callable[..., Any],
        /,
        *iterables: Iterable[Any],
        timeout: float | None = None,
        chunksize: int = 1,
    ) -> Iterator[Any]:
        """Return what `fn` gives for items, in their order, as `Executor.map` does, when all of it is there.

        Raises
        ------
        Exception
            The first that `fn` raised.
        """
        if not sys.platform.startswith("linux"):
            return super().map(fn, *iterables, timeout=timeout, chunksize=chunksize)
        items = list(zip(*iterables, strict=False))
        count = min(self.processes, len(items))
        shares = [items[first::count] for first in range(count)]
        copies: list[_Copy] = []
        found: list[Any] = [None] * len(items)
        try:
            for share in shares[1:]:
                copies.append(_Copy.begun(self, fn, share, copies))
            for first, share in enumerate(shares):
                found[first::count] = copies[first - 1].results(fn, share) if first else _each(fn, share)
        finally:
            for copy in copies:
                copy.end()
        return iter(found)


@dataclass(frozen=True)
class _Copy:
    """A copy of this process at its share of the work."""

    pid: int
    answer: Connection

    @classmethod
    def begun(
        cls,
        executor: ForkedExecutor,
        fn: Callable[..., Any],
        share: Sequence[Sequence[Any]],
        earlier: Sequence["_Copy"],
    ) -> "_Copy":
        answer, own = Pipe(duplex=False)
        with own, warnings.catch_warnings():
            # Python 3.12 warns where threads run: theirs show progress, and hold nothing that a copy needs
            warnings.simplefilter("ignore", DeprecationWarning)
            pid = os.fork()
            if pid == 0:
                status = 1
                try:
                    for held in (*(copy.answer for copy in earlier), answer):
                        held.close()  # so that writing ends where the parent was killed
                    executor.processes = 1
                    _answer(own, fn, share)
                    status = 0
                finally:
                    os._exit(status)
        return cls(pid, answer)

    def results(self, fn: Callable[..., Any], share: Sequence[Sequence[Any]]) -> list[Any]:
        """Wait for the results; those of a copy that was killed, for lack of memory, are made here."""
        found: list[Any] = []
        while len(found) < len(share):
            try:
                result, error = self.answer.recv()
            except EOFError:
                return found + _each(fn, share[len(found) :])
            if error is not None:
                raise error
            found.append(result)
        return found

    def end(self) -> None:
        """End the copy, whatever it is at."""
        self.answer.close()
        with suppress(ProcessLookupError):
            os.kill(self.pid, signal.SIGKILL)
        with suppress(ChildProcessError):
            os.waitpid(self.pid, 0)


def _each(fn: Callable[..., Any], share: Sequence[Sequence[Any]]) -> list[Any]:
    return [fn(*item) for item in share]


def _answer(own: Connection, fn: Callable[..., Any], share: Sequence[Sequence[Any]]) -> None:
    """Send the results one by one, or the error, as (result, error): all at once they would be held twice."""
    for number in LEFT_TO_THE_PARENT:
        signal.signal(number, signal.SIG_DFL)
    gc.disable()  # a collection would write to, and so copy, all memory that is shared
    try:
        results = _each(fn, share)
    except Exception as error:  # noqa: BLE001 - raised again where it is waited for
        own.send((None, error))
        return
    for one in results:
        own.send((one, None))
