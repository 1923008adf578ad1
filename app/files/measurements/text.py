"""Tables of text: CSV of any delimiter, decimal commas, heads of any length; packed with gzip, too."""

import gzip
import re
from pathlib import Path

import numpy as np

from app.files.measurements.columns import MOST_BYTES, Columns, unused_name

DELIMITERS = ("\t", ";", ",", None)
"""Tried in this order; None is any run of spaces."""
HEAD = 2000
"""Lines in which the numbers have to begin."""
ALIKE = 3
"""Lines of as many numbers in a row that are a table."""


def read(path: Path) -> Columns:
    """Read a table.

    Parameters
    ----------
    path : Path
        Text, or text packed by gzip.

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        With the line, where it holds no table or something else stands among its numbers.
    """
    lines = _text(path).splitlines()
    first, delimiter, comma, count = _table(lines)
    rows = [line for line in lines[first:] if line.strip()]
    values = np.empty((len(rows), count))
    for number, line in enumerate(rows):
        row = _numbers(line, delimiter, comma)
        if row is None or len(row) != count:
            raise ValueError(
                f"line {first + number + 1} of the table: {line[:60]!r}; {count} numbers wanted, as before"
            )
        values[number] = row
    names, units = _head(lines[:first], delimiter, count)
    columns: dict[str, np.ndarray] = {}
    known: dict[str, str] = {}
    for name, unit, column in zip(names, units, values.T, strict=True):
        own = unused_name(name, columns)
        columns[own] = column.copy()
        if unit:
            known[own] = unit
    return Columns(columns, known)


def _text(path: Path) -> str:
    if path.suffix.lower() == ".gz":
        with gzip.open(path) as file:
            content = file.read(MOST_BYTES // 4 + 1)
    else:
        with path.open("rb") as file:
            content = file.read(MOST_BYTES // 4 + 1)
    if len(content) > MOST_BYTES // 4:
        raise ValueError(f"more than {MOST_BYTES // 4} bytes of text; export a part of it, or as a binary file")
    if b"\0" in content[:4096] and not content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ValueError("no text: bytes of zero in it; give the file the ending of its format")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _table(lines: list[str]) -> tuple[int, str | None, bool, int]:
    """Find where the numbers begin, their delimiter, whether commas are decimal, and how many stand in a line."""
    for first in range(min(len(lines), HEAD)):
        following = [line for line in lines[first : first + ALIKE + 2] if line.strip()][:ALIKE]
        if not lines[first].strip() or not following:
            continue
        for delimiter in DELIMITERS:
            for comma in (False, True):
                if comma and delimiter == ",":
                    continue
                counts = {
                    len(row) if (row := _numbers(line, delimiter, comma)) is not None else 0 for line in following
                }
                if len(counts) == 1 and (count := counts.pop()) > 1:
                    return first, delimiter, comma, count
    raise ValueError(
        f"no table of numbers with at least two columns begins in its first {HEAD} lines; export time (or "
        "frequency) and channels as columns"
    )


def _numbers(line: str, delimiter: str | None, comma: bool) -> list[float] | None:
    parts = line.strip().rstrip(delimiter or " ").split(delimiter)
    try:
        return [float(part.replace(",", ".") if comma else part) for part in parts]
    except ValueError:
        return None


def _head(lines: list[str], delimiter: str | None, count: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns, from the last lines before the numbers that have as many parts."""
    rows: list[list[str]] = []
    for line in reversed(lines[-8:]):
        parts = [part.strip().strip('"') for part in line.strip("\r\n").split(delimiter)]
        if len(parts) > count and not any(parts[count:]):
            parts = parts[:count]
        if len(parts) == count and any(parts):
            rows.insert(0, parts)
    numbered = [str(number) for number in range(1, count + 1)]
    if not rows:
        return numbered, [""] * count
    bracketed = [re.fullmatch(r"\s*[\[(](.*)[\])]\s*", part) for part in rows[-1]]
    if len(rows) > 1 and all(bracketed):
        units = [match[1] if match else "" for match in bracketed]
        return [part or number for part, number in zip(rows[-2], numbered, strict=True)], units
    whole = [row for row in rows if all(row)]
    named = whole[-1] if whole else rows[-1]  # below the names there may be a line of units with gaps
    names, units = [], []
    for part, number in zip(named, numbered, strict=True):
        match = re.fullmatch(r"(.*?)\s*[\[(]([^\])]*)[\])]", part)
        names.append((match[1] if match else part) or number)
        units.append(match[2] if match else "")
    return names, units
