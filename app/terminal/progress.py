"""Progress on the error stream: the output stream belongs to results."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from analysis.progress import Progress
from app.terminal.notebook import bars_in_cell, in_notebook

if TYPE_CHECKING:
    from rich.progress import TaskID


@contextmanager
def progress(*, shown: bool | None = True) -> Iterator[Progress]:
    """Yield a callable (stage, share done) that draws one bar a stage, on a terminal with the time left.

    Parameters
    ----------
    shown : bool or None
        None: in a notebook only.
    """
    if in_notebook() and shown is not False:
        with bars_in_cell() as in_cell:
            yield in_cell
        return
    if not shown:  # without loading rich
        yield lambda _stage, _share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    console = Console(stderr=True)
    columns = (TextColumn("{task.description:<24}"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Bars(*columns, console=console, disable=not console.is_terminal) as bars:
        tasks: dict[str, TaskID] = {}

        def report(stage: str, share: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=share)

        yield report
