"""Tables as a notebook shows them."""

import io
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

FORM = '<pre style="white-space:pre;overflow-x:auto;line-height:normal"><code>{code}</code></pre>'


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

    console = Console(record=True, file=io.StringIO(), width=100)
    for table in tables:
        console.print(table)
    drawn = console.export_html(code_format=FORM, inline_styles=True)
    return "".join([f"<p>{escape(headline)}</p>", drawn, *(f"<p>{escape(note)}</p>" for note in notes)])


def as_text(headline: str, notes: Sequence[str] = ()) -> str:
    """Return a line in angle brackets, and notes indented below it."""
    return "\n".join([f"<{headline}>", *(f"  {note}" for note in notes)])
