"""The report's section on the gap: verdict, where, what, and what it changes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from analysis.experiment import Experiment
from app.files.results.gap_file import load_gap
from app.report import gap
from app.report.page import Item, PageTable, Paragraph, Picture, VerdictBox
from app.report.pairing import pairing_items
from app.report.style import BAND, MODEL, frequency_axis, panels
from app.summaries.gap import (
    HEADINGS,
    answer_words,
    chi2_before_and_after,
    claims,
    concluded,
    description_words,
    estimate,
    gap_closed,
    held_out_parts,
    in_words,
    modes_before,
    named,
    plan_rows,
    plan_words,
    title,
    titles_of,
    told,
    verdict_words,
)
from app.summaries.modes import no_fit_words
from app.summaries.numbers import roughly

Record = Mapping[str, Any]

SHOWN = {"mass": (1e3, "g"), "stiffness": (1.0, "N/m"), "damping": (1.0, "N s/m")}
"""Factors and units of the maps."""
CURVES = {
    "load": ("apparent mass [g]", "losses as mass [g]", 1e3, 1e3),
    "modulus": ("storage modulus, change [%]", "loss factor, change [%]", 100.0, 100.0),
    "gain": ("gain, change [%]", "phase [mrad]", 100.0, 1e3),
}
"""Labels and factors of the two curves of each form."""


def description_items(record: Record) -> list[Item]:
    """Return what an unknown cause acts like; nothing without a description."""
    found = record.get("description")
    if not found:
        return []
    items: list[Item] = [Paragraph(" ".join(description_words(record)))]
    items.append(
        Picture(
            "gap-places",
            "Where on the plate is something missing?",
            maps(found),
            "Mass, stiffness and damping missing within one cell around each place, each alone, to first order; "
            "dots stand out by more than two standard deviations, the cross is the place found. Below: the usual "
            "standard deviation, and the distance from which two causes are told apart.",
        )
    )
    curves = [(form["name"], form["curve"]) for form in found["forms"] if form.get("curve")]
    chosen = [one for one in curves if one[0] == found["best"]["name"]] or curves[:1]
    if chosen:
        items.append(
            Picture(
                "gap-curve",
                "By which law, if none is given?",
                curve(*chosen[0]),
                "Values at knots over frequency with two standard deviations, fitted without a formula.",
            )
        )
    rows = [
        (one["on"], label, roughly(factor, sigma))
        for one in found["dependence"]
        for label, factor, sigma in zip(one["label"], one["factor"], one["sigma"], strict=True)
    ]
    if rows:
        items += [
            Paragraph("Its strength over that of the fit to all sweeps:"),
            PageTable(("by", "", "strength"), rows, numbers=(2,)),
        ]
    return items


def maps(found: Record) -> Figure:
    """Missing mass, stiffness and damping over the plate."""
    places = 1e3 * np.array(found["map"]["places_m"])
    figure, axes = panels(1, 3, width=10.5, height=3.6, sharex=True, sharey=True)
    best = found["best"]["parameters"]
    for each, (kind, (factor, unit)) in zip(axes, SHOWN.items(), strict=True):
        one = found["map"][kind]
        value, sigma = factor * np.array(one["value"]), factor * np.array(one["sigma"])
        top = float(np.abs(value).max()) or 1.0
        cells = each.scatter(
            *places.T, c=value, s=110, marker="s", cmap="RdBu_r", vmin=-top, vmax=top, linewidths=0
        )
        seen = np.abs(value) > 2.0 * sigma
        each.plot(*places[seen].T, ".", color="0.15", ms=4)
        if "x" in best and "y" in best:
            each.plot(1e3 * best["x"]["value"], 1e3 * best["y"]["value"], "+", color="k", ms=12, mew=1.5)
        figure.colorbar(cells, ax=each, label=f"{kind} [{unit}]", location="top", shrink=0.9)
        each.set_aspect("equal")
        each.grid(visible=False)
        each.set_xlabel(f"x [mm]; ± {np.median(sigma):.2g} {unit}, {1e3 * one['resolution_m']:.0f} mm")
    axes[0].set_ylabel("y [mm]")
    return figure


def curve(name: str, found: Record) -> Figure:
    """Two curves over frequency, with their standard deviations.

    Parameters
    ----------
    name : str
        Of the form: ``load``, ``modulus`` or ``gain``.
    found : mapping
        As in gap.json.
    """
    first, second, *factors = CURVES[name]
    figure, axes = panels(1, 2, width=9.0, height=3.0)
    parts = zip(axes, (first, second), factors, (MODEL, BAND), ("first", "second"), strict=True)
    for each, label, factor, color, key in parts:
        value, sigma = (float(factor) * np.array(found[part]) for part in (key, f"sigma_{key}"))
        each.errorbar(found["frequency_hz"], value, 2.0 * sigma, fmt="o-", color=color, ms=4, lw=1.2, capsize=2)
        each.axhline(0.0, color="0.5", lw=0.8)
        each.set_xscale("log")
        each.set_ylabel(label)
        frequency_axis(each)
    return figure


SETTLED = ("none", "explained")


def gap_section(path: Path, experiment: Experiment | None = None) -> list[Item]:
    """Read a run's gap.h5 and lay it out; of `experiment`, for the places of its points."""
    figures, record = load_gap(path)
    pairing = record.get("pairing")
    # without a gap it is the pairing of the updated twin, which has its own section
    of, pairs = modes_before(record), list[Item]()
    if record["verdict"] != "none":
        pairs = pairing_items(pairing, "gap-pairing", experiment, of)
    items: list[Item] = [verdict(record), *pairs, _agreement(record)]
    if no_fit_words(pairing):
        return items
    if record["effects"]:
        items.append(_effects(record))
    items.append(
        Picture(
            "gap-map",
            "Where do twin and data disagree?",
            gap.residual_maps(figures),
            "Residual of the twin with its material laws alone"
            + (" (left) and with what was found (right)" if gap.changes(figures) else "")
            + ", in standard deviations of the noise: white is noise.",
        )
    )
    if record["unexplained"]["share"] is not None:
        items.append(
            Picture(
                "gap-shares",
                "At which frequencies, temperatures and channels does the gap sit?",
                gap.shares(figures),
                "Excess over the noise, before and after, in shares of that before.",
            )
        )
    items.append(
        Picture(
            "gap-candidates",
            "Which effects were considered, and how strong is the evidence for each?",
            gap.candidates(record),
            "What each effect alone would explain.",
        )
    )
    if record["effects"] and record["verdict"] != "unknown":
        items.append(
            Picture(
                "gap-laws",
                "What does the correction change in the material laws?",
                gap.laws(figures),
                "E, ν and η before and after, and what changed, two-sigma bands."
                + (" Before: with the effects that the twin began with." if record["starting_effects"] else ""),
            )
        )
    unseen = [(o["name"], o["needs"]) for o in record["observability"] if not o["observable"]]
    if unseen:
        text = "Not observable with this campaign: their presence can be neither claimed nor excluded."
        items += [Paragraph(text), PageTable(("effect", "what would show it"), unseen)]
    return [*items, *description_items(record), *_plan(record)]


def _plan(record: Record) -> list[Item]:
    """Return what to measure next, where that was asked."""
    rows = plan_rows(record) if record.get("plan") else []
    answered = [Paragraph(said) for said in answer_words(record)]
    words = [Paragraph("What to measure next: " + " ".join(said))] if (said := plan_words(record)) else []
    table = [PageTable(HEADINGS, rows, numbers=(1, 3))] if rows else []
    return [*answered, *words, *table]


def verdict(record: Record) -> VerdictBox:
    """Say in words what was concluded, and on what ground."""
    before, after = record["gap"]["baseline"], record["gap"]["final"]
    titles = titles_of(record)
    found = ", ".join(named(effect, titles) for effect in record["effects"])
    sentences = []
    if record["starting_effects"]:
        sentences.append(f"The twin began with {', '.join(record['starting_effects'])} switched on.")
    if record["verdict"] == "none":
        sentences.append(
            f"With laws and gain fitted, the twin misses {100 * before['relative_misfit']:.2f} % of the "
            f"response (chi2 per degree of freedom {before['chi2_per_dof']:.3f})."
        )
        return VerdictBox(verdict_words("none").capitalize(), sentences, settled=True)
    headline = concluded(record).capitalize()
    if record["effects"]:
        headline += f" (hints: {found})" if record["verdict"] == "unknown" else f": {found}"
    share = record["unexplained"]["share"]
    misfit = [
        f"{100 * one['relative_misfit']:.2f} %" for one in ((before, after) if claims(record) else (before,))
    ]
    sentences.append(
        f"chi2 per degree of freedom {' before, after '.join(chi2_before_and_after(record))}; "
        f"misfit {' and '.join(misfit)}."
    )
    if share is not None and claims(record):
        sentences.append(f"{100 * (1.0 - share):.2f} % of the excess over the noise is gone.")
    sentences += [
        f"On data that the effects were not fitted to ({part['what']}), {gap_closed(part)} of the gap closes."
        for part in held_out_parts(record)
        if part["closure"] is not None
    ]
    sentences += [
        f"This campaign cannot distinguish {title(effect['name'], titles)} from "
        f"{' or '.join(title(other, titles) for other in effect['equivalent'])}; "
        f"what would: {told(effect['separated_by'], titles)}."
        for effect in record["effects"]
        if effect["equivalent"]
    ]
    return VerdictBox(headline, sentences, settled=record["verdict"] in SETTLED)


def _effects(record: Record) -> PageTable:
    rows = [
        (
            named(effect),
            effect["summary"],
            in_words(effect),
            "; ".join(f"{name} = {estimate(p)}" for name, p in effect["parameters"].items()),
            f"{effect['probability']:.3f}",
            f"{effect['log_evidence_gain']:,.0f}",
        )
        for effect in record["effects"]
    ]
    return PageTable(
        ("effect", "what it is", "found", "parameters", "probability", "evidence [nats]"), rows, numbers=(4, 5)
    )


def _agreement(record: Record) -> PageTable:
    found = record["gap"]
    parts = [("all records", found["baseline"], found["final"] if claims(record) else None)]
    parts += [(f"held out: {part['what']}", part["baseline"], part["final"]) for part in held_out_parts(record)]
    rows = [
        (
            name,
            f"{before['chi2_per_dof']:.4g}",
            f"{after['chi2_per_dof']:.4g}" if after else "",
            f"{100 * before['relative_misfit']:.3f} %",
            f"{100 * after['relative_misfit']:.3f} %" if after else "",
        )
        for name, before, after in parts
    ]
    if not any(after for _, _, after in parts):
        return PageTable(
            ("data", "chi2 per dof", "misfit"), [(row[0], row[1], row[3]) for row in rows], numbers=(1, 2)
        )
    headings = ("data", "chi2 per dof before", "after", "misfit before", "after")
    return PageTable(headings, rows, numbers=(1, 2, 3, 4))
