"""The report written, its parts drawn in worker processes: the page, and every figure as PNG if wanted."""

from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analysis.progress import Progress
from app.files.atomic import write_bytes, write_text
from app.files.bad_file import ResultFileError
from app.report.page import Absent, DrawnPicture, Picture, page
from app.report.sections import PARTS, Part, part_of, sections
from app.report.style import drawing


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


REPORT = "report.html"


@dataclass(frozen=True)
class WrittenReport:
    """A report on the disk.

    Attributes
    ----------
    target : Path
    size : int
        Bytes.
    titles, missing : tuple of str
        Sections, and those whose stage was not run.
    amiss : tuple of str
        What is out of date, or does not belong together, a sentence each.
    figures : tuple of str
        Names.
    """

    target: Path
    size: int
    titles: tuple[str, ...]
    missing: tuple[str, ...]
    amiss: tuple[str, ...]
    figures: tuple[str, ...]

    def __repr__(self) -> str:
        """Figures, size, what was not run, and where it is, in one line."""
        return f"<WrittenReport: {self.line()}>"

    def record(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        return {
            "report": str(self.target),
            "bytes": self.size,
            "sections": list(self.titles),
            "not_run_yet": list(self.missing),
            "amiss": list(self.amiss),
            "figures": list(self.figures),
        }

    def line(self) -> str:
        """Say it in one line."""
        absent = f", not run yet: {', '.join(self.missing)}" if self.missing else ""
        return f"report of {len(self.figures)} figures, {self.size / 1e6:.1f} MB{absent}: {self.target}"


def write_report(
    run: Path,
    folder: Path,
    report: Progress,
    *,
    pictures: bool = False,
    executor: Executor | None = None,
    parts: DrawnParts | None = None,
) -> WrittenReport:
    """Write ``report.html`` of a run.

    Parameters
    ----------
    folder : Path
        For the report.
    report : callable
        Called with a stage's name and the share of it done.
    pictures : bool
        Write every figure as a PNG file, too.
    executor : Executor, optional
        Worker processes that draw figures.
    parts : DrawnParts, optional
        Parts that are drawn already, or being drawn; made with the same `pictures`.

    Raises
    ------
    ResultFileError
        For a folder that is no run, or a result that cannot be read.
    OSError
        Where something cannot be written.
    """
    parts = parts or DrawnParts(executor, png=pictures)
    for name in PARTS:
        parts.begin(run, name)
    report("report", 0.0)
    parts.help()
    with drawing():
        found = sections(run, report, parts.part)
        html = page(f"Flexura: {found.title}", found.subtitle, found.sections, found.lead)
        figures = [one for part in found.sections for one in part.items if isinstance(one, Picture | DrawnPicture)]
        if pictures:
            for one in figures:
                drawn = one if isinstance(one, DrawnPicture) else one.drawn(png=True)
                write_bytes(folder / f"{one.name}.png", drawn.png)
    target = folder / REPORT
    write_text(target, html)
    missing = tuple(part.title for part in found.sections if any(isinstance(one, Absent) for one in part.items))
    return WrittenReport(
        target.resolve(),
        len(html.encode()),
        tuple(part.title for part in found.sections),
        missing,
        tuple(found.amiss),
        tuple(one.name for one in figures),
    )


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
