"""Where independent tasks are done: in worker processes of this machine, or on a cluster."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from analysis.progress import Progress
from app.files.disk_room import memory_left
from app.terminal.worker_processes import worker_processes

USUAL_PROCESSES = 2
"""Processes, unless said otherwise: of two processors one waits for the other's memory little."""


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
