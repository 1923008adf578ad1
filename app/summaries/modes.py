"""Modes as JSON for machines, as tables for people, and as rows of words for the report and the window.

The pairing of modes as a table, from its record.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.identification.modes import NOT_ONE, Damping, Modes, PoleReading
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from app.files.results.pairing_json import shown
from app.summaries.numbers import span, sweeps
from app.summaries.table import Table

FIELDS = (
    "frequency_hz",
    "sigma_frequency_hz",
    "damping_ratio",
    "sigma_damping_ratio",
    "loss_factor",
    "sigma_loss_factor",
)


def modes_record(modes: Modes) -> dict[str, Any]:
    """Return what ``--json`` prints of one identification: modes of the plate, and poles that are none."""
    reading = modes.reading()
    found: list[dict[str, Any]] = []
    rejected: list[dict[str, Any]] = []
    for j, (status, reason, other) in enumerate(zip(modes.status, modes.reason, modes.overlapped, strict=True)):
        values: dict[str, Any] = {name: _finite(getattr(reading, name)[j]) for name in FIELDS}
        values["pole_rad_s"] = [float(modes.stated_poles[j].real), float(modes.stated_poles[j].imag)]
        values["overlaps_hz"] = float(reading.frequency_hz[other]) if other >= 0 else None
        judged = {"status": status, "confirmation": modes.confirmed_word(j) or None, "reason": reason}
        (found if modes.real[j] else rejected).append(values | judged)
    for pole in modes.rejected:
        place = {"frequency_hz": abs(pole.pole) / (2.0 * math.pi)}
        rejected.append(place | {"status": pole.status, "reason": pole.reason})
    return {
        "residual_terms": modes.terms.name,
        "misfit": modes.misfit,
        "modes": found,
        "rejected": rejected,
    }


def _finite(value: float) -> float | None:
    """Return a number that JSON can hold: None for a standard deviation that the data do not bound."""
    return float(value) if math.isfinite(value) else None


def campaign_record(tracked: TrackedModes, seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints of a campaign that took so many seconds: modes per sweep with their tracks."""
    sweeps = []
    for t, modes in enumerate(tracked.modes):
        record = modes_record(modes)
        numbers = {int(n): j + 1 for j, n in enumerate(tracked.track[t]) if n >= 0}
        real = [n for n in range(len(modes.poles)) if modes.real[n]]
        for n, mode in zip(real, record["modes"], strict=True):
            mode["track"] = numbers.get(n)
        place = {"temperature_c": float(tracked.temperature[t]), "direction": tracked.direction[t]}
        sweeps.append(place | {f"level_{tracked.level_unit.lower()}": float(tracked.level[t])} | record)
    return {"temperatures": sweeps, "notes": list(tracked.notes), "seconds": seconds}


def tables(tracked: TrackedModes) -> list[Table]:
    """Return tables of the modes of the coldest, a middle and the hottest sweep."""
    order = np.argsort(tracked.temperature, kind="stable")
    shown = sorted({int(order[0]), int(order[len(order) // 2]), int(order[-1])})
    found = []
    for number, t in enumerate(shown, 1):
        title = f"{tracked.temperature[t]:.2f} °C ({number} of {len(shown)} shown of {len(order)}; all: modes.csv)"
        found.append(mode_table(title, modes_record(tracked.modes[t])["modes"]))
    return found


def headline(tracked: TrackedModes) -> str:
    """Return sweeps, modes and the misfit in one line."""
    counts, t = [int(modes.real.sum()) for modes in tracked.modes], tracked.temperature
    return (
        f"{sweeps(len(counts))}, {span(t, 'z.1f')} °C, {span(counts, '.0f')} modes each, "
        f"misfit at most {100 * tracked.misfit.max():.2f} %"
    )


def summary(tracked: TrackedModes, seconds: float) -> str:
    """Return the line that closes an identification of `seconds` s: sweeps, modes and misfit."""
    counts = [int(modes.real.sum()) for modes in tracked.modes]
    unsure = sum(modes.confirmation.count("unconfirmed") for modes in tracked.modes)
    return (
        f"{sweeps(len(counts))}, {span(counts, '.0f')} modes each ({unsure} of {sum(counts)} unconfirmed) "
        f"in {seconds:.1f} s, misfit at most {100 * tracked.misfit.max():.2f} %"
    )


def mode_table(title: str, modes: Sequence[dict[str, Any]]) -> Table:
    """Return modes as a table."""
    headings = ("f [Hz]", "σ_f [Hz]", "ζ [%]", "σ_ζ [%]", "η [%]", "status")
    rows = tuple(
        (
            _number(mode["frequency_hz"]),
            _sigma(mode["sigma_frequency_hz"]),
            _number(mode["damping_ratio"], 100.0),
            _sigma(mode["sigma_damping_ratio"], 100.0),
            _number(mode["loss_factor"], 100.0),
            _status(mode),
        )
        for mode in modes
    )
    return Table(title, headings, rows, words=frozenset({len(headings) - 1}))


def _number(value: float | None, scale: float = 1.0) -> str:
    return "∞" if value is None else f"{scale * value:.3f}"


def _sigma(value: float | None, scale: float = 1.0) -> str:
    return "∞" if value is None else f"{scale * value:.2g}"


def _status(mode: dict[str, Any]) -> str:
    words = ", ".join(word for word in (mode["status"], mode["confirmation"]) if word)
    if words not in ("kept", "kept, confirmed"):
        words += f": {mode['reason']}"
    # what speaks for a mode that is kept stands in modes.csv; what speaks against its numbers is said here, too
    elif doubt := next((part for part in mode["reason"].split("; ") if NOT_ONE in part), ""):
        words += f"; {doubt}"
    return words if mode["overlaps_hz"] is None else f"{words}; overlaps {mode['overlaps_hz']:.1f} Hz"


SWEEP_HEADINGS = ("mode", "f [Hz]", "σ [Hz]", "ζ [%]", "σ [%]", "η [%]", "status", "why")
NUMBERS = (0, 1, 2, 3, 4, 5)
"""Columns of numbers."""
READ_AS: dict[Damping, str] = {
    "hysteretic": "Poles are read as hysteretic: f = √(Re k) / 2π and η = Im k / Re k, with k = −pole².",
    "viscous": "Poles are read as viscous: f = |pole| / 2π and η = 2ζ.",
}
"""What frequency and loss factor mean, by the choice `--damping`."""


def reading_cells(reading: PoleReading, pole: int) -> tuple[str, str, str, str]:
    """Frequency and damping ratio of a pole, each with its standard deviation, in Hz and per cent."""
    return (
        f"{reading.frequency_hz[pole]:.3f}",
        f"{reading.sigma_frequency_hz[pole]:.2g}",
        f"{100 * reading.damping_ratio[pole]:#.4g}",
        f"{100 * reading.sigma_damping_ratio[pole]:.2g}",
    )


def sweep_rows(modes: Modes, track: NDArray[np.int64]) -> list[tuple[str, ...]]:
    """Words under `SWEEP_HEADINGS` for every mode of a sweep.

    Parameters
    ----------
    track : (J,) int ndarray
        Pole of every tracked mode, -1 for none.
    """
    reading, reasons = modes.reading(), modes.explanation()
    number = {int(pole): str(j) for j, pole in enumerate(track, start=1) if pole >= 0}
    return [
        (
            number.get(j, "–"),
            *reading_cells(reading, j),
            f"{100 * reading.loss_factor[j]:#.4g}",
            modes.standing(j),
            reasons[j],
        )
        for j in shown_poles(modes)
    ]


def shown_poles(modes: Modes) -> Sequence[int]:
    """Poles that have a row in `sweep_rows`."""
    shown: list[int] = np.flatnonzero(modes.real).tolist()
    return shown


Record = Mapping[str, Any]
HEADINGS = ("measured [Hz]", "twin [Hz]", "Δf [%]", "Δf [σ]", "ζ measured/twin")
CAPTION = (
    "match: frequency within half a bandwidth (at least 1 %), residue alike; – : weak or overlapped, not counted. "
    "Δf: twin less measured, in per cent and in the measured one's σ. MAC: every channel over the rms of its FRF"
)

POINTS_CAPTION = "CoMAC: 1 where measured and computed residues of all strong pairs are in proportion"
FEW_POINTS = 5
"""Points that are listed where nothing is wrong with them: those least alike."""


def pairing_tables(record: Record | None, of: str = "") -> list[Table]:
    """Return a table of one sweep, and one with the effects found on; none without a record.

    `of` says which twin the first is of, where there are several.
    """
    if record is None:
        return []
    tables = []
    for name, words in (("sweeps", f", {of}" if of else ""), ("sweeps_after", ", with the effects found")):
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
                f"{100 * pair['difference']:+z.2f}",
                "" if pair["difference_sigma"] is None else f"{pair['difference_sigma']:+z.1f}",
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
