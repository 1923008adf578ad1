"""Parts of the page drawn side by side in worker processes: figures take most of the time of a report."""

from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from pathlib import Path

from app.files.bad_file import ResultFileError
from app.report.page import Picture
from app.report.sections import Part, part_of
from app.report.style import drawing


def drawn_part(run: Path, name: str, *, png: bool = False) -> Part:
    """Return what `part_of` does, with its figures drawn.

    Parameters
    ----------
    name : str
        Of a file of the run.
    png : bool
        Whether figures are wanted as PNG files, too.

    Returns
    -------
    items : list of Item
    rows : list of PaperRow
        For the table beside the paper.

    Raises
    ------
    ResultFileError
        As `part_of`.
    """
    with drawing():
        items, rows = part_of(run, name)
        return [one.drawn(png=png) if isinstance(one, Picture) else one for one in items], rows


def _in_a_worker(run: Path, name: str, png: bool) -> Part | None:
    """Do that in a worker; None for what cannot be read, which the process that writes the page reports."""
    try:
        return drawn_part(run, name, png=png)
    except (ResultFileError, OSError):
        return None


def _ready() -> None:
    """Do nothing: a worker that is asked for this has imported this module."""


class DrawnParts:
    """Parts of one page, some of them drawn ahead by workers.

    Parameters
    ----------
    executor : Executor or None
        Of worker processes; None draws everything here, when it is asked for.
    png : bool
        Whether figures are wanted as PNG files, too.
    """

    def __init__(self, executor: Executor | None, *, png: bool = False) -> None:
        self._executor = executor
        self._png = png
        self._begun: dict[tuple[Path, str], Future[Part | None]] = {}
        self._done: dict[tuple[Path, str], Part] = {}

    def make_ready(self) -> None:
        """Let a worker import what it will draw with, while there is nothing to draw yet."""
        if self._executor is not None:
            with suppress(BrokenProcessPool):
                self._executor.submit(_ready)

    def begin(self, run: Path, name: str) -> None:
        """Let a worker draw what a run's file holds now; nothing where it is begun, or is not there."""
        if self._executor is None or (run, name) in self._begun or not (run / name).is_file():
            return
        try:
            self._begun[run, name] = self._executor.submit(_in_a_worker, run, name, self._png)
        except BrokenProcessPool:  # a worker was killed: all is drawn here
            self._executor = None

    def help(self) -> None:
        """Draw here what no worker has begun, the last first, until the workers are at all the rest."""
        for (run, name), begun in reversed(self._begun.items()):
            if begun.cancel():
                self._done[run, name] = drawn_part(run, name, png=self._png)

    def part(self, run: Path, name: str) -> Part:
        """Return a part, waiting for the worker that draws it; ResultFileError where it cannot be read."""
        if (run, name) in self._done:
            return self._done[run, name]
        begun = self._begun.get((run, name))
        if begun is not None:
            try:
                found = begun.result()
            except BrokenProcessPool:
                found = None
            if found is not None:
                return found
        return drawn_part(run, name, png=self._png)
