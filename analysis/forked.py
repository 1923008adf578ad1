"""Independent work on all processors, by copies of this process that share its memory.

A linearised sweep is thousands of small array operations, between which threads wait for Python's lock: two
threads took as long as one, for 1.6 times its processor time. Processes of their own would each need the twin, of
some hundred megabytes; a fork has it already.

A copy has one thread only: a lock that another thread holds is never released in it (threads that compute hold
that of `cached_property`, before Python 3.12). So only the main thread makes copies, and one that comes to no end
is given up.
"""

import gc
import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, Pipe
from typing import Any

MOST_PROCESSES = 8
"""A comparison of 16 sweeps has no more work at a time, and each takes some hundred megabytes of its own."""
PATIENCE, AT_LEAST = 10.0, 60.0
"""Times that this process took for its own share, and s at least, after which a copy is given up."""
LEFT_TO_THE_PARENT = tuple(one for one in signal.Signals if one.name in ("SIGINT", "SIGTERM", "SIGHUP"))
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
    singly runs in threads. In a worker process, whose siblings have the other processors, and outside the main
    thread `map` uses one processor; on systems other than Linux, threads.

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
        if count < 2 or threading.current_thread() is not threading.main_thread():
            return iter(_each(fn, items))
        shares = [items[first::count] for first in range(count)]
        copies: list[_Copy] = []
        found: list[Any] = [None] * len(items)
        try:
            for share in shares[1:]:
                copies.append(_Copy.begun(self, fn, share, copies))
            begun = time.monotonic()
            found[::count] = _each(fn, shares[0])
            until = time.monotonic() + max(AT_LEAST, PATIENCE * (time.monotonic() - begun))
            for first, (copy, share) in enumerate(zip(copies, shares[1:], strict=True), 1):
                results = copy.results(len(share), until)
                if len(results) < len(share):
                    self.processes = 1  # another copy would end like this one
                    results += _each(fn, share[len(results) :])
                found[first::count] = results
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

    def results(self, count: int, until: float) -> list[Any]:
        """Wait for results until a time, s; fewer where the copy was killed, for lack of memory, or hangs."""
        found: list[Any] = []
        while len(found) < count and self.answer.poll(max(until - time.monotonic(), 0.0)):
            try:
                result, error = self.answer.recv()
            except EOFError:
                break
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
