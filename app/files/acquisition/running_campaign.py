"""Files of a running campaign for people and windows: ``readings.csv``, ``latest.h5``, ``control.json``.

``readings.csv`` has every temperature read, a line each. It is written without forcing it to the disk: what a kill
tears off is one line that no campaign hangs on.

``latest.h5`` holds the repeat recorded last, replaced by the next; it is never analysed.

``control.json`` is what a window requests: to go on, to pause, or to stop safely. The runner asks at every reading
of the temperature, and wherever the file is missing or cannot be read it goes on: nothing that happens to a window
can disturb a campaign.
"""

import csv
import math
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range, check_shapes
from app.files.acquisition.events import seconds
from app.files.atomic import atomic_hdf5, write_json
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.parsed_text import parse_json, read_text
from app.files.values import read_value, write_value

READINGS = "readings.csv"
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
    with (folder / READINGS).open("a", encoding="utf-8", newline="") as file:
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


LATEST = "latest.h5"


@dataclass(frozen=True)
class LatestRepeat:
    """One repeat as it came from the cards.

    Attributes
    ----------
    step, repeat : int
        Which sweep, and which of its repeats, from 0.
    place : str
        Temperature, direction and level in words.
    channels : tuple of str
        The drive, then the sensors.
    signals : (1 + K, M) ndarray
        V.
    overloaded : (1 + K,) bool ndarray
        Channels that came near the inputs' range.
    sample_rate : float
        Hz.
    full_scale : float
        V.
    """

    step: int
    repeat: int
    place: str
    channels: tuple[str, ...]
    signals: NDArray[np.float32]
    overloaded: NDArray[np.bool_]
    sample_rate: float
    full_scale: float

    def __post_init__(self) -> None:
        check_shapes(self, channels="c", signals="c M", overloaded="c")
        check_range(self, 0.0, np.inf, "sample_rate", unit="Hz", above=True)


def save_latest(folder: Path, latest: LatestRepeat) -> None:
    """Replace the file, whole or not at all."""
    with atomic_hdf5(folder / LATEST) as file:
        write_value(file.create_group("repeat"), latest)


def load_latest(folder: Path) -> LatestRepeat | None:
    """Read it; None where there is none, or none that can be read just now."""
    try:
        with opened_hdf5(folder / LATEST) as file:
            return read_value(file["repeat"], LatestRepeat)
    except Hdf5FileError:
        return None


CONTROL = "control.json"
ControlRequest = Literal["go on", "pause", "stop"]


def request(folder: Path, action: ControlRequest) -> None:
    """Write a request; the runner of the campaign reads it."""
    if action == "go on":
        (folder / CONTROL).unlink(missing_ok=True)
    else:
        write_json(folder / CONTROL, {"wish": action})


def requested(folder: Path) -> ControlRequest:
    """Return what is requested of the runner."""
    try:
        found = parse_json(read_text(folder / CONTROL))["wish"]
    except (OSError, ValueError, KeyError, TypeError):
        return "go on"
    return "pause" if found == "pause" else "stop" if found == "stop" else "go on"
