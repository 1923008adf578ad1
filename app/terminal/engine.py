"""Where independent tasks are done: in worker processes of this machine, or on a cluster.

Worker processes end with the process that gives them work.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path
from types import FrameType

from analysis.forked import processors
from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.disk_room import memory_left
from app.terminal.end_signals import undisturbed
from drivers.interruptions import ENDING

USUAL_PROCESSES = 2
"""Processes, unless said otherwise: of two processors one waits for the other's memory little."""


MOST_WORKERS = 3
"""Workers of a verb: a page has six parts, and each worker takes 0.2 GB and a second to start."""


@contextmanager
def worker_processes(count: int) -> Iterator[Executor]:
    """Yield workers as `worker_pool` does, and wait for all their tasks at the end.

    Raises
    ------
    ResultFileError
        Where a worker was killed, or had too little memory.
    """
    with worker_pool(count, at_once=True) as pool:
        try:
            yield pool
            pool.shutdown()
        except BrokenProcessPool as error:
            raise ResultFileError(
                "a worker process was killed, or had too little memory; what is finished stays: run it again to "
                "go on, with fewer --workers"
            ) from error


@contextmanager
def worker_pool(count: int, *, at_once: bool = False) -> Iterator[Executor]:
    """Yield new worker processes; when the block ends, they end at once, whatever they are at.

    A task takes up to minutes, and an abandoned pool would work through all its tasks. What was finished stays,
    and the rest is made anew when it is asked for again. A signal to a worker ends all as one to this process.

    Parameters
    ----------
    at_once : bool
        Start them now, not with their first tasks: a process that is being started ignores what it cannot pass on
        yet.

    Yields
    ------
    Executor
        Its futures raise BrokenProcessPool where a worker was killed, or had too little memory.
    """
    heard = tuple(number for number in ENDING if signal.getsignal(number) is not signal.SIG_IGN)
    context = multiprocessing.get_context("spawn")
    held, holder = context.Pipe(duplex=False)
    with undisturbed():  # inherited by what is started here
        if os.name != "nt":
            from multiprocessing import resource_tracker  # Python's own helper process; absent on Windows

            resource_tracker.ensure_running()
        pool = ProcessPoolExecutor(
            count, mp_context=context, initializer=_follow_the_parent, initargs=(held, heard)
        )
        for _ in range(count if at_once else 0):
            pool.submit(os.getpid)
    try:
        yield pool
    finally:
        with undisturbed():
            holder.close()
            pool.shutdown(cancel_futures=True)
            held.close()


@contextmanager
def spare_workers(least: int = 1) -> Iterator[Executor | None]:
    """Yield workers for the processors that this process leaves idle; None where there is only one.

    Up to `least` even if they are more: a process that waits for `least` workers leaves its own processor idle.
    """
    there = processors()
    count = min(max(there - 1, min(least, there)), MOST_WORKERS)
    if there == 1:
        yield None
        return
    with worker_pool(count) as pool:
        yield pool


def _follow_the_parent(held: Connection, heard: tuple[int, ...]) -> None:
    """End this process when its parent lets go of a pipe, or is killed; pass on to it the signals it heeds."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        wait([held, parent.sentinel])
        os._exit(1)

    def pass_on(number: int, _: FrameType | None) -> None:
        if os.name != "nt":  # Windows sends Ctrl-C to the parent, too
            with suppress(ProcessLookupError):
                os.kill(parent.pid or 0, number)

    threading.Thread(target=watch, daemon=True).start()
    for number in heard:
        signal.signal(number, pass_on)


@dataclass(frozen=True)
class Engine:
    """What --workers and --cluster ask for.

    Attributes
    ----------
    workers : int or None
        Processes on this machine, where there is no cluster; None for `USUAL_PROCESSES`.
    cluster : str or None
        Address of its scheduler, or the file with it.
    """

    workers: int | None = None
    cluster: str | None = None

    @property
    def named(self) -> bool:
        """Whether either was typed."""
        return self.workers is not None or self.cluster is not None

    @contextmanager
    def executor(
        self, folder: Path, memory: float, report: Progress, note: Callable[[str], None]
    ) -> Iterator[Executor]:
        """Yield the executor that takes tasks.

        Parameters
        ----------
        folder : Path
            Of the results.
        memory : float
            Bytes that a task takes at most: fewer processes are begun where more do not fit.
        note : callable
            Called with a line that says so.

        Raises
        ------
        ResultFileError
            Where a worker was killed, or the cluster cannot be used.
        """
        if self.cluster is not None:
            from app.terminal.cluster import cluster_workers

            with cluster_workers(self.cluster, folder, memory, report) as executor:
                yield executor
            return
        free = memory_left()
        asked = self.workers or USUAL_PROCESSES
        count = min(asked, max(int(free / memory), 1)) if free < float("inf") else asked
        if count < asked:
            note(
                f"{count} of {asked} workers: each takes up to {memory / 1e9:.2g} GB, and {free / 1e9:.2g} GB "
                "of memory are free"
            )
        with worker_processes(count) as executor:
            yield executor
