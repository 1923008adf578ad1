"""LabVIEW measurement files (LVM, versions 0.92 to 2): a head of the file, then segments of a head and a table.

A rate stands in them twice: as ``Delta_X``, of which LabVIEW keeps six decimals, and as the column of times.
Channels of different rates stand side by side; the columns of the slower ones end early.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import FREQUENCIES, TIMES, plain_unit
from analysis.estimation.sampling import RateSeen, is_default, of_step, of_times
from app.files.measurements import text
from app.files.measurements.columns import MOST_COLUMNS, Columns, add_rate, unused_name
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
    lines = text.decoded(read_bytes(path, LARGEST)).splitlines()
    if not lines or not lines[0].startswith("LabVIEW Measurement"):
        return text.read(path)
    ends = [number for number, line in enumerate(lines) if line.startswith(END)]
    if len(ends) < 2:
        raise ValueError("no samples follow the head of the file; cut short? copy it again")
    delimiter = "," if any(line.startswith("Separator,") for line in lines[: ends[0]]) else "\t"
    common = _fields(lines[: ends[0]], delimiter)
    values: dict[str, NDArray[np.float64]] = {}
    parts: list[tuple[str, str, _Segment, int]] = []
    begin = ends[0] + 1
    for number, end in enumerate(ends[1:], start=1):
        part = _Segment(common | _fields(lines[begin:end], delimiter), lines[end + 1 : end + 2], delimiter)
        last = ends[number + 1] if number + 1 < len(ends) else len(lines)
        begin = part.read(lines, end + 2, last, ends_at_blank=number + 1 < len(ends))
        taken: dict[str, str] = {}
        for place in part.filled:
            own = unused_name(part.name(place), taken)
            taken[own] = name = own if len(ends) == 2 else f"segment {number}/{own}"
            values[name] = part.samples(place)
            parts.append((name, own, part, place))
    columns = Columns(values)
    for name, own, part, place in parts:
        if len(ends) > 2:
            columns.channels[name] = own
        part.describe(columns, name, place)
    return columns


def _fields(lines: Sequence[str], delimiter: str) -> Fields:
    return {
        parts[0].strip(): [part.strip() for part in parts[1:]] for parts in (x.split(delimiter) for x in lines)
    }


class _Segment:
    """A segment: its head, and the columns below it."""

    def __init__(self, head: Fields, titles: Sequence[str], delimiter: str) -> None:
        self._head, self._delimiter = head, delimiter
        self._titles = [part.strip() for part in titles[0].split(delimiter)] if titles else []
        layout = head.get("X_Columns", [""])[0]
        self._step = 2 if layout == "Multi" else 1  # with a column of times before each channel
        self._timed = layout != "No"
        if not head.get("Channels", [""])[0]:
            raise ValueError("the head of a segment gives no number of channels; damaged? export it again")
        count = int(float(head["Channels"][0]))
        if not 0 <= count <= MOST_COLUMNS:
            raise ValueError(f"the head of a segment gives {count} channels; damaged? export it again")
        self.filled = [place for place in range(count) if self.field("Samples", place) != "0"]
        self._comma = head.get("Decimal_Separator", ["."])[0] == ","
        self._columns: dict[int, NDArray[np.float64]] = {}

    def field(self, key: str, place: int) -> str:
        """Field of a channel, by its place; empty where there is none."""
        row = self._head.get(key, [])[:: self._step]
        return row[place] if place < len(row) else ""

    def name(self, place: int) -> str:
        """Name of a channel; its number where there is none."""
        at = self._at(place)
        return self._titles[at] if at < len(self._titles) and self._titles[at] else str(place + 1)

    def samples(self, place: int) -> NDArray[np.float64]:
        """Return the samples of a channel."""
        return self._columns[self._at(place)]

    def describe(self, columns: Columns, name: str, place: int) -> None:
        """Add a channel's unit, rate and start, as its head and its times give them."""
        if unit := self.field("Y_Unit_Label", place):
            columns.units[name] = unit
        along = plain_unit(self.field("X_Unit_Label", place) or "s")
        if self.field("X_Dimension", place).lower().startswith("freq") or along in FREQUENCIES:
            columns.doubts[name] = "its X_Dimension is frequency: it holds spectra, no signals; export the signals"
            return
        scale = TIMES.get(along)
        if scale is None:
            columns.doubts[name] = f"X_Unit_Label {along!r} is no unit of time; declare sample_rate = ... in Hz"
            return
        seen: list[RateSeen] = []
        start, times = self._number("X0", place), self._times(place, len(self.samples(place)))
        if times is not None:
            try:
                seen.append(of_times(scale * times, "the column X_Value"))
            except ValueError as error:
                columns.doubts[name] = str(error)
                return
            start = float(times[0])
        step, default = self._number("Delta_X", place), ""
        if step is not None and step > 0.0:
            if is_default(scale * step):
                default = "Delta_X"
            else:
                written = self.field("Delta_X", place) if scale == 1.0 else ""
                seen.append(of_step(scale * step, "Delta_X", written))
        add_rate(columns, name, seen, default)
        if start is not None:
            columns.starts[name] = scale * start

    def _number(self, key: str, place: int) -> float | None:
        """Return a number of a channel's head; None where there is none."""
        try:
            value = float(self.field(key, place).replace(",", "."))
        except ValueError:
            return None
        return value if np.isfinite(value) else None

    def _times(self, place: int, samples: int) -> NDArray[np.float64] | None:
        """Return the times of a channel; None where they are not written, or not as numbers: times of day."""
        times = self._columns.get(self._at(place) - 1 if self._step == 2 else 0) if self._timed else None
        if times is None or len(times) < max(samples, 3) or not np.isfinite(times).all():
            return None
        return times[:samples]

    def _at(self, place: int) -> int:
        return 1 + self._step * place

    def read(self, lines: Sequence[str], first: int, last: int, *, ends_at_blank: bool) -> int:
        """Read the lines from `first` up to `last` into columns; return the next line."""
        rows: list[list[str]] = []
        numbers: list[int] = []
        number = first
        while number < last:
            line = lines[number]
            number += 1
            if not line.strip():
                if ends_at_blank and rows:
                    break
                continue
            rows.append(line.split(self._delimiter))
            numbers.append(number)
        for place in self.filled:
            at = self._at(place)
            held = [row[at].strip() if at < len(row) else "" for row in rows]
            self._columns[at] = self._parsed(held, numbers, self._declared(place, len(rows)))
            if self._timed and (self._step == 2 or 0 not in self._columns):
                self._keep_times(at - 1 if self._step == 2 else 0, rows)
        if not self.filled or not any(len(self._columns[self._at(place)]) for place in self.filled):
            raise ValueError("no sample follows the head of a segment; cut short? copy it again")
        return number

    def _declared(self, place: int, most: int) -> int:
        """Return how many samples a channel has at least: as declared; all rows, where nothing is."""
        declared = self._number("Samples", place)
        return most if declared is None else int(min(declared, most + 1))

    def _parsed(self, held: list[str], numbers: list[int], least: int) -> NDArray[np.float64]:
        """Numbers of a column, which ends at its first gap; `least` have to be there."""
        count = next((place for place, part in enumerate(held) if not part), len(held))
        later = next((place for place in range(count, len(held)) if held[place]), None)
        if later is not None or count < least:
            line = numbers[count] if count < len(numbers) else numbers[-1] + 1 if numbers else 0
            raise ValueError(
                f"line {line}: a channel has {count} samples up to here, and {least} are declared or follow: cut "
                "short? export it again"
            )
        try:
            return np.array([float(part.replace(",", ".") if self._comma else part) for part in held[:count]])
        except ValueError as error:
            bad = next(place for place, part in enumerate(held) if not _is_number(part, self._comma))
            raise ValueError(
                f"line {numbers[bad]}: {held[bad][:60]!r}; a number wanted: damaged? export it again"
            ) from error

    def _keep_times(self, at: int, rows: Sequence[Sequence[str]]) -> None:
        """Keep a column of times as far as they are numbers."""
        held = [row[at].strip() if at < len(row) else "" for row in rows]
        count = next((place for place, part in enumerate(held) if not _is_number(part, self._comma)), len(held))
        self._columns[at] = np.array(
            [float(part.replace(",", ".") if self._comma else part) for part in held[:count]]
        )


def _is_number(part: str, comma: bool) -> bool:
    try:
        float(part.replace(",", ".") if comma else part)
    except ValueError:
        return False
    return True
