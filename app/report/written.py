"""The report written: its page, stage by stage as far as the run has come, and every figure as PNG if wanted.

Parts are drawn in worker processes.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analysis.progress import Progress
from app.files.atomic import write_bytes, write_text
from app.files.bad_file import ResultFileError
from app.files.campaigns.of_run import campaign_of, made_by
from app.files.results.best_twin import PLAIN, best_twin, load_gap_record
from app.files.results.modes_file import load_frf
from app.files.results.panel_files import other_filters
from app.files.results.run_folder import is_test_run, run_file
from app.report import paper, studies
from app.report.gap_section import gap_section
from app.report.modal_test import sections_of_test
from app.report.page import Absent, DrawnPicture, Item, PageTable, Picture, Section, VerdictBox, Words, page
from app.report.panel_sections import compensation_section, focusing_section, radiation_section
from app.report.plate_sections import identification_section, measurement_section, updating_section
from app.report.style import drawing
from app.report.summary import Stamps, extent_of, origin, outdated, stamps, summary, worth_of
from app.summaries.briefing import briefing
from app.summaries.numbers import span, sweeps

PANEL_RESULTS = ("filters.h5", "compensation.h5", "radiation.h5", "studies.h5")
"""Results that are made from laws."""
PARTS = {
    "frf.h5": "Measurement",
    "modes.h5": "Identification",
    "laws.h5": "Updated twin and material laws",
    "gap.h5": "What the twin lacks",
    "filters.h5": "Focusing",
    "compensation.h5": "Compensation",
    "radiation.h5": "Sound",
    "studies.h5": "The paper's studies",
}
"""Titles of the sections, by the file that each shows."""
Part = tuple[list[Item], list[paper.PaperRow]]
OPTIONAL = ("gap.h5", "radiation.h5", "studies.h5")
"""Stages that a run is complete without."""


@dataclass(frozen=True)
class Found:
    """The page's title, the line under it, its sections, and what was found amiss among the results.

    The first `lead` sections stand before the table of contents.
    """

    title: str
    subtitle: str
    sections: Sequence[Section]
    amiss: Sequence[str]
    lead: int = 0


def part_of(run: Path, name: str) -> Part:
    """Return what a page says of one result.

    Parameters
    ----------
    name : str
        Of a file of the run, a key of `PARTS`.

    Returns
    -------
    items : list of Item
    rows : list of PaperRow
        For the table beside the paper.

    Raises
    ------
    ResultFileError
        Where that file, or another one beside it, cannot be read.
    """
    rows: list[paper.PaperRow] = []
    if name == "gap.h5":
        frfs = run / "frf.h5"
        return gap_section(run / name, load_frf(frfs)[0] if frfs.is_file() else None), rows
    if name == "filters.h5":
        return focusing_section(run, rows), rows
    if name == "compensation.h5":
        return compensation_section(run, rows), rows
    if name == "radiation.h5":
        return radiation_section(run), rows
    if name == "studies.h5":
        return studies.items(run / name, rows), rows
    experiment, frf = load_frf(run_file(run, "frf.h5", "report"))
    if name == "modes.h5":
        return identification_section(run, experiment, frf, rows), rows
    if name == "laws.h5":
        return updating_section(run, experiment, frf, rows), rows
    return measurement_section(experiment, frf), rows


def sections(run: Path, report: Progress, part: Callable[[Path, str], Part] = part_of) -> Found:
    """Read what a run holds.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    part : callable, optional
        In place of `part_of`, for parts that other processes have drawn.

    Raises
    ------
    ResultFileError
        Where it is no run folder at all, or a result in it cannot be read.
    """
    if is_test_run(run):
        title, subtitle, of_test = sections_of_test(run)
        return Found(title, subtitle, of_test, [], lead=1)
    experiment, frf = load_frf(run_file(run, "frf.h5", "report"))
    rows: list[paper.PaperRow] = []
    lines = [(verb, line) for verb, line in summary(run).items() if verb != "import"]
    made = [Section("In short", [*_words(run), PageTable(("stage", "found"), lines)])] if lines else []
    lead = len(made)
    for done, (name, title) in enumerate(PARTS.items()):
        report("report", done / len(PARTS))
        if (run / name).is_file():
            items, figures = part(run, name)
            rows.extend(figures)
            made.append(Section(title, items))
        elif name not in OPTIONAL:
            made.append(Section(title, [Absent(f"not run yet; make it with: flexura {made_by(run, name)}")]))
    if paper.is_the_papers(experiment.plate):
        made.append(Section("Beside the paper", [paper.beside_paper(rows)]))
    found = stamps(run, list(PARTS))
    made.append(Section("Provenance", origin(found)))
    old = [*outdated(run, found), *_overtaken(run, found), *other_filters(run)]
    if old:
        lead += 1
        made.insert(
            0,
            Section(
                "Before you read on",
                [VerdictBox("Results that are out of date, or do not belong together", old, False)],
            ),
        )
    report("report", 1.0)
    temperature = frf.temperature
    extent = extent_of(found)
    subtitle = f"{sweeps(len(temperature))}, {span(temperature, 'z.1f')} °C"
    if len(temperature) == 1:
        subtitle = f"1 sweep at {temperature[0]:z.1f} °C"
    if extent is not None:
        subtitle = extent.said
    return Found(experiment.title, subtitle, made, old, lead)


def _words(run: Path) -> list[Item]:
    """Return what was found in words; nothing before the twin was updated."""
    if not (run / PLAIN).is_file():
        return []
    best = best_twin(run, "report")
    record = load_gap_record(run / "gap.h5") if (run / "gap.h5").is_file() else None
    said = briefing(best, record, campaign_of(run), worth_of(run))
    return [Words(said.headline, said.settled, said.first, said.parts)]


def _overtaken(run: Path, found: Stamps) -> list[str]:
    """Say which results were made with the uncorrected laws, although a comparison has corrected them."""
    if not (run / PLAIN).is_file() or best_twin(run, "report").uncorrected is None:
        return []
    return [
        f"{name} was made with the uncorrected laws of {PLAIN}; make it again: flexura {made_by(run, name)}"
        for name in PANEL_RESULTS
        if PLAIN in found.get(name, {}).get("inputs", {})
    ]


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
