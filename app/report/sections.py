"""The report's page put together, stage by stage, as far as the run has come."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.progress import Progress
from app.files.campaigns.of_run import campaign_of, made_by
from app.files.results.best_twin import PLAIN, best_twin, load_gap_record
from app.files.results.modes_file import load_frf
from app.files.results.panel_files import load_panel
from app.files.results.run_folder import is_test_run, run_file
from app.report import paper, studies
from app.report.gap_section import gap_section
from app.report.modal_test import sections_of_test
from app.report.page import Absent, Item, PageTable, Section, VerdictBox, Words
from app.report.panel_sections import compensation_section, focusing_section, radiation_section
from app.report.plate_sections import identification_section, measurement_section, updating_section
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
    old = [*outdated(run, found), *_overtaken(run, found), *_of_two_panels(run)]
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


def _of_two_panels(run: Path) -> list[str]:
    """Say that compensated filters are not those of filters.h5 beside them, but of another panel."""
    if not all((run / name).is_file() for name in ("filters.h5", "compensation.h5")):
        return []
    design, followed = load_panel(run / "filters.h5"), load_panel(run / "compensation.h5")
    if design == followed:
        return []
    which = "another panel than" if design.title != followed.title else "other settings of the panel than"
    return [
        f"compensation.h5 is of {which} filters.h5 beside it ({followed.title!r}, {design.title!r}); "
        f"make it again: flexura {made_by(run, 'compensation.h5')}"
    ]


def _overtaken(run: Path, found: Stamps) -> list[str]:
    """Say which results were made with the uncorrected laws, although a comparison has corrected them."""
    if not (run / PLAIN).is_file() or best_twin(run, "report").uncorrected is None:
        return []
    return [
        f"{name} was made with the uncorrected laws of {PLAIN}; make it again: flexura {made_by(run, name)}"
        for name in PANEL_RESULTS
        if PLAIN in found.get(name, {}).get("inputs", {})
    ]
