"""What stands on the report's page, stage by stage, as far as the run has come."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.experiment import Experiment
from analysis.frf import Frf
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.updated import GOOD_MISFIT
from app.files.bad_file import ResultFileError
from app.files.compensation_file import load_compensation
from app.files.filter_files import load_focusing, load_uncorrected
from app.files.frf_file import load_frf
from app.files.laws_file import load_laws, load_updated
from app.files.modes_file import load_modes
from app.files.run_folder import MADE_BY, run_file
from app.modal_test.saved import is_test_run
from app.report import focusing, identified, measured, paper, studies, updated
from app.report.declared import experiment_points, picture, pieces_of, plate_words, transducer_rows
from app.report.gap_section import gap_section
from app.report.modal_test import sections_of_test
from app.report.origin import origin, outdated, stamps
from app.report.page import Absent, Item, Listing, PageTable, Paragraph, Picture, Section, VerdictBox
from app.report.summary import summary
from app.terminal.gap import with_sigma

OPTIONAL = ("gap.h5", "studies.h5")
"""Stages that a run is complete without."""


@dataclass(frozen=True)
class Found:
    """The page's title, the line under it, its sections, and what was found amiss among the results."""

    title: str
    subtitle: str
    sections: Sequence[Section]
    amiss: Sequence[str]


def sections(run: Path, report: Progress) -> Found:
    """Read what `run` holds; ResultFileError where it is no run folder at all."""
    if is_test_run(run):
        title, subtitle, of_test = sections_of_test(run)
        return Found(title, subtitle, of_test, [])
    experiment, frf = load_frf(run_file(run, "frf.h5", "report"))
    rows: list[paper.PaperRow] = []
    parts: list[tuple[str, str, Callable[[], list[Item]]]] = [
        ("Measurement", "frf.h5", lambda: _measurement(experiment, frf)),
        ("Identification", "modes.h5", lambda: _identification(run, frf, rows)),
        ("Updated twin and material laws", "laws.h5", lambda: _updating(run, experiment, frf, rows)),
        ("What the twin lacks", "gap.h5", lambda: gap_section(run / "gap.h5")),
        ("Focusing", "filters.h5", lambda: _focusing(run, rows)),
        ("Compensation", "compensation.h5", lambda: _compensation(run, rows)),
        ("The paper's studies", "studies.h5", lambda: studies.items(run / "studies.h5", rows)),
    ]
    lines = [(verb, line) for verb, line in summary(run).items() if verb != "import"]
    made = [Section("In short", [PageTable(("stage", "found"), lines)])] if lines else []
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
    old = outdated(run, found)
    if old:
        made.insert(
            0, Section("Before you read on", [VerdictBox("Results that do not belong together", old, False)])
        )
    report("report", 1.0)
    temperature = frf.temperature
    subtitle = f"{len(temperature)} sweeps, {temperature.min():z.1f} to {temperature.max():z.1f} °C"
    return Found(experiment.title, subtitle, made, old)


def _measurement(experiment: Experiment, frf: Frf) -> list[Item]:
    plate, protocol, inputs = experiment.plate, experiment.protocol, experiment.acquisition
    facts = [
        ("plate", plate_words(plate)),
        ("mass, density", f"{1e3 * plate.mass:g} g, {plate.density:.0f} kg/m³"),
        *(
            (p.role, f"{p.id}: {p.material} at {p.center[0]:g}, {p.center[1]:g} m, {p.side}")
            for p in experiment.patch
        ),
        *transducer_rows(experiment),
        ("transfers", ", ".join(frf.label(k) for k in range(min(len(frf.channels), 8)))),
        (
            "sweeps",
            f"{protocol.sweep}, {protocol.band[0]:g} to {protocol.band[1]:g} Hz, {protocol.sweep_duration:g} s "
            f"and {protocol.tail:g} s of silence, {protocol.repeats} repeats",
        ),
        (
            "input",
            f"{inputs.module} at {inputs.sample_rate:.2f} Hz, {inputs.input_resistance:g} Ω across each sensor",
        ),
    ]
    items: list[Item] = [
        PageTable(("", ""), facts),
        Picture(
            "declared",
            "What was declared?",
            picture(pieces_of(plate, experiment.patch, experiment_points(experiment))),
            "Outline, patches and what holds the plate.",
        ),
        Picture(
            "waterfall",
            "How does the plate's response change with temperature?",
            measured.waterfall(frf),
            "Measured H1 over temperature (paper Fig. 7).",
        ),
        Picture(
            "noise",
            "How good is the measurement?",
            measured.noise(frf),
            "H1, its standard deviation from the repeats, and the coherence.",
        ),
    ]
    if frf.notes:
        items.append(Listing("\n".join(frf.notes)))
    return items


def _identification(run: Path, frf: Frf, rows: list[paper.PaperRow]) -> list[Item]:
    tracked = load_modes(run / "modes.h5")
    rows.extend(paper.mode_rows(tracked))
    items: list[Item] = [
        Picture(
            "identified",
            "Do the modes found explain the response?",
            identified.overlay(frf, tracked),
            "Poles and residues of a sweep, and what they add up to (paper Fig. 9).",
        ),
        Picture(
            "tracked",
            "Where do the modes go with temperature?",
            identified.over_temperature(tracked),
            "Modes over temperature (paper Fig. 10).",
        ),
    ]
    if tracked.notes:
        items.append(Listing("\n".join(tracked.notes)))
    return items


def _updating(run: Path, experiment: Experiment, frf: Frf, rows: list[paper.PaperRow]) -> list[Item]:
    estimates, twin = load_updated(run / "laws.h5")
    try:
        laws = load_laws(run / "laws.h5")
        rows.extend(paper.material_rows(laws))
    except ResultFileError:
        laws = None
    worst = float((estimates.misfit / estimates.noise_floor).max())
    unit = experiment.inputs[0].gain_unit
    text = (
        f"One gain for all sweeps: {estimates.gain:.4f} ± {estimates.sigma_gain:.4f} {unit}. The twin misses at "
        f"most {worst:.2f} times the noise of the measurement. Its reduced model is certified to "
        f"{twin.basis_error:.1g} of a transfer's rms."
    )
    if worst > GOOD_MISFIT and not (run / "gap.h5").is_file():
        text += " It lacks something the plate has; what, may be found with: flexura gap CAMPAIGN."
    return [
        Paragraph(text),
        *([] if laws is None else [_constants(laws)]),
        Picture(
            "overlays",
            "Does the twin answer as the plate does?",
            updated.overlays(frf, twin, estimates),
            "Measured and updated FRFs (paper Fig. 11).",
        ),
        Picture(
            "laws",
            "What is the plate made of, at each temperature?",
            updated.laws(estimates, laws),
            "E, η and ν over temperature, two-sigma bands (paper Fig. 12).",
        ),
        Picture(
            "misfit",
            "Does the twin miss more than noise?",
            updated.misfit(estimates),
            "What the twin misses, against the noise of the measurement.",
        ),
    ]


def _constants(laws: MaterialLaws) -> PageTable:
    """E, ν and η with their standard deviations at round temperatures."""
    low, high = laws.temperature_range
    temperature = np.arange(10.0 * np.ceil(low / 10.0 - 0.05), high + 0.5, 10.0).clip(low, high)
    value, sigma = laws.at(temperature), laws.sigma(temperature)
    columns = (("youngs_modulus", 1e9), ("poisson_ratio", 1.0), ("loss_factor", 0.01))
    cells = [
        [with_sigma(v / unit, s / unit) for v, s in zip(getattr(value, name), getattr(sigma, name), strict=True)]
        for name, unit in columns
    ]
    rows = [(f"{t:z.0f}", *row) for t, row in zip(temperature, zip(*cells, strict=True), strict=True)]
    return PageTable(("T [°C]", "E [GPa]", "ν", "η [%]"), rows, numbers=(0, 1, 2, 3))


def _focusing(run: Path, rows: list[paper.PaperRow]) -> list[Item]:
    panel, found, comparison = load_focusing(run / "filters.h5")
    rows.extend([*paper.method_rows(comparison), *paper.temperature_rows(found)])
    reference = f"{found.reference_temperature:g} °C"
    items: list[Item] = [
        Picture(
            "panel",
            "What is to be moved, and by which actuators?",
            focusing.layout(panel),
            "The panel: what the paper leaves open is stated in its file.",
        ),
        Picture(
            "methods",
            "What does STIF gain over other ways to drive the panel?",
            focusing.methods(comparison),
            "Four ways to drive it, complex filters (paper Fig. 4).",
        ),
        Picture(
            "before",
            "What does temperature do to filters that do not follow it?",
            focusing.before(found),
            f"The filters of {reference} used at every temperature (paper Fig. 13).",
        ),
    ]
    uncorrected = load_uncorrected(run / "filters.h5")
    if uncorrected is not None:
        caption = "Filters designed with and without the effects found, on a plate that obeys the corrected laws."
        question = "What is the corrected twin worth for the filters?"
        items.append(Picture("correction", question, focusing.correction(found, uncorrected), caption))
    return items


def _compensation(run: Path, rows: list[paper.PaperRow]) -> list[Item]:
    _, found = load_compensation(run / "compensation.h5")
    rows.extend(paper.compensation_rows(found))
    items: list[Item] = [
        Picture(
            "relative-error",
            "How far are the networks' filters from those computed?",
            focusing.relative_errors(found),
            "Relative error of the filters (paper Fig. 15).",
        ),
        Picture(
            "after",
            "Does compensation bring the aim back?",
            focusing.after(found),
            "Contrast and spot error with compensation (paper Fig. 17).",
        ),
    ]
    if (run / "filters.h5").is_file():
        before = load_focusing(run / "filters.h5")[1]
        items.append(
            Picture(
                "regained",
                "How much of what temperature costs is regained?",
                focusing.loss(before, found),
                "Mean contrast of the band over temperature.",
            )
        )
    worst = found.relative_error.max(axis=(1, 2))
    cells = [
        (
            name,
            f"{worst[m]:.2g}",
            f"{found.relative_error[m].mean():.2g}",
            f"{found.contrast_loss[m].max():.2g}",
            f"{found.seconds[m]:.2f}",
        )
        for m, name in enumerate(found.methods)
    ]
    headings = ("method", "max RE [%]", "mean RE [%]", "largest contrast loss", "seconds")
    said = "RE, relative error, eq. (13), is a ratio of energies: 0.01 % of it is 1 % of a filter's amplitude."
    return [*items, PageTable(headings, cells, numbers=(1, 2, 3, 4)), Paragraph(said)]
