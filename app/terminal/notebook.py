"""Tables and progress as a notebook shows them."""

import io
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from importlib import import_module
from typing import Any

from analysis.progress import Progress

FORM = '<pre style="white-space:pre;overflow-x:auto;line-height:normal"><code>{code}</code></pre>'
EVERY = 0.2
"""Seconds between two changes of a progress bar."""


def as_html(headline: str, tables: Iterable[Any], notes: Sequence[str] = ()) -> str:
    """Return a line, tables of rich and notes as HTML.

    Parameters
    ----------
    headline : str
    tables : iterable of rich.table.Table
    notes : sequence of str
        A paragraph each.

    Returns
    -------
    str
    """
    from rich.console import Console

    console = Console(record=True, file=io.StringIO(), width=100, force_jupyter=False)  # else it displays, too
    for table in tables:
        console.print(table)
    drawn = console.export_html(code_format=FORM, inline_styles=True)
    return "".join([f"<p>{escape(headline)}</p>", drawn, *(f"<p>{escape(note)}</p>" for note in notes)])


def as_text(headline: str, notes: Sequence[str] = ()) -> str:
    """Return a line in angle brackets, and notes indented below it."""
    return "\n".join([f"<{headline}>", *(f"  {note}" for note in notes)])


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
        if time.monotonic() - last >= EVERY:
            last = time.monotonic()
            bars = [f"<progress value={value:.3f}></progress> {escape(name)}" for name, value in shares.items()]
            handle.update(display.HTML("<br>".join(bars)))

    try:
        yield report
    finally:
        handle.update(display.HTML(""))
