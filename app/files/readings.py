"""``readings.csv``: every temperature read while a campaign runs, a line each, for people and for windows.

Written without forcing it to the disk: what a kill tears off is one line that no campaign hangs on.
"""

import csv
import math
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from app.files.events import seconds

NAME = "readings.csv"
MOST_READINGS = 1_000_000
"""Sweeps of a campaign."""


@dataclass(frozen=True)
class ReadingLine:
    """One line.

    Attributes
    ----------
    date : str
        ISO 8601.
    air_c, plate_c : float
        Degrees Celsius; NaN for a plate without a sensor.
    stage : str
        What was being done.
    done, total : int
        Sweeps finished or given up, and all.
    seconds_left : float
        Estimate.
    """

    date: str
    air_c: float
    plate_c: float
    stage: str
    done: int
    total: int
    seconds_left: float


HEADING = ",".join(field.name for field in fields(ReadingLine))


def append_reading(folder: Path, line: ReadingLine) -> None:
    """Add one line, the heading first to an empty file."""
    with (folder / NAME).open("a", encoding="utf-8", newline="") as file:
        if not file.tell():
            file.write(HEADING + "\n")
        csv.writer(file, lineterminator="\n").writerow(astuple(line))


def parse_reading(text: str) -> ReadingLine | None:
    """Read one line; None for the heading, and for what a kill has torn."""
    try:
        date, air, plate, stage, done, total, left = next(csv.reader([text]))
        line = ReadingLine(date, float(air), float(plate), stage, int(done), int(total), float(left))
        seconds(date)
    except (ValueError, StopIteration, csv.Error):
        return None
    finite = math.isfinite(line.air_c) and not math.isinf(line.plate_c) and not math.isinf(line.seconds_left)
    return line if finite and 0 <= line.done <= line.total < MOST_READINGS else None
