"""Figures of ``flexura study``, and its table of our numbers beside the paper's."""

from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from analysis.compensation.outcome import NETWORK, Compensation, NetworkStudy
from analysis.focusing.played import Played
from app.files.results.panel_files import Studies, Surfaces, load_studies
from app.report import focusing
from app.report.page import Item, Picture
from app.report.paper import PaperRow, reach
from app.report.style import MEASURED, frequency_axis, legend_below, panels


def items(path: Path, beside: list[PaperRow]) -> list[Item]:
    """Figures of a studies file; its numbers go to the rows `beside` the paper's."""
    studies = load_studies(path)
    beside.extend(rows(studies))
    return [*pictures(studies)]


def pictures(studies: Studies) -> list[Picture]:
    """Every figure the studies hold, by the paper's number."""
    found = []
    if studies.played is not None:
        caption = "With taps, on the illustration's plate; points: a sweep of 2 s played in the time domain."
        found.append(Picture("study-4", "What does STIF gain over its rivals?", played(studies.played), caption))
    if studies.fixed is not None:
        figure, caption = focusing.before(studies.fixed), "One filter for all temperatures (paper Fig. 13)."
        found.append(Picture("study-13", "What does temperature do to fixed filters?", figure, caption))
    if studies.compensation is not None:
        made = studies.compensation
        for name, question, figure, caption in (
            ("14", "What is trained?", architecture(made), "Architecture of one network (paper Fig. 14)."),
            (
                "15",
                "How far off are the filters?",
                focusing.relative_errors(made),
                "Relative error (paper Fig. 15).",
            ),
            ("17", "Is the aim back?", focusing.after(made), "With the networks' filters (paper Fig. 17)."),
        ):
            found.append(Picture(f"study-{name}", question, figure, caption))
    if studies.surfaces is not None:
        caption = "Taps that the networks give over temperature (paper Fig. 16)."
        found.append(Picture("study-16", "How do filters change?", surfaces(studies.surfaces), caption))
    for name, axis, studied in (("18", "nodes", studies.nodes), ("19", "spacing", studies.spacings)):
        if studied is not None:
            caption = f"Networks judged at every quarter of a degree, over their {axis} (paper Fig. {name})."
            question = "How many nodes?" if axis == "nodes" else "How many temperatures?"
            found.append(Picture(f"study-{name}", question, choices(studied, axis), caption))
    return sorted(found, key=lambda picture: int(picture.name.split("-")[1]))


def played(found: Played) -> Figure:
    """Contrast of all methods with taps: line by line, and of a sweep as it passes."""
    figure, axes = panels(1, 2, height=4.0, sharey=True, width_ratios=(2.2, 1.0))
    for place, name in enumerate(found.methods):
        (curve,) = axes[0].plot(found.frequency, found.contrast[place], lw=1.6 if place == 0 else 0.9, label=name)
        axes[0].plot(
            found.sweep_frequency, found.sweep_contrast[place], ".", ms=3.5, color=curve.get_color(), alpha=0.7
        )
        axes[1].bar(place, found.total[place], color=curve.get_color())
    axes[1].plot(range(len(found.methods)), found.expected, "_", ms=26, color=MEASURED, label="from the spectrum")
    names = [name.replace("-", "-\n") for name in found.methods]
    axes[1].set_xticks(range(len(names)), names, fontsize=8.5)
    axes[0].set(ylabel="contrast, eq. (9)", ylim=(0, 1), title="curves: lines; points: sweep as it passes")
    axes[1].set(title="whole sweep, time domain")
    frequency_axis(axes[0])
    legend_below(figure, *axes)
    return figure


def architecture(found: Compensation) -> Figure:
    """Draw one network: temperature, hidden tanh nodes, taps."""
    figure, axes = panels(1, 1, width=7.0, height=2.6)
    nodes, taps = found.trained.settings.nodes, found.filters.taps.shape[2]
    fed = "temperature" if found.trained.settings.feed == "temperature" else "log √D(T)"
    columns = (
        (0.0, 1, f"input\n{fed}"),
        (1.0, nodes, f"hidden\n{nodes} tanh"),
        (2.0, 7, f"output\n{taps} linear"),
    )
    rows = [(x, np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1)) for x, count, _ in columns]
    for (x, left), (y, right) in pairwise(rows):
        for a in left:
            axes.plot(
                np.repeat([[x], [y]], len(right), axis=1), [np.full(len(right), a), right], color="0.85", lw=0.6
            )
    for (x, places), (_, _, label) in zip(rows, columns, strict=True):
        axes.plot(np.full(len(places), x), places, "o", ms=9, color="#00798c")
        axes.annotate(label, (x, -1.25), ha="center", va="top")
    axes.annotate("…", (2.12, 0.0), va="center")
    axes.set(
        xlim=(-0.4, 2.5),
        ylim=(-1.9, 1.2),
        title=f"one network for each of {found.filters.taps.shape[1]} actuators",
    )
    axes.set_axis_off()
    return figure


def surfaces(found: Surfaces) -> Figure:
    """Taps over time and temperature, a map for every actuator."""
    count = found.taps.shape[1]
    figure, axes = panels(
        -(-count // 3), min(count, 3), height=2.4 * -(-count // 3), sharex=True, sharey=True, squeeze=False
    )
    time = 1e3 * np.arange(found.taps.shape[2]) / found.sample_rate
    for number, each in enumerate(axes.flat):
        if number >= count:
            each.set_axis_off()
            continue
        values = found.taps[:, number]
        most = float(np.abs(values).max())
        mesh = each.pcolormesh(
            time, found.temperature, values, cmap="RdBu_r", vmin=-most, vmax=most, rasterized=True
        )
        figure.colorbar(mesh, ax=each, label="V" if number % 3 == 2 else None)
        each.set_title(f"actuator {number + 1}")
        each.grid(visible=False)
    for each in axes[-1]:
        each.set_xlabel("time [ms]")
    for each in axes[:, 0]:
        each.set_ylabel("temperature [°C]")
    return figure


def choices(found: NetworkStudy, axis: str) -> Figure:
    """Mean relative error of every actuator and the contrast lost, over nodes or spacing."""
    figure, axes = panels(1, 2, height=3.6)
    at = found.nodes if axis == "nodes" else found.spacing
    for number, curve in enumerate(found.squared_error.T):
        axes[0].semilogy(at, np.maximum(curve, 1e-9), "o-", ms=3.5, lw=0.9, label=f"actuator {number + 1}")
    axes[1].semilogy(at, np.maximum(found.contrast_loss, 1e-5), "o-", ms=3.5, color="#00798c")
    for place in np.flatnonzero(np.isnan(found.contrast_loss)):
        for each in axes:
            each.axvline(at[place], color="#d1495b", ls=":", lw=1.0)
    unit = "hidden nodes" if axis == "nodes" else "°C between training temperatures"
    axes[0].set(ylabel="mean relative error, eq. (13) [%]", xlabel=unit, title="networks, each actuator")
    axes[1].set(ylabel="contrast lost, worst line", xlabel=unit, title="all of them")
    curves = axes[0].get_legend_handles_labels()[0]
    if np.isnan(found.contrast_loss).any():
        curves.append(Line2D([], [], color="#d1495b", ls=":", label="refused: evidence collapsed"))
    figure.legend(handles=curves, loc="outside lower center", ncols=7)
    return figure


def rows(studies: Studies) -> list[PaperRow]:
    """Our numbers beside the paper's."""
    found = []
    if studies.played is not None:
        stif = studies.played.methods.index("stif")
        below = studies.played.frequency <= 540.0
        ours = (
            f"{studies.played.contrast[stif, below].mean():.2f}, sweep to 800 Hz {studies.played.total[stif]:.2f}"
        )
        heading = "Fig. 4: contrast of STIF with taps to 540 Hz, on the illustration's plate"
        found.append(PaperRow(heading, "about 0.9", ours, "positions not published"))
        gap = float(np.abs(studies.played.total - studies.played.expected).max())
        found.append(PaperRow("Fig. 4: time against frequency domain", "not given", f"{gap:.1g}", ""))
    if studies.fixed is not None:
        mean = studies.fixed.fixed.contrast.mean(axis=1)
        pairs = ", ".join(f"{t:g} °C {c:.2f}" for t, c in zip(studies.fixed.temperature, mean, strict=True))
        found.append(
            PaperRow("Fig. 13: mean contrast, fixed filters", "degraded away from 20 °C", pairs, "curves only")
        )
    if studies.compensation is not None and reach(studies.compensation.temperature):
        made = studies.compensation
        place = made.methods.index(NETWORK)
        error = f"{made.relative_error[place].max():.2g}"
        found.append(
            PaperRow("Fig. 15: largest relative error [%]", "0.9", error, "of all actuators, every 0.25 °C")
        )
        lost = f"{made.largest_loss[place]:.2g} at the worst line"
        found.append(PaperRow("Fig. 17: contrast lost by the networks", "none visible", lost, ""))
    if studies.nodes is not None:
        for nodes, paper in ((9, "below 1"), (10, "below 0.1"), (16, "below 0.1")):
            error = studies.nodes.squared_error[studies.nodes.nodes == nodes]
            ours = "refused" if np.isnan(error).any() else f"{error.max():.2g}"
            found.append(PaperRow(f"Fig. 18: mean error, {nodes} nodes [%]", paper, ours, "worst actuator"))
    if studies.spacings is not None:
        for row, spacing in enumerate(studies.spacings.spacing):
            error = studies.spacings.squared_error[row]
            ours = "refused" if np.isnan(error).any() else f"{error.max():.2g}"
            found.append(
                PaperRow(f"Fig. 19: mean error, every {spacing:g} °C [%]", "curves only", ours, "14 nodes")
            )
    return found
