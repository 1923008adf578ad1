"""The table of the fault campaign: what the slow test of every fault at every moment has observed."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

TITLE = """\
# What faults do to a campaign

Each fault occurs in a simulated campaign of five sweeps of two repeats, at five moments: in, or 7 s after, its
first, second, fourth, sixth and eighth repeat. `tests/drivers/rig/test_faults.py` measures the consequences; this
page is written by

    python3 start.py tests -m slow tests/drivers/rig/test_faults.py --fault-table docs/faults.md

*Fault at* is the plate's temperature at those moments. *End of the run*: how the campaign ended by itself, and how
many sweeps were given up. *Identical* counts the sweeps finished by then that are the same, bit by bit, after the
campaign was resumed on a rig without fault. *H1 error* is the largest error of any sweep kept, as a share of the
peak of the simulated plate's FRF. *Output* and *oven* are the state of the simulated hardware after the run: a
card or an oven without connection cannot be brought to rest; this is then *reported* to the user, with what to do.
*Resumed*: the state after the campaign was resumed. `flexura acquire --again` repeats sweeps that were given up.
"""
HEADINGS = ("fault", "fault at [°C]", "end of the run", "identical", "H1 error [%]", "output", "oven", "resumed")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Offer the table as a file; known where this folder is named on the command line."""
    parser.addoption("--fault-table", metavar="FILE", help="write the table of the fault campaign to FILE")


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Print the table, where the fault campaign has been run, failed cases included."""
    ended = [*terminalreporter.stats.get("passed", ()), *terminalreporter.stats.get("failed", ())]
    rows = [dict(report.user_properties).get("observed") for report in ended]
    lines = fault_table([row for row in rows if row is not None])
    if lines:
        terminalreporter.section("fault campaign")
        terminalreporter.write_line("\n".join(lines))
        file = config.getoption("--fault-table", None)
        if file:
            Path(file).write_text(TITLE + "\n".join(lines) + "\n", encoding="utf-8")


def fault_table(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Markdown tables, one a group, one line a fault: what was observed at all its moments."""
    lines: list[str] = []
    for group in dict.fromkeys(row["group"] for row in rows):
        of_group = [row for row in rows if row["group"] == group]
        faults = dict.fromkeys(row["fault"] for row in of_group)
        lines += ["", f"## {group}: {len(faults)} faults, {len(of_group)} runs", ""]
        lines += ["| " + " | ".join(HEADINGS) + " |", "|---" * len(HEADINGS) + "|"]
        for fault in faults:
            cells = fault_row([row for row in of_group if row["fault"] == fault])
            lines.append("| " + " | ".join((fault, *cells)) + " |")
    return lines


def fault_row(seen: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Sum up what one fault did at its moments."""

    def counted(answers: Sequence[str]) -> str:
        number = {answer: answers.count(answer) for answer in dict.fromkeys(answers)}
        return "; ".join(answer if len(number) == 1 else f"{times} × {answer}" for answer, times in number.items())

    def missing(count: int) -> str:
        return "complete" if count == 0 else f"{count} given up"

    reported = ["reported" if row["unsafe"] else "NOT REPORTED" for row in seen]
    return (
        ", ".join("never" if row["struck"] is None else f"{row['struck']:.1f}" for row in seen),
        counted([f"stopped: {row['error']}" if row["error"] else missing(row["missing"]) for row in seen]),
        f"{sum(row['intact'] for row in seen)} of {sum(row['finished'] for row in seen)}",
        f"{100 * max(max(row['h1_error'], row['h1_error_after']) for row in seen):.2f}",
        counted(
            [
                "0 V" if row["volts"] == 0.0 else f"{row['volts']:.2f} V, {why}"
                for row, why in zip(seen, reported, strict=True)
            ]
        ),
        counted(
            [f"on, {why}" if row["regulating"] else "at rest" for row, why in zip(seen, reported, strict=True)]
        ),
        counted([missing(row["missing_after"]) for row in seen]),
    )
