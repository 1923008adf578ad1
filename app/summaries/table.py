"""A table of words, as a value, and a result as a script prints it and as a notebook shows it.

The terminal, a notebook and the report draw a table each in their own way.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from app.summaries.keywords import in_keywords


@dataclass(frozen=True)
class Table:
    """Rows of text below headings.

    Attributes
    ----------
    title, caption : str
        Above and below it.
    headings : tuple of str
    rows : tuple of tuple of str
        As many cells each as there are headings.
    words : frozenset of int
        Columns that hold words, at the left and wrapped; the others hold numbers, at the right.
    whole : bool
        Whether a column is never wrapped, nor cut where the table is narrow.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    words: frozenset[int] = frozenset()
    whole: bool = False

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.headings):
                raise ValueError(f"table {self.title!r}: {len(row)} cells below {len(self.headings)} headings")


def as_text(headline: str, notes: Sequence[str] = ()) -> str:
    """Return a line in angle brackets, and notes indented below it, in the library's keywords."""
    return "\n".join([f"<{headline}>", *(f"  {in_keywords(note)}" for note in notes)])


def as_html(headline: str, tables: Iterable[Table], notes: Sequence[str] = ()) -> str:
    """Return a line, tables, and a paragraph for every note as HTML, in the library's keywords."""
    paragraphs = (f"<p>{escape(in_keywords(note))}</p>" for note in notes)
    return "".join([f"<p>{escape(headline)}</p>", *map(_table, tables), *paragraphs])


def _table(table: Table) -> str:
    sides = ["left" if n in table.words else "right" for n in range(len(table.headings))]

    def row(tag: str, cells: Sequence[str]) -> str:
        shown = (
            f'<{tag} style="text-align:{side};white-space:pre-line">{escape(in_keywords(cell))}</{tag}>'
            for side, cell in zip(sides, cells, strict=True)
        )
        return f"<tr>{''.join(shown)}</tr>"

    body = "".join(row("td", cells) for cells in table.rows)
    below = f"<p>{escape(in_keywords(table.caption))}</p>" if table.caption else ""
    title = f'<caption style="text-align:left">{escape(table.title)}</caption>'
    return f"<table>{title}<thead>{row('th', table.headings)}</thead><tbody>{body}</tbody></table>{below}"
