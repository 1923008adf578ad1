"""Progress on the error stream: the output stream belongs to results."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from importlib import import_module
from typing import TYPE_CHECKING

from analysis.progress import Progress

if TYPE_CHECKING:
    from rich.progress import TaskID


BAR_INTERVAL = 0.2
"""Seconds between two changes of a progress bar."""


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    python = sys.modules.get("IPython")
    shell = python.get_ipython() if python is not None else None
    return shell is not None and hasattr(shell, "kernel")


@contextmanager
def bars_in_cell() -> Iterator[Progress]:
    """Yield a callable (stage, share done) that draws a bar for each stage below the cell; they go at the end.

    By the notebook's own display; the widgets of other progress bars are a package of their own.
    """
    display = import_module("IPython.display")
    shares: dict[str, float] = {}
    handle = display.display(display.HTML(""), display_id=True)
    last = 0.0

    def report(stage: str, share: float) -> None:
        nonlocal last
        shares[stage] = share
        if time.monotonic() - last >= BAR_INTERVAL:
            last = time.monotonic()
            bars = [f"<progress value={value:.3f}></progress> {escape(name)}" for name, value in shares.items()]
            handle.update(display.HTML("<br>".join(bars)))

    try:
        yield report
    finally:
        handle.update(display.HTML(""))


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
