"""The report's page put together, stage by stage, as far as the run has come."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from analysis.progress import Progress
from app.files.best_twin import PLAIN, best_twin, load_gap_record
from app.files.filter_files import load_focusing, load_uncorrected
from app.files.frf_file import load_frf
from app.files.run_folder import MADE_BY, is_test_run, run_file
from app.report import paper, studies
from app.report.gap_section import gap_section
from app.report.modal_test import sections_of_test
from app.report.origin import Stamps, extent_of, origin, outdated, stamps
from app.report.page import Absent, Item, PageTable, Section, VerdictBox, Words
from app.report.panel_sections import compensation_section, focusing_section
from app.report.plate_sections import identification_section, measurement_section, updating_section
from app.report.summary import summary
from app.terminal.briefing import Worth, briefing

PANEL_RESULTS = ("filters.h5", "compensation.h5", "studies.h5")
"""Results that are made from laws."""
OPTIONAL = ("gap.h5", "studies.h5")
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


def sections(run: Path, report: Progress) -> Found:
    """Read what `run` holds; ResultFileError where it is no run folder at all."""
    if is_test_run(run):
        title, subtitle, of_test = sections_of_test(run)
        return Found(title, subtitle, of_test, [])
    experiment, frf = load_frf(run_file(run, "frf.h5", "report"))
    rows: list[paper.PaperRow] = []
    parts: list[tuple[str, str, Callable[[], list[Item]]]] = [
        ("Measurement", "frf.h5", lambda: measurement_section(experiment, frf)),
        ("Identification", "modes.h5", lambda: identification_section(run, experiment, frf, rows)),
        ("Updated twin and material laws", "laws.h5", lambda: updating_section(run, experiment, frf, rows)),
        ("What the twin lacks", "gap.h5", lambda: gap_section(run / "gap.h5")),
        ("Focusing", "filters.h5", lambda: focusing_section(run, rows)),
        ("Compensation", "compensation.h5", lambda: compensation_section(run, rows)),
        ("The paper's studies", "studies.h5", lambda: studies.items(run / "studies.h5", rows)),
    ]
    lines = [(verb, line) for verb, line in summary(run).items() if verb != "import"]
    made = [Section("In short", [*_words(run), PageTable(("stage", "found"), lines)])] if lines else []
    lead = len(made)
    for done, (title, name, build) in enumerate(parts):
        report("report", done / len(parts))
        if (run / name).is_file():
            made.append(Section(title, build()))
        elif name not in OPTIONAL:
            made.append(Section(title, [Absent(f"not run yet; make it with: flexura {MADE_BY[name]}")]))
    if paper.is_the_papers(experiment.plate):
        made.append(Section("Beside the paper", [paper.beside_paper(rows)]))
    found = stamps(run, [name for _, name, _ in parts])
    made.append(Section("Provenance", origin(found)))
    old = [*outdated(run, found), *_overtaken(run, found)]
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
    subtitle = f"{len(temperature)} sweeps, {temperature.min():z.1f} to {temperature.max():z.1f} °C"
    if extent is not None:
        subtitle = extent.said
    return Found(experiment.title, subtitle, made, old, lead)


def _words(run: Path) -> list[Item]:
    """Return what was found in words; nothing before the twin was updated."""
    if not (run / PLAIN).is_file():
        return []
    best = best_twin(run, "report")
    record = load_gap_record(run / "gap.h5") if (run / "gap.h5").is_file() else None
    said = briefing(best, record, worth=_worth(run))
    return [Words(said.headline, said.settled, said.first, said.parts)]


def _worth(run: Path) -> Worth | None:
    """Return what the corrected twin is worth for the filters of a run; None where that was not computed."""
    path = run / "filters.h5"
    lost = load_uncorrected(path) if path.is_file() else None
    if lost is None:
        return None
    _, focused, _ = load_focusing(path)
    gained = focused.direct.contrast.mean(axis=1) - lost.contrast.mean(axis=1)
    most = int(gained.argmax())
    return Worth(float(gained[most]), float(focused.temperature[most]))


def _overtaken(run: Path, found: Stamps) -> list[str]:
    """Say which results were made with the uncorrected laws, although a comparison has corrected them."""
    if not (run / PLAIN).is_file() or best_twin(run, "report").uncorrected is None:
        return []
    return [
        f"{name} was made with the uncorrected laws of {PLAIN}; make it again: flexura {MADE_BY[name]}"
        for name in PANEL_RESULTS
        if PLAIN in found.get(name, {}).get("inputs", {})
    ]
