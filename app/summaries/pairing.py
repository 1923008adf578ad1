"""The pairing of modes as a table, from its record."""

from collections.abc import Mapping
from typing import Any

from app.files.results.pairing_json import shown
from app.summaries.table import Table

Record = Mapping[str, Any]
HEADINGS = ("measured [Hz]", "twin [Hz]", "Δf [%]", "Δf [σ]", "ζ measured/twin")
CAPTION = (
    "match: frequency within half a bandwidth (at least 1 %), residue alike; – : weak or overlapped, not counted. "
    "Δf: twin less measured"
)

POINTS_CAPTION = "CoMAC: 1 where measured and computed residues of all strong pairs are in proportion"
FEW_POINTS = 5
"""Points that are listed where nothing is wrong with them: those least alike."""


def pairing_tables(record: Record | None) -> list[Table]:
    """Return a table of one sweep, and one with the effects found on; none without a record."""
    if record is None:
        return []
    tables = []
    for name, words in (("sweeps", ""), ("sweeps_after", ", with the effects found")):
        if record[name] is not None:
            sweep = shown(record, name)
            headings = (*HEADINGS, likeness(sweep), "match")
            tables.append(Table(f"{title(sweep)}{words}", headings, tuple(rows(sweep)), CAPTION, whole=True))
    points = points_shown(record)
    if points is not None:
        tables.append(
            Table(
                "Points, by likeness of their motion in all modes",
                ("point", "CoMAC", ""),
                tuple(point_rows(points)),
                POINTS_CAPTION,
                words=frozenset({0, 2}),
            )
        )
    return tables


def points_shown(record: Record) -> Record | None:
    """Return the comparison of points with the effects found, or without; None where there is none."""
    found: Record | None = record.get("points_after") or record.get("points")
    return found


def point_rows(points: Record) -> list[tuple[str, str, str]]:
    """Return a row of text for every wrong point, and for those that are least alike."""
    comac, wrong = points["comac"], points["wrong"]
    least = sorted(range(len(comac)), key=lambda k: comac[k])[:FEW_POINTS]
    listed = [*sorted(wrong, key=lambda k: comac[k]), *(k for k in least if k not in wrong)]
    return [(points["names"][k], f"{comac[k]:.3f}", "not as declared" if k in wrong else "") for k in listed]


def title(sweep: Record) -> str:
    """Say what a table shows."""
    return (
        f"Modes at {sweep['temperature_c']:.1f} °C: {sweep['matched']} of {sweep['strong']} strong ones match, "
        f"misfit {100 * sweep['misfit']:.1f} %"
    )


def likeness(sweep: Record) -> str:
    """Return the heading of the column that compares shapes: MAC, or residues where there is one channel."""
    return "residues" if any(pair["mac"] is None for pair in sweep["pairs"]) else "MAC"


def rows(sweep: Record) -> list[tuple[str, ...]]:
    """Return a row of text for each pair and each mode without a partner, by frequency."""
    kind = "residues" if likeness(sweep) == "residues" else "mac"
    found = [
        (
            pair["measured_hz"],
            (
                f"{pair['measured_hz']:.1f}",
                f"{pair['computed_hz']:.1f}",
                f"{100 * pair['difference']:+.2f}",
                "" if pair["difference_sigma"] is None else f"{pair['difference_sigma']:+.1f}",
                f"{pair['damping']:.2f}",
                f"{pair[kind]:.2f}",
                "–" if not pair["strong"] else "yes" if pair["matched"] else "no",
            ),
        )
        for pair in sweep["pairs"]
    ]
    for one in sweep["measured_only"]:
        alone = (f"{one['frequency_hz']:.1f}", "none", "", "", "", "", "no" if one["strong"] else "–")
        found.append((one["frequency_hz"], alone))
    found += [
        (one["frequency_hz"], ("none", f"{one['frequency_hz']:.1f}", "", "", "", "", ""))
        for one in sweep["computed_only"]
    ]
    return [row for _, row in sorted(found, key=lambda one: one[0])]


def no_fit_words(record: Record | None) -> list[str]:
    """Return what has to be said of a twin that is no fit, and the likely reason; nothing of others."""
    if record is None or record["fit"]:
        return []
    return [word for word in (record["said"], record["likely_reason"]) if word]
