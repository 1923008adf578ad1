"""A table of words, as a value: the terminal, a notebook and the report draw it each in their own way."""

from dataclasses import dataclass


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
