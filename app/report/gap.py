"""Where twin and data disagree, what was found, and what it changes."""

from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from analysis.estimates import FittedLaws, SheetMaterial
from analysis.gap.data.groups import TemperatureGroups
from analysis.gap.thresholds import LEAST_GAIN
from app.files.results.gap_file import GapFigures
from app.report.style import BAND, MODEL, frequency_axis, legend_below, panels
from app.summaries.update import CONSTANTS

Record = Mapping[str, Any]
BEFORE, AFTER, ALIKE, OTHER = MODEL, BAND, "#7cc4cc", "0.75"
CANDIDATES_SHOWN = 12
"""Candidates shown."""
CHANNELS_MAPPED = 8
"""Channels whose residual is mapped, those with the largest."""
LARGEST_COLOUR_SIGMA = 100.0
"""Sigma at which the colours of the maps end at the latest."""


def residual_maps(figures: GapFigures) -> Figure:
    """Residual in sigma over frequency and temperature, per channel of the largest ones, before and after.

    Before only, where nothing was found that would change it.
    """
    seen = [("before", figures.before), ("after", figures.after)]
    if not changes(figures):
        seen = [("", figures.before)]
    names = figures.before.channels
    # of a scan's hundreds those with the most beyond the noise
    most = np.sort(np.argsort(-figures.before.excess.sum((0, 2)), kind="stable")[:CHANNELS_MAPPED])
    figure, axes = panels(
        len(most),
        len(seen),
        width=0.5 + 5.0 * len(seen),
        height=0.7 + 2.3 * len(most),
        sharex=True,
        sharey=True,
        squeeze=False,
    )
    top = float(np.clip(figures.before.sigma.max(), 3.0, LARGEST_COLOUR_SIGMA))
    beyond_noise = mpl.colormaps["magma_r"](np.linspace(0.12, 1.0, 12))
    colors = LinearSegmentedColormap.from_list("gap", ["white", *beyond_noise])
    norm = LogNorm(1.0, top)
    for row, channel in enumerate(most.tolist()):
        for column, (title, found) in enumerate(seen):
            temperature, sigma = found.by_temperature(channel)
            cells = (found.edges, _edges(temperature))
            place = axes[row, column]
            image = place.pcolormesh(*cells, np.maximum(sigma, 1.0), cmap=colors, norm=norm, rasterized=True)
            place.grid(visible=False)
            place.set_title(f"{names[channel]}, {title}".removesuffix(", "))
        axes[row, 0].set_ylabel("temperature [°C]")
    for place in axes[-1]:
        frequency_axis(place)
    bar = figure.colorbar(image, ax=axes, label="rms residual [σ of the noise]", shrink=min(1.0, 2.0 / len(most)))
    ticks = [t for t in (1, 2, 3, 5, 10, 20, 30, 50, 100) if t <= top]
    bar.set_ticks(ticks, labels=[f"{t}" for t in ticks])
    bar.minorticks_off()
    return figure


def changes(figures: GapFigures) -> bool:
    """Whether the residual after is another than before: an effect was found."""
    return not np.array_equal(figures.before.sigma, figures.after.sigma)


def shares(figures: GapFigures) -> Figure:
    """Excess over the noise by frequency, temperature and channel, before and after, in shares of that before."""
    before, after = figures.before, figures.after
    total = float(before.excess.sum())
    scale = 100.0 / total if total > 0.0 else 0.0
    figure, axes = panels(1, 3, width=10.5, height=3.2, width_ratios=[1.6, 1.3, 0.6], sharey=False)
    width = np.diff(before.edges)
    for seen, color, label in ((before, BEFORE, "before"), (after, AFTER, "after")):
        thin = 1.0 if seen is before else 0.55
        alpha = 0.45 if seen is before else 0.95
        middle = 0.5 * (seen.edges[1:] + seen.edges[:-1])
        axes[0].bar(
            middle, scale * seen.excess.sum((0, 1)), 0.92 * thin * width, color=color, alpha=alpha, label=label
        )
        temperature, excess = _grouped(seen.temperature, seen.excess.sum((1, 2)))
        step = float(np.min(np.diff(temperature))) if len(temperature) > 1 else 1.0
        axes[1].bar(temperature, scale * excess, 0.85 * thin * step, color=color, alpha=alpha)
        place = np.arange(len(seen.channels))
        axes[2].bar(place, scale * seen.excess.sum((0, 2)), 0.8 * thin, color=color, alpha=alpha)
    axes[0].set(ylabel="share of the gap before [%]", title="by frequency")
    legend_below(figure)
    frequency_axis(axes[0])
    axes[1].set(xlabel="temperature [°C]", title="by temperature")
    ticks = np.arange(0, len(before.channels), max(1, len(before.channels) // 6))
    axes[2].set_xticks(ticks, [before.channels[k] for k in ticks])
    axes[2].set(xlabel="channel", title="by channel")
    for each in axes:
        each.axhline(0.0, color="0.3", lw=0.8)
    return figure


def candidates(record: Record) -> Figure:
    """Evidence of each effect alone, fitted where that was worth it, else to first order."""
    ranked = sorted(record["candidates"], key=_evidence)
    rows = [row for row in ranked if _evidence(row) >= 1.0][-CANDIDATES_SHOWN:] or ranked[-3:]
    named = {effect["name"] for effect in record["effects"]}
    alike = {name for effect in record["effects"] for name in effect["equivalent"]}
    figure, axes = panels(1, 1, width=9.0, height=1.2 + 0.3 * len(rows))
    for place, row in enumerate(rows):
        value = max(_evidence(row), 0.0)
        name = row["name"]
        color = AFTER if name in named else ALIKE if name in alike else OTHER
        full = row["log_evidence_fitted"] is not None
        axes.barh(place, value, color=color, fill=full, edgecolor=color, height=0.72)
        words = f" {value:,.0f}"
        if row["share"] is not None:
            words += f", explains {100 * row['share']:.1f} %"
        axes.annotate(words, (value, place), va="center", fontsize=8.5)
    axes.set_yticks(range(len(rows)), [row["name"] for row in rows])
    axes.set_xscale("symlog", linthresh=10.0)
    axes.set_xlim(0.0, 30.0 * max([10.0, *(_evidence(row) for row in rows)]))
    axes.grid(visible=False, axis="y")
    axes.axvline(LEAST_GAIN, color="0.4", lw=0.9, ls=":")
    axes.set(xlabel="log evidence over the plain twin [nats]; dotted: what an effect must bring at least")
    handles = [
        Patch(color=AFTER, label="named" if record["verdict"] != "unknown" else "hint"),
        Patch(color=ALIKE, label="cannot be distinguished from it"),
        Patch(color=OTHER, label="other, fitted"),
        Patch(fill=False, edgecolor=OTHER, label="to first order only"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    axes.set_title("each effect alone")
    return figure


def laws(figures: GapFigures) -> Figure:
    """E, nu and eta before and after, and what the correction changes, with two-sigma bands."""
    before, after = figures.laws_before, figures.laws_after
    if before.sheet is not None and after.sheet is not None:
        return _sheet_laws(before.temperature, before.sheet, after.sheet)
    figure, axes = panels(2, 3, width=10.5, height=5.0, sharex=True, height_ratios=[1.4, 1.0])
    parts = (
        ("Young's modulus", "E [GPa]", "change of E [%]", 1e-9),
        ("Poisson's ratio", "ν", "change of ν", None),
        ("loss factor", "η [%]", "change of η [%]", 100.0),
    )
    for column, (title, label, change, unit) in enumerate(parts):
        upper, lower = axes[:, column]
        for found, color, name, style in ((before, BEFORE, "before", "--"), (after, AFTER, "after", "-")):
            curve = found.value[:, column] if unit is None else unit * np.exp(found.value[:, column])
            upper.plot(found.temperature, curve, style, color=color, label=name, marker=".")
        _change(lower, before, after, column, relative=unit is not None)
        upper.set(title=title, ylabel=label)
        lower.set(xlabel="temperature [°C]", ylabel=change)
    legend_below(figure)
    return figure


def _sheet_laws(temperature: NDArray[np.float64], before: SheetMaterial, after: SheetMaterial) -> Figure:
    """Draw moduli and Poisson's ratio of an orthotropic sheet before and after, and the change in per cent."""
    chosen = CONSTANTS[:4]
    figure, axes = panels(2, len(chosen), width=12.5, height=5.0, sharex=True, height_ratios=[1.4, 1.0])
    for one, (upper, lower) in zip(chosen, axes.T, strict=True):
        first, last = (getattr(sheet.value, one.name) for sheet in (before, after))
        for curve, color, name, style in ((first, BEFORE, "before", "--"), (last, AFTER, "after", "-")):
            upper.plot(temperature, curve / one.scale, style, color=color, label=name, marker=".")
        moved, sigma = 100.0 * (last - first) / first, 100.0 * getattr(after.sigma, one.name) / first
        lower.axhline(0.0, color=BEFORE, lw=1.0, ls="--")
        lower.plot(temperature, moved, color=AFTER, marker=".")
        lower.fill_between(temperature, moved - 2 * sigma, moved + 2 * sigma, color=AFTER, alpha=0.25, lw=0)
        upper.set(title=one.title, ylabel=one.label)
        lower.set(xlabel="temperature [°C]", ylabel=f"change of {one.symbol} [%]")
    legend_below(figure)
    return figure


def _change(axes: Axes, before: FittedLaws, after: FittedLaws, law: int, relative: bool) -> None:
    """Draw what moved, in per cent or as it is; the band is two sigma of the law after."""
    moved, sigma = after.value[:, law] - before.value[:, law], after.sigma[:, law]
    if relative:
        moved, sigma = 100.0 * np.expm1(moved), 100.0 * sigma
    axes.axhline(0.0, color=BEFORE, lw=1.0, ls="--")
    axes.plot(after.temperature, moved, color=AFTER, marker=".")
    axes.fill_between(after.temperature, moved - 2 * sigma, moved + 2 * sigma, color=AFTER, alpha=0.25, lw=0)


def _grouped(
    temperature: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    groups = TemperatureGroups.of(temperature)
    return groups.reference, groups.total(values)


def _edges(centers: NDArray[np.float64]) -> NDArray[np.float64]:
    if len(centers) == 1:
        return np.array([centers[0] - 0.5, centers[0] + 0.5])
    middle = 0.5 * (centers[1:] + centers[:-1])
    return np.concatenate([[2 * centers[0] - middle[0]], middle, [2 * centers[-1] - middle[-1]]])


def _evidence(row: Record) -> float:
    fitted = row["log_evidence_fitted"]
    return float(row["log_evidence_screened"] if fitted is None else fitted)
