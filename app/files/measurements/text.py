"""Tables of text: CSV of any delimiter, decimal commas, heads of any length; packed with gzip, too."""

import csv
import gzip
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import is_unit
from app.files.measurements.columns import MOST_BYTES, Columns, unused_name

DELIMITERS = ("\t", ";", ",", "|", None)
"""Tried in this order; None is any run of spaces."""
HEAD = 2000
"""Lines in which the numbers have to begin."""
ALIKE = 3
"""Lines of as many numbers in a row that are a table."""
COMMENT = re.compile(r"\s*(?:[#%!*]+|//)\s*")
"""Begins a line of the head in some programs' files; it belongs to no name."""
COMMAS = "; if its commas are decimal marks, put semicolons between the numbers"
IN_BRACKETS = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))")
"""A name, perhaps an empty one, and its unit."""


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
    return of_lines(_text(path).splitlines())


def of_lines(lines: list[str]) -> Columns:
    """Read a table from the lines of a text; ValueError as `read`."""
    first, delimiter, comma, count = _table(lines)
    commas = delimiter == "," and not any("." in line for line in lines[first : first + ALIKE])
    if commas and first and count == 2 * len(_split(lines[first - 1].strip(), ",")):
        raise ValueError(
            f"line {first + 1}: {lines[first][:60]!r}; {count} numbers below {count // 2} names{COMMAS}"
        )
    rows = [number for number in range(first, len(lines)) if lines[number].strip()]
    values: NDArray[Any] = np.empty((len(rows), count))
    for place, number in enumerate(rows):
        row = _numbers(lines[number], delimiter, comma)
        if row is None or len(row) != count:
            raise ValueError(
                f"line {number + 1}: {lines[number][:60]!r}; {count} numbers wanted, as in the lines before: "
                f"complete or remove this line{COMMAS if commas else ''}"
            )
        try:
            values[place] = row
        except TypeError:  # the first complex number
            values = values.astype(complex)
            values[place] = row
    names, units = _head(lines[:first], delimiter, count)
    columns: dict[str, np.ndarray] = {}
    known: dict[str, str] = {}
    for name, unit, column in zip(names, units, values.T, strict=True):
        own = unused_name(name, columns)
        columns[own] = column.copy() if column.imag.any() else column.real.copy()
        if unit:
            known[own] = unit
    return Columns(columns, known, scalars=_rate_in_head(lines[:first]))


RATE_IN_HEAD = re.compile(
    r"(?<![a-z])(?:fs|(?:sampl\w*|scan)[ _-]*(?:rate|freq\w*)|abtast(?:rate|frequenz))(?![a-z])\W{0,3}"
    r"(k?hz|s/s|1/s)?\W{0,4}([\d.,]+(?:e[-+]?\d+)?)[ \t;,\"]*(k?hz)?",
    re.IGNORECASE,
)
"""What a program writes of the sample rate above its table: ``Sample rate: 1024 Hz``, ``Fs [kHz];51,2``."""


def _rate_in_head(lines: list[str]) -> dict[str, float]:
    """Return the sample rate that the head gives, Hz, by a name; empty where it gives none, or several."""
    found: set[float] = set()
    for line in lines:
        if match := RATE_IN_HEAD.search(line):
            written = match[2].rstrip(".,").replace(",", ".")
            try:
                rate = float(written)
            except ValueError:
                continue
            kilo = "k" in (match[1] or "").lower() or "k" in (match[3] or "").lower()
            found.add(rate * (1e3 if kilo else 1.0))
    return {"sample rate": found.pop()} if len(found) == 1 and 0.0 not in found else {}


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
    return decoded(content)


def decoded(content: bytes) -> str:
    """Text in UTF-16 with its mark, in UTF-8, or else in the code page of Western Windows, byte by byte."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16")
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return content.decode("latin-1")


def _table(lines: list[str]) -> tuple[int, str | None, bool, int]:
    """Find where the numbers begin, their delimiter, whether commas are decimal, and how many stand in a line."""
    for first in range(min(len(lines), HEAD)):
        following = [line for line in lines[first : first + ALIKE + 2] if line.strip()][:ALIKE]
        if not lines[first].strip() or not following:
            continue
        for delimiter in DELIMITERS:
            comma = delimiter != "," or '"' in lines[first]
            counts = {
                len(row) if (row := _numbers(line, delimiter, comma)) is not None else 0 for line in following
            }
            if len(counts) == 1 and (count := counts.pop()) > 1:
                return first, delimiter, comma, count
    raise ValueError(
        f"no table of numbers with at least two columns begins in its first {HEAD} lines; export time in seconds "
        "(no dates), or frequency, and channels as columns separated by tabs, semicolons, commas, | or spaces"
    )


def _split(line: str, delimiter: str | None) -> list[str]:
    """Parts of a line without the quotation marks around them, between which a delimiter does not count."""
    if '"' not in line:
        return line.split(delimiter)
    if delimiter is None:
        return [quoted or plain for quoted, plain in re.findall(r'"([^"]*)"|(\S+)', line)]
    try:
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])
    except csv.Error:
        return line.split(delimiter)


def _numbers(line: str, delimiter: str | None, comma: bool) -> list[float | complex] | None:
    """Numbers of a line; None where it holds anything else, such as commas between thousands beside points."""
    parts = _split(line.strip().rstrip(delimiter or " "), delimiter)
    if comma and "," in line:
        if "." in line:
            return None
        parts = [part.replace(",", ".") for part in parts]
    try:
        return [float(part) for part in parts]
    except ValueError:
        pass
    try:
        return [_complex(part) for part in parts]
    except ValueError:
        return None


def _complex(part: str) -> float | complex:
    """Return a number as Python, numpy, MATLAB and Excel write complex ones: ``(1+-2j)``, ``1 - 2i``."""
    plain = part.replace(" ", "").strip("()").replace("+-", "-")
    if plain[-1:] in ("i", "j"):
        return complex(f"{plain[:-1]}j")
    return float(plain)


def _head(lines: list[str], delimiter: str | None, count: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns, from the last lines before the numbers that have as many parts."""
    rows = [row for line in lines[-8:] if any(row := _head_row(line, delimiter, count))]
    numbered = [str(number) for number in range(1, count + 1)]
    if not rows:
        return numbered, [""] * count
    units = [_as_unit(part) for part in rows[-1]]
    if len(rows) > 1 and None not in units:  # a line of units below that of the names
        return [part or number for part, number in zip(rows[-2], numbered, strict=True)], [u or "" for u in units]
    whole = [row for row in rows if all(row)]
    named = whole[-1] if whole else rows[-1]  # below the names there may be a line of units with gaps
    names, found = [], []
    for part, number in zip(named, numbered, strict=True):
        match = IN_BRACKETS.fullmatch(part)
        names.append((match[1] if match else part) or number)
        found.append(match[2] or match[3] or "" if match else "")
    return names, found


def _head_row(line: str, delimiter: str | None, count: int) -> list[str]:
    """Parts of a line of the head; none, where there are not as many as columns."""
    for text in (line, COMMENT.sub("", line, count=1)):
        parts = [part.strip() for part in _split(text.strip("\r\n"), delimiter)]
        if len(parts) > count and not any(parts[count:]):
            parts = parts[:count]
        if len(parts) == count:
            return [COMMENT.sub("", parts[0], count=1) or parts[0], *parts[1:]]
    return []


def _as_unit(part: str) -> str | None:
    """Return the unit that stands alone, in brackets or not; empty for a gap, None for anything else."""
    match = IN_BRACKETS.fullmatch(part)
    if match and not match[1]:
        return match[2] or match[3] or ""
    return part if not part or is_unit(part) else None
