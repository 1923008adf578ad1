"""Tables on the screen."""

from collections.abc import Iterable

import rich.table
from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.text import Text

from app.summaries.table import Table


def drawn(table: Table) -> Group:
    """Return a table as the terminal draws it, title and caption as wide as the terminal, not as the columns."""
    found = rich.table.Table(header_style="bold", box=SIMPLE_HEAD, show_edge=False, padding=(0, 1, 0, 0))
    for number, heading in enumerate(table.headings):
        if number in table.words:
            found.add_column(heading, overflow="fold")
        else:
            found.add_column(heading, justify="right", no_wrap=table.whole)
    for row in table.rows:
        found.add_row(*row)
    title = [Text(table.title, "table.title")] if table.title else []
    caption = [Text(table.caption, "table.caption")] if table.caption else []
    return Group(*title, found, *caption)


def show(tables: Iterable[Table], lines: Iterable[str] = ()) -> None:
    """Print tables, and below them, where the eye is when a verb ends, lines."""
    console = Console()
    for table in tables:
        console.print(drawn(table))
    for line in lines:
        console.print(line, highlight=False, markup=False, soft_wrap=True)
