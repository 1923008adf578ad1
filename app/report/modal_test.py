"""Figures and sections of a test at many places: FRFs, indicator, stabilization, shapes."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from analysis.estimation.transfer import direction_sign
from analysis.identification.modes import Modes
from analysis.shapes.participation import ModeShapes, mac
from analysis.shapes.stabilization import StabilizationChart, cmif
from app.files.bad_file import quoted
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import AXIS, MODE_HEADINGS, load_stabilization, load_test, mode_names, mode_rows
from app.modal_test.without_windows import rebuilt
from app.report.page import Item, Listing, PageTable, Paragraph, Picture, Section, Words
from app.report.style import MEASURED, MODEL, frequency_axis, legend_below, panels
from app.report.summary import origin, stamps
from app.summaries.modes import READ_AS

FRFS_DRAWN = 4
"""FRFs drawn at most."""
DRAWN_SHAPES = 12
"""Mode shapes drawn at most: four rows of three fit a page."""
POOR_COHERENCE = 0.9
"""Median over the lines below which an FRF is named: noise, a nonlinear structure, or averages that disagree."""
ALIKE = 0.9
"""MAC from which the places measured do not tell two shapes apart."""
FILES = ("transfers.h5", "modes.h5", "stabilization.h5")


def sections_of_test(run: Path) -> tuple[str, str, list[Section]]:
    """Title, line under it and sections; ResultFileError where a file of the run is missing or damaged."""
    frfs, modes, shapes = load_test(run)
    chart = load_stabilization(run / "stabilization.h5")
    labels = dict.fromkeys(frfs.label(n) for n in range(len(frfs.transfers)))
    facts = [(word, value) for word, value in (("date", frfs.date), ("operator", frfs.operator)) if value]
    facts += [
        ("FRFs", f"{len(frfs.transfers)}: {', '.join(labels)}"),
        ("places", f"{len(shapes.places)}, with {len(shapes.references)} at the other end"),
        ("lines", f"{len(frfs.frequency)} from {frfs.frequency[0]:g} to {frfs.frequency[-1]:g} Hz"),
    ]
    measured: list[Item] = [
        PageTable(("", ""), facts),
        Picture(
            "frfs",
            "Do the modes found explain the FRFs?",
            overlay(frfs, modes),
            "Measured FRFs and what poles and residues add up to; lines: modes, dotted where weak or unconfirmed.",
        ),
    ]
    known = [one for one in frfs.transfers if one.coherence is not None]
    if known:
        medians = [float(np.median(one.coherence)) for one in known if one.coherence is not None]
        worst = int(np.argmin(medians))
        facts.append(
            ("coherence", f"median {np.median(medians):.3g}, least {medians[worst]:.3g}: {known[worst].name}")
        )
        words = "Of every FRF, those drawn above dark: 1 where the drive alone explains the response."
        measured.append(Picture("coherence", "Can the FRFs be trusted?", coherences(frfs), words))
    if frfs.notes:
        measured.append(Listing("\n".join(frfs.notes)))
    found: list[Item] = [
        Paragraph(READ_AS[modes.damping]),
        mode_table(modes, shapes),
        Picture(
            "stabilization",
            "Which poles stay as the order of the model rises?",
            stabilization(frfs, chart),
            "Poles by order over the CMIF; full dots: stable in frequency and damping, rings: in frequency.",
        ),
    ]
    parts = [
        Section("In short", [in_short(run, frfs, modes, shapes)]),
        Section("Measurement", measured),
        Section("Modes", found),
    ]
    if len(shapes.places) > 1 and len(shapes.pole):
        moving, alike = drawn_shapes(frfs, modes, shapes), auto_mac(modes, shapes)
        pictures = [
            Picture("shapes", "How does it move?", moving, _shape_words(frfs, shapes)),
            Picture("auto-mac", "Can the shapes be distinguished?", alike, "AutoMAC of the shapes."),
        ]
        parts.append(Section("Shapes", pictures))
    parts.append(Section("Provenance", origin(stamps(run, FILES))))
    return frfs.title, f"{len(frfs.transfers)} FRFs, {int(modes.real.sum())} modes", parts


def in_short(run: Path, frfs: FrfSet, modes: Modes, shapes: ModeShapes) -> Words:
    """Say what was found, how sure it is, and what to do next."""
    reading, real = modes.reading(), np.flatnonzero(modes.real)
    frequency, ratio = reading.frequency_hz[real], 100.0 * reading.damping_ratio[real]
    unsure = [f"{reading.frequency_hz[j]:.4g} Hz" for j in real if not modes.sure[j]]
    poor, alike = _poor(frfs), _alike(modes, shapes)
    headline, found = "no mode was found", []
    if len(real):
        headline = f"{len(real)} mode{'s' if len(real) > 1 else ''}, {_from_to(frequency, '.4g')} Hz"
        found.append(f"Damping ratio: {_from_to(ratio, '.3g')} %.")
    if unsure:
        headline += f"; {len(unsure)} not confirmed"
        found.append(f"Weak, or not confirmed by refits: {', '.join(unsure)}.")
    extent = f"{len(frfs.transfers)} FRFs of {len(shapes.places)} places, {_from_to(frfs.frequency, '.4g')} Hz."
    parts = [("what was measured", [extent]), ("modes", found)]
    if len(shapes.places) > 1 and len(shapes.pole) > 1:
        parts.append(("shapes", [alike or "The places measured tell all shapes apart."]))
    onward = ["Measure the FRFs named above again before the modes are used."] if poor else []
    onward += ["Measure at more places, so that these shapes differ."] if alike else []
    onward += [f"See the shapes move: flexura view {quoted(run)}"]
    return Words(headline, bool(len(real)) and not (unsure or poor or alike), poor, [*parts, ("next", onward)])


def _from_to(values: NDArray[np.float64], form: str) -> str:
    low, high = (format(one, form) for one in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _poor(frfs: FrfSet) -> list[str]:
    """Name the FRFs whose coherence says that they cannot be trusted."""
    known = [(one.name, float(np.median(one.coherence))) for one in frfs.transfers if one.coherence is not None]
    poor = [f"{name} ({median:.2g})" for name, median in known if median < POOR_COHERENCE]
    return [f"Median coherence below {POOR_COHERENCE:g}: {', '.join(poor)}."] if poor else []


def _alike(modes: Modes, shapes: ModeShapes) -> str:
    """Name the two shapes that are most alike, where they are too much so."""
    between = np.abs(mac(shapes.shape, shapes.shape)) - np.eye(len(shapes.pole))
    if between.size < 2 or between.max() < ALIKE:
        return ""
    first, second = np.unravel_index(int(between.argmax()), between.shape)
    names = mode_names(modes, shapes)
    return f"Shapes {names[first]} and {names[second]} Hz look alike at these places (MAC {between.max():.2f})."


def mode_table(modes: Modes, shapes: ModeShapes) -> PageTable:
    """Frequency, damping, standard deviations, status and MPC of every mode."""
    rows = [(str(n), *row) for n, row in enumerate(mode_rows(modes, shapes), start=1)]
    return PageTable(("mode", *MODE_HEADINGS), rows, numbers=(0, 1, 2, 3, 4, 5))


def overlay(frfs: FrfSet, modes: Modes) -> Figure:
    """Draw a few FRFs, evenly chosen, and their synthesis."""
    chosen = np.unique(np.linspace(0, len(frfs.transfers) - 1, FRFS_DRAWN).astype(int))
    model = rebuilt(modes, frfs.frequency, frfs)
    figure, axes = panels(len(chosen), 1, height=2.2 * len(chosen) + 0.8, sharex=True, squeeze=False)
    reading = modes.reading()
    for axis, number in zip(axes.ravel(), chosen, strict=True):
        size = np.abs(frfs.h[number])
        axis.semilogy(frfs.frequency, size, color=MEASURED, lw=1.6, label="measured")
        axis.semilogy(frfs.frequency, np.abs(model[number]), color=MODEL, lw=0.9, label="from poles and residues")
        axis.set_ylim(
            0.5 * max(float(np.percentile(size, 0.5)), 1e-9 * float(size.max())), 2.0 * float(size.max())
        )
        for f, real, sure in zip(reading.frequency_hz, modes.real, modes.sure, strict=True):
            if real:
                axis.axvline(f, color="0.6", lw=0.7, ls="-" if sure else ":", zorder=0)
        axis.set_ylabel(f"|{frfs.label(number).replace(' [', '| [')}", fontsize=8.5)
        axis.set_title(frfs.transfers[number].name, fontsize=9)
    legend_below(figure)
    frequency_axis(axes.ravel()[-1])
    return figure


def coherences(frfs: FrfSet) -> Figure:
    """Draw the coherence of every FRF that has one; that of those which `overlay` draws in the foreground."""
    chosen = set(np.unique(np.linspace(0, len(frfs.transfers) - 1, FRFS_DRAWN).astype(int)).tolist())
    figure, axes = panels(1, 1, height=2.6)
    axis = axes if not isinstance(axes, np.ndarray) else axes.ravel()[0]
    for number, one in enumerate(frfs.transfers):
        if one.coherence is not None:
            front = number in chosen
            color, width = (MEASURED, 1.0) if front else ("0.75", 0.6)
            axis.plot(frfs.frequency, one.coherence, color=color, lw=width, zorder=2.0 + front)
    axis.set_ylim(-0.02, 1.02)
    axis.set_ylabel("coherence")
    frequency_axis(axis)
    return figure


def stabilization(frfs: FrfSet, chart: StabilizationChart) -> Figure:
    """Draw the poles of every order over the CMIF."""
    figure, axes = panels(1, 1, height=4.2)
    axis = axes if not isinstance(axes, np.ndarray) else axes.ravel()[0]
    for number, values in enumerate(cmif(frfs.transfers)[:3]):
        axis.semilogy(frfs.frequency, np.maximum(values, 1e-300), color=MEASURED, lw=1.4 - 0.4 * number)
    axis.set_ylabel("CMIF")
    orders = axis.twinx()
    for level, face, size in ((0, "none", 6), (1, "none", 22), (2, MODEL, 22)):
        here = chart.stable == level
        edge = MODEL if level else "0.6"
        orders.scatter(chart.frequency[here], chart.order[here], size, facecolors=face, edgecolors=edge, lw=0.8)
    orders.set_ylabel("pole pairs of the model")
    orders.grid(False)
    frequency_axis(axis)
    return figure


def drawn_shapes(frfs: FrfSet, modes: Modes, shapes: ModeShapes) -> Figure:
    """Draw the shapes along +x, +y or +z: coloured points where nodes lie in a plane, a line otherwise.

    Parameters
    ----------
    frfs : FrfSet
        Gives the places of the nodes, as far as they are known.
    shapes : ModeShapes
        Only the first are drawn, see `DRAWN_SHAPES`.
    """
    count = min(len(shapes.pole), DRAWN_SHAPES)
    rows = (count + 2) // 3
    figure, axes = panels(rows, 3, width=10.0, height=2.6 * rows + 0.4, squeeze=False)
    nodes = [int(place.partition(":")[0]) for place in shapes.places]
    known = all(node in frfs.points for node in nodes)
    where = np.array([frfs.points[node] for node in nodes]) if known else np.zeros((len(nodes), 3))
    spread = np.ptp(where, axis=0)
    axes_used = np.argsort(-spread)[:2]
    frequency = modes.reading().frequency_hz[shapes.pole]
    sign = np.array([direction_sign(place) for place in shapes.places])
    for n, axis in enumerate(axes.ravel()):
        if n >= count:
            axis.set_axis_off()
            continue
        motion = sign * shapes.shape[n].real
        if known and spread[axes_used[1]] > 0.05 * spread[axes_used[0]]:
            first, second = sorted(int(a) for a in axes_used)
            x, y = where[:, first], where[:, second]
            axis.scatter(x, y, 60, motion, cmap="RdBu_r", vmin=-1, vmax=1, edgecolors="0.5")
            axis.set_aspect("equal")
            axis.set(xlabel=f"{'xyz'[first]} [m]", ylabel=f"{'xyz'[second]} [m]")
        else:
            placed = known and spread.max() > 0.0
            line = where[:, axes_used[0]] if placed else np.arange(len(nodes), dtype=float)
            order = np.argsort(line)
            if placed:
                axis.set_xlabel(f"{'xyz'[axes_used[0]]} [m]")
            else:
                shown = np.unique(np.linspace(0, len(nodes) - 1, 10).astype(int))
                axis.set_xticks(shown, [str(nodes[n]) for n in shown])
                axis.set_xlabel("node")
            axis.plot(line[order], motion[order], "o-", color=MODEL, ms=4, lw=1.0)
            axis.axhline(0.0, color="0.6", lw=0.7)
            axis.set_ylim(-1.15, 1.15)
        axis.set_title(f"{frequency[n]:.1f} Hz", fontsize=9)
    return figure


def _shape_words(frfs: FrfSet, shapes: ModeShapes) -> str:
    nodes = {int(place.partition(":")[0]) for place in shapes.places}
    unknown = sorted(nodes - frfs.points.keys())
    where = "over the places of the nodes"
    if unknown:
        few = ", ".join(map(str, unknown[:3])) + (", ..." if len(unknown) > 3 else "")
        where = f"by node: the places of {len(unknown)} of {len(nodes)} nodes are not known ({few})"
    drawn, there = DRAWN_SHAPES, len(shapes.pole)
    more = f" The first {drawn} of {there} shapes; flexura view shows all." if there > drawn else ""
    return f"Real parts, the largest component 1; {where}.{more}"


def auto_mac(modes: Modes, shapes: ModeShapes) -> Figure:
    """Draw how alike the shapes are, 0 to 1."""
    figure, axes = panels(1, 1, width=5.5, height=4.6)
    axis = axes if not isinstance(axes, np.ndarray) else axes.ravel()[0]
    image = axis.imshow(mac(shapes.shape, shapes.shape), vmin=0.0, vmax=1.0, cmap="Greys")
    names = mode_names(modes, shapes)
    axis.set_xticks(range(len(names)), names, fontsize=8.5, rotation=90)
    axis.set_yticks(range(len(names)), names, fontsize=8.5)
    axis.grid(False)
    axis.set(xlabel=AXIS, ylabel=AXIS)
    figure.colorbar(image, ax=axis, label="MAC")
    return figure
