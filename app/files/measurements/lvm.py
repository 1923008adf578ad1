"""LabVIEW measurement files (LVM, versions 0.92 to 2): a head of the file, then segments of a head and a table."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from app.files.measurements import text
from app.files.measurements.columns import Columns, unused_name
from app.files.parsed_text import read_bytes

LARGEST = 500_000_000
END = "***End_of_Header***"
Fields = dict[str, list[str]]
"""Fields of the lines of a head, by the first of each line."""


def read(path: Path) -> Columns:
    """Read all segments; of several, the channels are called ``segment 1/Hammer`` and so on.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns
        Channels without samples are left out. LabVIEW writes files without heads, too: tables of text.

    Raises
    ------
    ValueError
        Where it is damaged, or is neither LabVIEW's nor a table.
    """
    lines = read_bytes(path, LARGEST).decode("utf-8", errors="replace").splitlines()
    if not lines or not lines[0].startswith("LabVIEW Measurement"):
        return text.read(path)
    ends = [number for number, line in enumerate(lines) if line.startswith(END)]
    if len(ends) < 2:
        raise ValueError("no samples follow the head of the file; cut short? copy it again")
    delimiter = "," if any(line.startswith("Separator,") for line in lines[: ends[0]]) else "\t"
    common = _fields(lines[: ends[0]], delimiter)
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    rates: dict[str, float] = {}
    channels: dict[str, str] = {}
    begin = ends[0] + 1
    for number, end in enumerate(ends[1:], start=1):
        part = _Segment(common | _fields(lines[begin:end], delimiter), lines[end + 1 : end + 2], delimiter)
        last = ends[number + 1] if number + 1 < len(ends) else len(lines)
        values, begin = part.samples(lines, end + 2, last, ends_at_blank=number + 1 < len(ends))
        taken: dict[str, str] = {}
        for place, column in zip(part.filled, values.T, strict=True):
            own = unused_name(part.name(place), taken)
            taken[own] = name = own if len(ends) == 2 else f"segment {number}/{own}"
            columns[name] = column.copy()
            if len(ends) > 2:
                channels[name] = own
            if unit := part.field("Y_Unit_Label", place):
                units[name] = unit
            if step := part.field("Delta_X", place):
                rates[name] = 1.0 / float(step.replace(",", "."))
    return Columns(columns, units, rates, channels=channels)


def _fields(lines: Sequence[str], delimiter: str) -> Fields:
    return {
        parts[0].strip(): [part.strip() for part in parts[1:]] for parts in (x.split(delimiter) for x in lines)
    }


class _Segment:
    """A segment's head."""

    def __init__(self, head: Fields, titles: Sequence[str], delimiter: str) -> None:
        self._head, self._delimiter = head, delimiter
        self._titles = [part.strip() for part in titles[0].split(delimiter)] if titles else []
        self._step = 2 if "Multi" in head.get("X_Columns", []) else 1  # with a column of times before each channel
        if not head.get("Channels", [""])[0]:
            raise ValueError("the head of a segment gives no number of channels; damaged? export it again")
        count = int(float(head["Channels"][0]))
        self.filled = [place for place in range(count) if self.field("Samples", place) != "0"]
        self._comma = head.get("Decimal_Separator", ["."])[0] == ","

    def field(self, key: str, place: int) -> str:
        """Field of a channel, by its place; empty where there is none."""
        row = self._head.get(key, [])[:: self._step]
        return row[place] if place < len(row) else ""

    def name(self, place: int) -> str:
        """Name of a channel; its number where there is none."""
        at = self._at(place)
        return self._titles[at] if at < len(self._titles) and self._titles[at] else str(place + 1)

    def _at(self, place: int) -> int:
        return 1 + self._step * place

    def samples(
        self, lines: Sequence[str], first: int, last: int, *, ends_at_blank: bool
    ) -> tuple[np.ndarray, int]:
        """Return the samples (M, filled channels) of the lines from `first` up to `last`, and the next line."""
        rows: list[list[float]] = []
        number = first
        while number < last:
            line = lines[number]
            number += 1
            if not line.strip():
                if ends_at_blank and rows:
                    break
                continue
            parts = line.split(self._delimiter)
            wanted = [parts[self._at(place)] for place in self.filled if self._at(place) < len(parts)]
            if len(wanted) != len(self.filled):
                raise ValueError(
                    f"line {number}: {len(wanted)} numbers; {len(self.filled)} wanted: cut short? export it again"
                )
            try:
                rows.append([float(part.replace(",", ".") if self._comma else part) for part in wanted])
            except ValueError as error:
                raise ValueError(
                    f"line {number}: {line[:60]!r}; {len(self.filled)} numbers wanted: damaged? export it again"
                ) from error
        values = np.array(rows)
        if values.ndim != 2:
            raise ValueError("no sample follows the head of a segment; cut short? copy it again")
        return values, number
