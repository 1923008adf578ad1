"""Measured modes beside those of the twin: table, figure, and the verdict where it is no fit."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from analysis.experiment import Experiment, Plate
from app.files.results.pairing_json import shown
from app.report.page import Item, PageTable, Picture, VerdictBox
from app.report.style import BAND, MODEL, frequency_axis, legend_below, panels
from app.summaries.modes import HEADINGS, likeness, no_fit_words, point_rows, points_shown, rows, title

Record = Mapping[str, Any]
LARGEST_DIFFERENCE_DRAWN = 10.0
"""Differences that are drawn, %."""
PLATES_DRAWN = 6
"""Plates drawn, one of them for the CoMAC."""


def pairing_items(
    record: Record | None, name: str, experiment: Experiment | None = None, of: str = ""
) -> list[Item]:
    """Return what the page shows of a pairing; nothing where there is none.

    Parameters
    ----------
    record : mapping or None
        Of `app.files.results.pairing_json.pairing_record`.
    name : str
        Of the picture's file.
    experiment : Experiment, optional
        Where the points lie; without it shapes are not drawn.
    of : str
        Which twin it is before effects were found, where that is not the only one of the page.
    """
    if record is None:
        return []
    items: list[Item] = []
    if words := no_fit_words(record):
        items.append(VerdictBox("This is no fit", words, settled=False))
    before, after = shown(record), None
    if record["sweeps_after"] is not None:
        after = shown(record, "sweeps_after")
    items.append(
        Picture(
            name,
            "Which measured modes does the twin have?",
            pairing_figure(before, after, of),
            f"{title(before)}{_of(of)}. Filled: modes that are strong in the FRFs; grey: half the window within "
            "which frequencies agree, half a bandwidth and at least 1 %; crosses at the top: modes without a "
            "partner.",
        )
    )
    headings = (*HEADINGS, likeness(before), "match")
    first = (f"{headings[0]}{_of(of)}", *headings[1:])
    items.append(PageTable(first, rows(before), numbers=tuple(range(len(headings) - 1))))
    if after is not None:
        items.append(PageTable((f"{headings[0]}, with the effects found", *headings[1:]), rows(after)))
    points = points_shown(record)
    if points is not None:
        items += _points(points, name, experiment)
    return items


def _points(points: Record, name: str, experiment: Experiment | None) -> list[Item]:
    """Return what is wrong with points, their CoMAC, and the shapes on the plate."""
    items: list[Item] = []
    if points["said"]:
        items.append(VerdictBox("Points that are not as declared", points["said"], settled=False))
    places = {} if experiment is None else places_of(experiment)
    if experiment is not None and set(points["names"]) & set(places):
        items.append(
            Picture(
                f"{name}-points",
                "Where do measured and computed shapes differ?",
                points_figure(points, experiment.plate, places),
                "Measured less computed motion at every point, in shares of the shape's largest, of the modes "
                "that differ most; at the right below the CoMAC of every point. Rings: points that are not as "
                "declared.",
            )
        )
    items.append(PageTable(("point", "CoMAC", ""), point_rows(points), numbers=(1,)))
    return items


def places_of(experiment: Experiment) -> dict[str, tuple[float, float]]:
    """Return where each motion is measured, m, by the name of the channel."""
    return {one.id: one.footprint.point for one in experiment.outputs if one.footprint is not None}


def points_figure(points: Record, plate: Plate, places: Mapping[str, tuple[float, float]]) -> Figure:
    """Draw shapes' differences and the CoMAC at the points of the plate.

    Parameters
    ----------
    points : mapping
        Of a pairing's record.
    plate : Plate
        For its outline.
    places : mapping of str to (float, float)
        By the name of the point, m.

    Returns
    -------
    Figure
    """
    here = [k for k, name in enumerate(points["names"]) if name in places]
    at = np.array([places[points["names"][k]] for k in here])
    away = np.array(points["measured"], float)[:, here] - np.array(points["computed"], float)[:, here]
    modes = np.sort(np.argsort(-np.abs(away).max(axis=1), kind="stable")[: PLATES_DRAWN - 1])
    top = max(float(np.quantile(np.abs(away[modes]), 0.98)), 0.05)
    figure, axes = panels(2, PLATES_DRAWN // 2, width=10.5, height=5.6, squeeze=False)
    flat, size = axes.ravel(), float(np.clip(900.0 / len(here), 8.0, 90.0))
    for place, mode in zip(flat, modes, strict=False):
        drawn = place.scatter(*at.T, c=away[mode], s=size, cmap="RdBu_r", vmin=-top, vmax=top)
        place.set_title(f"{points['frequency_hz'][mode]:.1f} Hz", fontsize=9)
    for place in flat[len(modes) : -1]:
        place.set_visible(False)
    figure.colorbar(drawn, ax=list(flat), label="measured less computed", shrink=0.7)
    last = flat[-1].scatter(*at.T, c=np.array(points["comac"], float)[here], s=size, vmin=0.0, vmax=1.0)
    flat[-1].set_title("CoMAC", fontsize=9)
    figure.colorbar(last, ax=list(flat), label="CoMAC", shrink=0.7)
    wrong = [k for k, one in enumerate(here) if one in points["wrong"]]
    for place in (*flat[: len(modes)], flat[-1]):
        for loop in (plate.loop, *plate.hole_loops):
            place.add_patch(Polygon(loop.polygon, fill=False, lw=1.2, ec="0.3"))
        place.plot(*at[wrong].T, "o", mfc="none", mec="k", ms=1.6 * size**0.5, label="not as declared")
        place.set(aspect="equal", xticks=[], yticks=[])
        place.grid(visible=False)
        place.margins(0.05)
    return figure


def _of(twin: str) -> str:
    return f", {twin}" if twin else ""


def pairing_figure(before: Record, after: Record | None = None, of: str = "") -> Figure:
    """Draw differences of frequency, ratios of damping, and likeness of shapes over frequency.

    Parameters
    ----------
    before, after : mapping
        Sweeps of a pairing's record; `after` has the effects found.
    of : str
        Which twin `before` is of, where there are several.
    """
    figure, axes = panels(3, 1, height=6.4, sharex=True, height_ratios=[1.5, 1.0, 1.0])
    parts = [(before, MODEL, of or ("updated twin" if after is None else "before"))]
    parts += [] if after is None else [(after, BAND, "with the effects found")]
    _window(axes[0], before["pairs"])
    for sweep, color, label in parts:
        pairs = sweep["pairs"]
        f = np.array([pair["measured_hz"] for pair in pairs])
        strong = np.array([pair["strong"] for pair in pairs], dtype=bool)
        values = (
            np.clip(_column(pairs, "difference", 100.0), -LARGEST_DIFFERENCE_DRAWN, LARGEST_DIFFERENCE_DRAWN),
            _column(pairs, "damping"),
            _column(pairs, "residues" if likeness(sweep) == "residues" else "mac"),
        )
        for each, value in zip(axes, values, strict=True):
            each.plot(f[strong], value[strong], "o", color=color, ms=5, label=label)
            each.plot(f[~strong], value[~strong], "o", mfc="none", color=color, ms=4)
    top = axes[0].get_ylim()[1]
    for alone, mark, label in (("measured_only", "x", "measured only"), ("computed_only", "+", "twin only")):
        lonely = [one["frequency_hz"] for one in before[alone]]
        if lonely:
            axes[0].plot(lonely, np.full(len(lonely), top), mark, color="0.3", ms=7, label=label, clip_on=False)
    axes[0].axhline(0.0, color="0.3", lw=0.8)
    axes[1].axhline(1.0, color="0.3", lw=0.8)
    axes[0].set(ylabel="Δf, twin less\nmeasured [%]", title=f"{title(before)}{_of(of)}")
    axes[1].set(ylabel="ζ measured\nover twin", ylim=(0.0, None))
    axes[2].set(ylabel=likeness(before), ylim=(min(-0.05, axes[2].get_ylim()[0]), 1.05))
    frequency_axis(axes[2])
    legend_below(figure, axes[0])
    return figure


def _window(axes: Any, pairs: Sequence[Record]) -> None:
    """Shade where frequencies agree."""
    f = np.array([pair["measured_hz"] for pair in pairs])
    half = 50.0 * np.array([pair["window"] for pair in pairs])
    if len(f) > 1:
        axes.fill_between(f, -half, half, color="0.9", lw=0, zorder=0)


def _column(pairs: Sequence[Record], name: str, scale: float = 1.0) -> Any:
    return scale * np.array([pair[name] for pair in pairs], dtype=float)
