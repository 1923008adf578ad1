"""The report's sections on the measured plate: measurement, identification, updated twin."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analysis.declaration.plate import Plate
from analysis.estimates import SheetMaterial
from analysis.experiment import Experiment
from analysis.material import MaterialLaws
from analysis.recordings.frf import Frf, sweeps_of_modes
from analysis.updated import GOOD_MISFIT, Updated
from app.files.campaigns.of_run import campaign_of
from app.files.declarations.plate import NOT_STATED
from app.files.results.best_twin import BEFORE, best_twin
from app.files.results.laws_file import TwinFrf, load_pairing
from app.files.results.modes_file import load_modes
from app.report import measured, paper
from app.report.declared import picture, pieces_of_experiment, plate_words, transducer_rows
from app.report.page import Item, Listing, PageTable, Paragraph, Picture
from app.report.pairing import pairing_items
from app.summaries.modes import READ_AS
from app.summaries.numbers import with_sigma
from app.summaries.update import CONSTANTS, gains_text

MOST_NAMED = 8
"""Transfers that are listed by name: a laser scan has hundreds."""


def measurement_section(experiment: Experiment, frf: Frf) -> list[Item]:
    """Return what was declared and measured."""
    items: list[Item] = [
        PageTable(("", ""), _facts(experiment, frf)),
        Picture(
            "declared",
            "What was declared?",
            picture(pieces_of_experiment(experiment)),
            "Outline, patches, what holds the plate, and the points driven and measured, named as their channels.",
        ),
        *(
            Picture(
                f"waterfall{also}",
                "How does the plate's response change with temperature?",
                measured.waterfall(frf.of_source(source)),
                f"Measured H1 over temperature{paper.figure(experiment.plate, 7)}{of}.",
            )
            for source, also, of in _each(frf)
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


def identification_section(run: Path, experiment: Experiment, frf: Frf, rows: list[paper.PaperRow]) -> list[Item]:
    """Return the modes, and put them beside the paper's.

    Parameters
    ----------
    run : Path
        Run folder.
    rows : list of PaperRow
        To which those of this stage are appended.

    Raises
    ------
    ResultFileError
        Where modes.h5 cannot be read.
    """
    tracked = load_modes(run / "modes.h5")
    places = sweeps_of_modes(frf, tracked)
    if (places >= 0).any():
        frf = frf.of_source(int(frf.driven_by[places >= 0][0]))
    rows.extend(paper.mode_rows(tracked))
    items: list[Item] = [
        Paragraph(
            f"Modes at {tracked.temperature[measured.drawn(tracked)]:.1f} °C; modes.csv holds all sweeps. "
            f"{READ_AS[tracked.damping]}"
        ),
        measured.mode_table(tracked),
        Picture(
            "identified",
            "Do the modes found explain the response?",
            measured.overlay(frf, tracked),
            f"Poles and residues of a sweep, and what they add up to{paper.figure(experiment.plate, 9)}.",
        ),
        Picture(
            "tracked",
            "Where do the modes go with temperature?",
            measured.over_temperature(tracked),
            f"Modes over temperature{paper.figure(experiment.plate, 10)}.",
        ),
    ]
    if tracked.notes:
        items.append(Listing("\n".join(tracked.notes)))
    return items


def updating_section(run: Path, experiment: Experiment, frf: Frf, rows: list[paper.PaperRow]) -> list[Item]:
    """Return twin and laws, and put them beside the paper's.

    Parameters
    ----------
    run : Path
        Run folder.
    rows : list of PaperRow
        To which those of this stage are appended.

    Raises
    ------
    ResultFileError
        Where laws.h5 cannot be read.
    """
    best = best_twin(run, "report")
    estimates, twin, laws = best.twin.updated, best.twin.answers, best.twin.laws
    rows.extend([] if laws is None or estimates.sheet is not None else paper.material_rows(laws))
    plain = best.uncorrected
    worst = float((estimates.misfit / estimates.noise_floor).max())
    each = "" if estimates.further is None else " of an actuator"
    text = (
        f"One gain for all sweeps{each}: {gains_text(estimates, experiment.inputs)}. The twin misses at "
        f"most {worst:.2f} times the noise of the measurement. Its reduced model is certified to "
        f"{twin.basis_error:.1g} of a transfer's rms."
    )
    if best.said:
        text = f"{best.said[0].upper()}{best.said[1:]}. {text}"
    if worst > GOOD_MISFIT and not (run / "gap.h5").is_file():
        text += f" It lacks an effect that the plate has; to find it: flexura gap {campaign_of(run)}"
    same = np.array_equal(frf.temperature, estimates.temperature)
    if not same:
        text += (
            " frf.h5 holds other sweeps than laws.h5, so that they are not compared; make both: "
            f"flexura update {campaign_of(run)}"
        )
    return [
        Paragraph(text),
        *(Paragraph(sentence) for sentence in best.ignored),
        *(pairing_items(load_pairing(best.twin.path), "pairing", experiment) if plain is None else ()),
        *([_sheet_constants(estimates, estimates.sheet)] if estimates.sheet is not None else []),
        *(
            []
            if laws is None or estimates.sheet is not None
            else [_constants(laws, best.before, best.before_said)]
        ),
        *(_compared(experiment.plate, frf, twin, estimates) if same else []),
        Picture(
            "laws",
            "What is the plate made of, at each temperature?",
            measured.laws(estimates, laws, best.before, best.before_said),
            _laws_caption(experiment.plate, estimates, None if best.before is None else best.before_said),
        ),
    ]


def _facts(experiment: Experiment, frf: Frf) -> list[tuple[str, str]]:
    """Return the rows of the table of plate, transducers, sweeps and input card."""
    plate = experiment.plate
    date = "" if experiment.date is None else experiment.date.isoformat()
    return [
        *((word, value) for word, value in (("date", date), ("operator", experiment.operator)) if value),
        ("plate", plate_words(plate)),
        ("mass, density", f"{1e3 * plate.mass:g} g, {plate.density:.0f} kg/m³"),
        *(
            (p.role, f"{p.id}: {p.material} at {p.center[0]:g}, {p.center[1]:g} m, {p.side}")
            for p in experiment.patch
        ),
        *transducer_rows(experiment),
        ("transfers", _named(frf.labels or [frf.label(k) for k in range(len(frf.channels))])),
        *_measured(experiment),
    ]


def _named(transfers: Sequence[str]) -> str:
    """List transfers, and say how many there are where these are not all."""
    rest = len(transfers) - MOST_NAMED
    return ", ".join(transfers[:MOST_NAMED]) + (f", … ({len(transfers)} in all)" if rest > 0 else "")


def _measured(experiment: Experiment) -> list[tuple[str, str]]:
    """Return the rows of sweeps and input card; of FRFs that another program estimated, of their lines."""
    protocol, inputs = experiment.protocol, experiment.acquisition
    low, high = protocol.band
    if inputs.module == NOT_STATED:
        loaded = any(one.patch is not None and one.quantity == "voltage" for one in experiment.outputs)
        return [
            ("FRFs", f"of another program, {low:g} to {high:g} Hz, lines every {1 / protocol.record:.4g} Hz"),
            *([("input", f"{inputs.input_resistance:g} Ω across each sensor")] if loaded else []),
        ]
    return [
        (
            "sweeps",
            f"{protocol.sweep}, {low:g} to {high:g} Hz, {protocol.sweep_duration:g} s "
            f"and {protocol.tail:g} s of silence, {protocol.repeats} repeats",
        ),
        (
            "input",
            f"{inputs.module} at {inputs.sample_rate:.2f} Hz, {inputs.input_resistance:g} Ω across each sensor",
        ),
    ]


def _compared(plate: Plate, frf: Frf, twin: TwinFrf, estimates: Updated) -> list[Item]:
    """Return the pictures of measurement and twin of the same sweeps."""
    return [
        *(
            Picture(
                f"overlays{also}",
                "Does the twin answer as the plate does?",
                measured.overlays(frf, twin, estimates, source=source),
                f"Measured and updated FRFs{paper.figure(plate, 11)}{of}.",
            )
            for source, also, of in _each(frf)
        ),
        Picture(
            "misfit",
            "Does the twin miss more than noise?",
            measured.misfit(estimates, frf),
            "What the twin misses, against the noise of the measurement.",
        ),
    ]


def _each(frf: Frf) -> list[tuple[int, str, str]]:
    """Return the inputs that drove: which, how their pictures' names end, and what their captions say of them."""
    if not frf.sources:
        return [(0, "", "")]
    first = frf.driving[0]
    return [(k, "" if k == first else f"-{k + 1}", f", {frf.sources[k]} driven") for k in frf.driving]


def _laws_caption(plate: Plate, found: Updated, before: str | None) -> str:
    if found.sheet is not None:
        return "Moduli, Poisson's ratio and loss factors of the sheet in its own axes, two standard deviations."
    dashed = "" if before is None else f" Dashed: {before}."
    if before == BEFORE:
        dashed = " Dashed: before, of the comparison's own twin without what was found."
    return f"E, η and ν over temperature, two-sigma bands{paper.figure(plate, 12)}.{dashed}"


def _sheet_constants(found: Updated, sheet: SheetMaterial) -> PageTable:
    """Return the constants of an orthotropic sheet at the temperatures measured, ten at most."""
    order = np.argsort(found.temperature)
    chosen = order[np.unique(np.linspace(0, len(order) - 1, min(len(order), 10)).round().astype(int))]
    rows = []
    for row in chosen:
        pairs = (
            (getattr(part, one.name)[row] / one.scale for part in (sheet.value, sheet.sigma)) for one in CONSTANTS
        )
        rows.append((f"{found.temperature[row]:z.1f}", *(with_sigma(float(v), float(s)) for v, s in pairs)))
    headings = ("T [°C]", *(one.label for one in CONSTANTS))
    return PageTable(headings, rows, numbers=tuple(range(len(headings))))


def _constants(laws: MaterialLaws, earlier: MaterialLaws | None, said: str) -> PageTable:
    """E, ν and η with their standard deviations at round temperatures, and those before, which `said` names."""
    low, high = laws.temperature_range
    if earlier is not None:
        low, high = max(low, earlier.temperature_range[0]), min(high, earlier.temperature_range[1])
    temperature = np.arange(10.0 * np.ceil(low / 10.0 - 0.05), high + 0.5, 10.0).clip(low, high)
    value, sigma = laws.at(temperature), laws.sigma(temperature)
    columns = (("youngs_modulus", 1e9), ("poisson_ratio", 1.0), ("loss_factor", 0.01))
    cells = [
        [with_sigma(v / unit, s / unit) for v, s in zip(getattr(value, name), getattr(sigma, name), strict=True)]
        for name, unit in columns
    ]
    headings = ["T [°C]", "E [GPa]", "ν", "η [%]"]
    if earlier is not None:
        before = earlier.at(temperature)
        cells += [[f"{v / unit:.3f}" for v in getattr(before, name)] for name, unit in columns]
        headings += [f"{said}: E", "ν", "η"]
    rows = [(f"{t:z.0f}", *row) for t, row in zip(temperature, zip(*cells, strict=True), strict=True)]
    return PageTable(headings, rows, numbers=range(len(headings)))
