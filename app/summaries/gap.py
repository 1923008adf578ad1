"""gap.json in words: tables and sentences."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from app.summaries.effect_words import title, titles_of
from app.summaries.numbers import with_sigma
from app.summaries.pairing import no_fit_words, pairing_tables
from app.summaries.plan import plan_table
from app.summaries.table import Table

Record = Mapping[str, Any]


def summary(record: Record, run: Path) -> str:
    """Return one line: verdict, what was found, and where it stands."""
    return f"{headline(record)}; {record['seconds']:.1f} s; results in {run}"


def headline(record: Record) -> str:
    """Return verdict, effects found, and chi2 before and after, in one line."""
    titles = titles_of(record)
    found = ", ".join(named(effect, titles) for effect in record["effects"])
    words = concluded(record)
    if record["effects"]:
        words += f": {found}" if record["verdict"] != "unknown" else f" (hints: {found})"
    return f"{words}; chi2 per dof {' -> '.join(chi2_before_and_after(record))}"


def claims(record: Record) -> bool:
    """Whether effects are in the twin that is issued; else those in the record are hints."""
    return record["verdict"] in ("explained", "partly_explained")


def chi2_before_and_after(record: Record) -> list[str]:
    """Chi2 per degree of freedom without effects and, where some are claimed, with them."""
    parts = ("baseline", "final") if claims(record) else ("baseline",)
    return [f"{record['gap'][part]['chi2_per_dof']:.3g}" for part in parts]


def concluded(record: Record) -> str:
    """Return the verdict in words, or that there is no fit to judge."""
    return "unknown: this is no fit" if no_fit_words(record.get("pairing")) else verdict_words(record["verdict"])


def verdict_words(verdict: str) -> str:
    """Return a verdict in words."""
    return {
        "none": "no gap: twin and data agree to the noise",
        "explained": "gap explained",
        "partly_explained": "gap partly explained",
        "unknown": "unknown: a gap that no effect of the library explains",
    }[verdict]


def named(effect: Record, titles: Mapping[str, str] | None = None) -> str:
    """Name of an effect, with those it cannot be distinguished from; for people where `titles` are given."""
    names = [effect["name"], *effect["equivalent"]]
    return " or ".join(names if titles is None else [title(name, titles) for name in names])


def estimate(parameter: Record) -> str:
    """Value, standard deviation to two digits, and unit; the value to the same decimal."""
    return with_sigma(parameter["value"], parameter["sigma"], parameter["unit"])


def gap_closed(part: Record) -> str:
    """Return the share of a gap that closes on held-out data, with its standard deviation; empty without a gap."""
    if part["closure"] is None:
        return ""
    return with_sigma(100.0 * part["closure"], 100.0 * (part.get("closure_sigma") or 0.0), "%")


def tables(record: Record) -> list[Table]:
    """Return tables of paired modes, effects, agreement, what is left and what could not be seen."""
    pairing = record.get("pairing")
    no_fit = bool(no_fit_words(pairing))
    every = (
        *pairing_tables(pairing),
        *(() if no_fit else (_found(record),)),
        _agreement(record),
        *(() if no_fit else (_where(record), _unseen(record), plan_table(record))),
    )
    return [table for table in every if table.rows]


def _table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    return Table(title, tuple(headings), tuple(map(tuple, rows)), words=frozenset(range(len(headings))))


def _found(record: Record) -> Table:
    title = "Hints, nothing claimed" if record["verdict"] == "unknown" else "What the twin lacked"
    headings = ["effect", "parameters", "probability", "evidence [nats]"]
    alike = any(effect["equivalent"] for effect in record["effects"])
    rows = []
    for effect in record["effects"]:
        values = "\n".join(f"{name} {estimate(p)}" for name, p in effect["parameters"].items())
        cells = [named(effect), values, f"{effect['probability']:.3f}", f"{effect['log_evidence_gain']:.0f}"]
        rows.append([*cells, *([effect["separated_by"] if effect["equivalent"] else ""] if alike else [])])
    return _table(title, [*headings, *(["distinguished by"] if alike else [])], rows)


def held_out_parts(record: Record) -> list[Record]:
    """Return what effects were tried on besides the data they were fitted to; nothing where none was fitted."""
    gap = record["gap"]
    return [gap["held_out"], *gap.get("held_out_also", ())] if record["effects"] else []


def _agreement(record: Record) -> Table:
    found, gap = bool(record["effects"]), record["gap"]
    parts = [("all", gap["baseline"], gap["final"] if claims(record) else None, "")]
    parts += [
        (f"held out: {part['what']}", part["baseline"], part["final"], gap_closed(part))
        for part in held_out_parts(record)
    ]
    rows = [
        (
            data,
            f"{before['chi2_per_dof']:.4g}",
            f"-> {after['chi2_per_dof']:.4g}" if after else "",
            f"{100 * before['relative_misfit']:.2f} %",
            f"-> {100 * after['relative_misfit']:.2f} %" if after else "",
            closed,
        )
        for data, before, after, closed in parts
    ]
    title = "Before and after" if found else "Twin and data"
    return _table(title, ("data", "chi2 per dof", "", "misfit", "", "gap closed"), rows)


def _where(record: Record) -> Table:
    open_ = record["verdict"] in ("partly_explained", "unknown")
    rows = [
        (
            region["channel"],
            "{:.0f} to {:.0f}".format(*region["frequency_hz"]),
            "{:.0f} to {:.0f}".format(*region["temperature_c"]),
            f"{100 * region['share']:.0f} %",
        )
        for region in (record["unexplained"]["where"][:5] if open_ else [])
    ]
    return _table("What is left", ("channel", "frequency [Hz]", "temperature [°C]", "share of it"), rows)


def _unseen(record: Record) -> Table:
    title = "Not observable with this campaign: neither claimed nor excluded"
    rows = [(entry["name"], entry["needs"]) for entry in record["observability"] if not entry["observable"]]
    return _table(title, ("effect", "what would show it"), rows)
