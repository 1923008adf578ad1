"""The report written: the page, and every figure as a PNG file if that is wanted."""

from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analysis.progress import Progress
from app.files.atomic import write_bytes, write_text
from app.report.drawn_parts import DrawnParts
from app.report.page import Absent, DrawnPicture, Picture, page
from app.report.sections import PARTS, sections
from app.report.style import drawing

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
