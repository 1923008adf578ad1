"""Plot of a trial: confusion matrix, reliability of probabilities, closure of gaps."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from app.blind_trial.assignments import KINDS
from app.blind_trial.outcome import TrialOutcome
from app.blind_trial.proof import claims, closures, proportion_interval, reliability
from app.report.style import BAND, MODEL, panels

ENDS = ("none", "unknown", "several", "refused")
"""Columns beside the effects' own."""


def proof_figure(outcomes: Sequence[TrialOutcome]) -> Figure:
    """Draw the confusion matrix, the reliability of the stated probability and the closure of gaps."""
    figure, axes = panels(1, 3, width=15.0, height=7.0, width_ratios=[2.2, 1.0, 1.0])
    _confusion(axes[0], outcomes)
    _reliability(axes[1], outcomes)
    _closure(axes[2], outcomes)
    return figure


def confusion(outcomes: Sequence[TrialOutcome]) -> tuple[list[str], list[str], np.ndarray]:
    """Row labels (hidden), column labels (verdict) and counts; without pairs, which have two names."""
    some = [o for o in outcomes if o.kind != "pair"]
    kinds = {_hidden(o): KINDS.index(o.kind) for o in some}
    rows = sorted(kinds, key=lambda row: (kinds[row], row))
    named = {o.named[0].name for o in some if len(o.named) == 1}
    columns = [
        *sorted(named | {row for row in rows if any(_hidden(o) == row and o.kind == "single" for o in some)})
    ]
    columns = [*columns, *ENDS]
    counts = np.zeros((len(rows), len(columns)), dtype=int)
    for o in some:
        counts[rows.index(_hidden(o)), columns.index(_answer(o))] += 1
    return rows, columns, counts


def _hidden(o: TrialOutcome) -> str:
    name = next(iter(o.effects), "nothing")
    return {"ablated": f"{name}, without it", "outside": f"{name} (no effect)"}.get(o.kind, name)


def _answer(o: TrialOutcome) -> str:
    if len(o.named) == 1:
        return o.named[0].name
    return "several" if o.named else o.verdict


def _confusion(axes: Axes, outcomes: Sequence[TrialOutcome]) -> None:
    rows, columns, counts = confusion(outcomes)
    share = counts / np.maximum(counts.sum(1, keepdims=True), 1)
    axes.imshow(share, cmap="GnBu", vmin=0.0, vmax=1.3, aspect="auto")
    for (row, column), count in np.ndenumerate(counts):
        if count:
            axes.text(column, row, f"{count}", ha="center", va="center", fontsize=8)
    axes.set_xticks(range(len(columns)), columns, rotation=60, ha="right", fontsize=8)
    axes.set_yticks(range(len(rows)), rows, fontsize=8)
    axes.grid(visible=False)
    axes.set_title("hidden (rows) and answered (columns), campaigns")


def _reliability(axes: Axes, outcomes: Sequence[TrialOutcome]) -> None:
    axes.plot([0.0, 1.0], [0.0, 1.0], color="0.6", lw=1.0, ls=":")
    found = claims(outcomes)
    if found:
        stated = np.array([named.probability for named, _ in found])
        seen = reliability(stated, np.array([true for _, true in found], dtype=bool))
        ends = [proportion_interval(round(t * n), int(n)) for t, n in zip(seen.true, seen.count, strict=True)]
        low, high = np.array(ends).T
        axes.errorbar(
            seen.stated, seen.true, [seen.true - low, high - seen.true], fmt="o", color=MODEL, capsize=3, ms=5
        )
        axes.set_title(f"{len(found)} effects claimed, calibration error {seen.error:.3f}")
    axes.set(xlabel="probability stated", ylabel="share that is there", xlim=(0.0, 1.02), ylim=(0.0, 1.05))


def _closure(axes: Axes, outcomes: Sequence[TrialOutcome]) -> None:
    closed = closures(outcomes)
    if closed.size:
        axes.hist(closed, bins=np.linspace(0.0, 1.0, 21).tolist(), color=BAND)
        axes.axvline(float(np.median(closed)), color=MODEL, lw=1.5, label=f"median {np.median(closed):.3f}")
        axes.legend(loc="upper left")
    axes.set(xlabel="share of the gap closed", ylabel="campaigns", xlim=(0.0, 1.0), title="held-out temperatures")
