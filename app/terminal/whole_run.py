"""A run on the screen: a line for each stage, and one table of what was found at the end."""

from collections.abc import Mapping
from pathlib import Path

from app.files.results.run_record import RunRecord, StageRecord

TABLE_COLUMNS = 110
"""Columns of the table: sentences in longer lines are hard to read."""
TO_COPY = ("report", "next")
"""What holds commands and paths: below the table, where no line of it is broken."""


def stage_line(stage: str, state: StageRecord) -> str:
    """Return the line of a stage that is done, skipped or failed."""
    if state.state == "up to date":
        return f"{stage}: up to date; {state.said}"
    if state.state != "made":
        return f"{stage}: {state.state.upper()}: {state.said}"
    return f"{stage}: {state.said} ({state.seconds:.1f} s)"


def show(record: RunRecord) -> None:
    """Print what was found, how sure it is, what to do next, and which stages have no result."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console()
    table = Table(
        title="What was found", show_header=False, show_lines=True, width=min(console.width, TABLE_COLUMNS)
    )
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for what, said in record.found:
        if what not in TO_COPY:
            table.add_row(Text(what), Text(said))
    missing = [
        f"{stage}: {one.said}" for stage, one in record.stages.items() if one.state in ("failed", "not run")
    ]
    if missing:
        table.add_row(Text("not made"), Text("\n".join(missing)))
    if table.row_count:
        console.print(table)
    for what, said in record.found:
        if what in TO_COPY:
            for line in said.splitlines():
                console.print(f"{what}: {line}", highlight=False, markup=False, soft_wrap=True)


def closing_line(states: Mapping[str, StageRecord], run: Path, seconds: float) -> str:
    """Return the last line: how many stages were made, skipped or failed.

    Parameters
    ----------
    states : mapping of str to StageRecord
        Stages of this run.
    seconds : float
        That it took.
    """
    count: dict[str, list[str]] = {}
    for stage, state in states.items():
        count.setdefault(state.state, []).append(stage)
    made = len(count.get("made", ()))
    said = [f"{made} stage{'' if made == 1 else 's'} made"] if made else []
    said += [f"{len(count['up to date'])} up to date"] if "up to date" in count else []
    said += [f"{state}: {', '.join(count[state])}" for state in ("failed", "not run") if state in count]
    poor = [stage for stage, state in states.items() if state.whole and not state.good]
    said += [f"not good enough: {', '.join(poor)}"] if poor else []
    if not said:  # only import was asked for
        return f"nothing to do, the campaign is imported already; {seconds:.1f} s; results in {run}"
    return f"{', '.join(said)}; {seconds:.1f} s; results in {run}"
