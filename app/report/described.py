"""What an unknown cause acts like: words, maps over the plate, its curve over frequency, its strength."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from app.report.page import Item, PageTable, Paragraph, Picture
from app.report.style import BAND, MODEL, frequency_axis, panels
from app.summaries.description import description_words
from app.summaries.with_sigma import roughly

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
