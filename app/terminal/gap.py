"""gap.json in words: tables on the screen, and sentences for the report."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from app.terminal.effect_words import title, titles_of
from app.terminal.pairing import no_fit_words, pairing_tables
from app.terminal.plan import plan_table
from app.terminal.with_sigma import with_sigma

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


def show(record: Record, words: Sequence[str]) -> None:
    """Print the tables, and below them, where the eye is when the verb ends, the result in words."""
    from rich.console import Console

    console = Console()
    for table in tables(record):
        console.print(table)
    for line in words:
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def tables(record: Record) -> list[Any]:
    """Return paired modes, effects, agreement, what is left and what could not be seen, as tables of rich."""
    pairing = record.get("pairing")
    pairs = () if pairing is None else pairing_tables(pairing)
    no_fit = bool(no_fit_words(pairing))
    every = (
        *pairs,
        *(() if no_fit else (_found(record),)),
        _agreement(record),
        *(() if no_fit else (_where(record), _unseen(record), plan_table(record))),
    )
    return [table for table in every if table.row_count]


def _table(title: str, *headings: str) -> Any:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=title, title_justify="left", header_style="bold", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in headings:
        table.add_column(heading, overflow="fold")
    return table


def _found(record: Record) -> Any:
    title = "Hints, nothing claimed" if record["verdict"] == "unknown" else "What the twin lacked"
    table = _table(title, "effect", "parameters", "probability", "evidence [nats]")
    if any(effect["equivalent"] for effect in record["effects"]):
        table.add_column("distinguished by", overflow="fold")
    for effect in record["effects"]:
        values = "\n".join(f"{name} {estimate(p)}" for name, p in effect["parameters"].items())
        cells = [named(effect), values, f"{effect['probability']:.3f}", f"{effect['log_evidence_gain']:.0f}"]
        table.add_row(*cells, *([effect["separated_by"]] if effect["equivalent"] else []))
    return table


def held_out_parts(record: Record) -> list[Record]:
    """Return what effects were tried on besides the data they were fitted to; nothing where none was fitted."""
    gap = record["gap"]
    return [gap["held_out"], *gap.get("held_out_also", ())] if record["effects"] else []


def _agreement(record: Record) -> Any:
    found = bool(record["effects"])
    table = _table(
        "Before and after" if found else "Twin and data", "data", "chi2 per dof", "", "misfit", "", "gap closed"
    )
    gap = record["gap"]
    rows = [("all", gap["baseline"], gap["final"] if claims(record) else None, "")]
    rows += [
        (f"held out: {part['what']}", part["baseline"], part["final"], gap_closed(part))
        for part in held_out_parts(record)
    ]
    for data, before, after, closed in rows:
        table.add_row(
            data,
            f"{before['chi2_per_dof']:.4g}",
            f"-> {after['chi2_per_dof']:.4g}" if after else "",
            f"{100 * before['relative_misfit']:.2f} %",
            f"-> {100 * after['relative_misfit']:.2f} %" if after else "",
            closed,
        )
    return table


def _where(record: Record) -> Any:
    table = _table("What is left", "channel", "frequency [Hz]", "temperature [°C]", "share of it")
    open_ = record["verdict"] in ("partly_explained", "unknown")
    for region in record["unexplained"]["where"][:5] if open_ else []:
        table.add_row(
            region["channel"],
            "{:.0f} to {:.0f}".format(*region["frequency_hz"]),
            "{:.0f} to {:.0f}".format(*region["temperature_c"]),
            f"{100 * region['share']:.0f} %",
        )
    return table


def _unseen(record: Record) -> Any:
    table = _table(
        "Not observable with this campaign: neither claimed nor excluded", "effect", "what would show it"
    )
    for entry in record["observability"]:
        if not entry["observable"]:
            table.add_row(entry["name"], entry["needs"])
    return table
