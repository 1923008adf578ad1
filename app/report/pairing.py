"""Measured modes beside those of the twin: table, figure, and the verdict where it is no fit."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from app.files.pairing_json import shown
from app.report.page import Item, PageTable, Picture, VerdictBox
from app.report.style import BAND, MODEL, frequency_axis, legend_below, panels
from app.summaries.pairing import HEADINGS, likeness, no_fit_words, rows, title

Record = Mapping[str, Any]
WIDEST = 10.0
"""Differences that are drawn, %."""


def pairing_items(record: Record | None, name: str) -> list[Item]:
    """Return what the page shows of a pairing; nothing where there is none.

    Parameters
    ----------
    record : mapping or None
        Of `app.files.pairing_json.pairing_record`.
    name : str
        Of the picture's file.
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
            pairing_figure(before, after),
            f"{title(before)}. Filled: modes that are strong in the FRFs; grey: half the window within which "
            "frequencies agree, half a bandwidth and at least 1 %; crosses at the top: modes without a partner.",
        )
    )
    headings = (*HEADINGS, likeness(before), "match")
    items.append(PageTable(headings, rows(before), numbers=tuple(range(len(headings) - 1))))
    if after is not None:
        items.append(PageTable((f"{headings[0]}, with the effects found", *headings[1:]), rows(after)))
    return items


def pairing_figure(before: Record, after: Record | None = None) -> Figure:
    """Draw differences of frequency, ratios of damping, and likeness of shapes over frequency.

    Parameters
    ----------
    before, after : mapping
        Sweeps of a pairing's record; `after` has the effects found.
    """
    figure, axes = panels(3, 1, height=6.4, sharex=True, height_ratios=[1.5, 1.0, 1.0])
    parts = [(before, MODEL, "updated twin" if after is None else "before")]
    parts += [] if after is None else [(after, BAND, "with the effects found")]
    _window(axes[0], before["pairs"])
    for sweep, color, label in parts:
        pairs = sweep["pairs"]
        f = np.array([pair["measured_hz"] for pair in pairs])
        strong = np.array([pair["strong"] for pair in pairs], dtype=bool)
        values = (
            np.clip(_column(pairs, "difference", 100.0), -WIDEST, WIDEST),
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
    axes[0].set(ylabel="Δf, twin less\nmeasured [%]", title=title(before))
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
