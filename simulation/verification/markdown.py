"""Comparisons as Markdown: one table over all cases, and one for every case."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from simulation.verification.case import Case
from simulation.verification.report import CaseComparison


def summary(comparisons: Sequence[CaseComparison]) -> str:
    """Table with a row for every case: its largest error, what is allowed, and the order of convergence."""
    lines = [
        "| case | compared with | modes | largest error | allowed | order | |",
        "|---|---|---|---|---|---|---|",
    ]
    for done in comparisons:
        case = done.case
        verdict = "met" if done.passed else "**missed**"
        lines.append(
            f"| [{case.title}](#{anchor(case.title)}) | {case.kind} | {case.reference.size} "
            f"| {percent(done.worst)} | {percent(case.tolerance)} | {exponent(done.order)} | {verdict} |"
        )
    return "\n".join(lines) + "\n"


def section(comparison: CaseComparison, pictures: Mapping[str, str] | None = None) -> str:
    """One case: what it is compared with, its table of modes, its pictures.

    Parameters
    ----------
    pictures : mapping from caption to path
    """
    case = comparison.case
    lines = [f"### {case.title}", ""]
    lines += [f"Reference: {case.source}.", ""]
    for caption, path in (pictures or {}).items():
        lines += [f"![{caption}]({path})", ""]
    return "\n".join(lines) + "\n" + modes(comparison)


def modes(comparison: CaseComparison) -> str:
    """Table with a row for every mode of a case, in the unit its reference is known in."""
    case = comparison.case
    unit = "Hz" if case.length is None else "ω a² √(ρh/D)"
    published = [*case.published, *[float("nan")] * (case.reference.size - len(case.published))]
    beside = bool(case.published)
    head = ["mode", f"computed, {unit}", "reference", "error", "order", *(["published"] if beside else [])]
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for number, (row, other) in enumerate(zip(comparison.rows, published, strict=True), start=1):
        cells = [
            f"{number}",
            f"{row.computed / case.unit:.6g}",
            f"{row.reference / case.unit:.6g}",
            percent(row.error, signed=True),
            exponent(row.order),
        ]
        if beside:
            cells.append("" if np.isnan(other) else f"{other:g}")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def left_out(cases: Sequence[Case], reasons: Mapping[str, str]) -> str:
    """List of the cases that were not computed, by reason; empty where there are none."""
    lines = []
    for why in dict.fromkeys(reasons.values()):
        titles = [case.title for case in cases if reasons.get(case.name) == why]
        lines += [f"Not computed ({why}):", "", *(f"- {title}" for title in titles), ""]
    return "\n".join(lines)


def anchor(heading: str) -> str:
    """Return what a link to a heading of the same page is called."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-")


def percent(share: float, *, signed: bool = False) -> str:
    """Return a relative error in percent with two digits."""
    value = 100.0 * share
    text = np.format_float_positional(abs(value), precision=2, fractional=False, unique=False, trim="-")
    if abs(value) < 1e-7:
        return "0 %"
    return f"{'-' if value < 0 else '+' if signed else ''}{text} %"


def exponent(order: float) -> str:
    """Return an order of convergence with one decimal; a dash where there is none."""
    return "–" if np.isnan(order) else f"{order:.1f}"
