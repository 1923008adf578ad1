"""The plan of the next experiment in words: a table of measurements, and the one to make."""

from collections.abc import Mapping
from typing import Any

from app.summaries.effect_words import title, titles_of
from app.summaries.table import Table

Record = Mapping[str, Any]
NOTHING = "nothing"
"""Name in ``gap.json`` of the answer that it was none of the effects."""
MEASUREMENTS_SHOWN = 6
"""Measurements in the table, the best first."""


def question_words(question: Record, titles: Mapping[str, str]) -> str:
    """Say what is open: ``draught or thickness taper``, or ``thermal lag: there or not``."""
    name = title(question["effect"], titles)
    return (
        f"{name}: there or not" if question["rival"] is None else f"{name} or {title(question['rival'], titles)}"
    )


def plan_rows(record: Record) -> list[tuple[str, str, str, str]]:
    """Return rows of measurement, hours, questions settled, and separation gained per hour, the best first."""
    plan, titles = record["plan"], titles_of(record)
    rows = []
    for one in plan["measurements"][:MEASUREMENTS_SHOWN]:
        settled = "; ".join(question_words(plan["questions"][k], titles) for k in one["settles"])
        settled = settled or f"none (+{one['gain_sigma']:.1f} sigma)"
        rows.append((one["words"], f"{one['hours']:.1f}", settled, f"{one['gain_per_hour']:.1f}"))
    return rows


HEADINGS = ("measurement", "hours", "would settle", "sigma per hour")


def plan_table(record: Record) -> Table:
    """Return the table of measurements; without rows where there is no plan."""
    rows = tuple(map(tuple, plan_rows(record) if record.get("plan") else ()))
    return Table("What to measure next", HEADINGS, rows, words=frozenset(range(len(HEADINGS))))


def plan_words(record: Record) -> list[str]:
    """Say what is to be measured next, and why; an empty list where there is no plan."""
    plan = record.get("plan")
    if not plan:
        return []
    if not plan["questions"]:
        return ["Nothing is open that another measurement could settle."]
    chosen = plan["next"]
    if chosen is None:
        return ["None of the measurements that were simulated would settle what is open."]
    titles = titles_of(record)
    best = plan["measurements"][0]
    said = [f"{chosen['words']} ({chosen['hours']:.1f} h)"]
    for k in best["settles"]:
        question = plan["questions"][k]
        before, after = question["separation_sigma"], best["separation_sigma"][k]
        said.append(
            f"It would settle {question_words(question, titles)}: {after:.0f} sigma apart, {before:.1f} now."
        )
    if not best["settles"]:
        said.append(f"It settles nothing alone, and adds {best['gain_sigma']:.1f} sigma.")
    if chosen["experiment"]:
        said.append(f"Its experiment: {chosen['experiment']}.")
    if chosen["to_complete"]:
        said.append(chosen["to_complete"])
    return said


def answer_words(record: Record) -> list[str]:
    """Say what both campaigns settle of an earlier plan's questions; an empty list where none was named."""
    found = record.get("answer")
    if not found:
        return []
    titles = titles_of(record)
    others = sorted(found["relative_nats"].items(), key=lambda pair: -pair[1])
    best, second = others[0], others[1] if len(others) > 1 else None
    name = _or_nothing(best[0], titles)
    if second is None:
        return [f"Both campaigns together: {name}."]
    behind = f"{_or_nothing(second[0], titles)} is {-second[1]:.0f} nats behind"
    if found["settled"] is None:
        return [f"Both campaigns together do not settle it: {name}, and {behind}."]
    return [f"Both campaigns together settle it: {name}; {behind}."]


def _or_nothing(name: str, titles: Mapping[str, str]) -> str:
    return "none of them" if name == NOTHING else title(name, titles)
