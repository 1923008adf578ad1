"""``events.jsonl``: what happened to a campaign, one JSON object a line, each on the disk before the next.

A reader that looks again and again takes the whole lines that were added since it looked last.

Files of a running campaign for people and windows: ``readings.csv``, ``latest.h5``, ``control.json``.

``readings.csv`` has every temperature read, a line each. It is written without forcing it to the disk: what a kill
tears off is one line that no campaign hangs on.

``latest.h5`` holds the repeat recorded last, replaced by the next; it is never analysed.

``control.json`` is what a window requests: to go on, to pause, or to stop safely. The runner asks at every reading
of the temperature, and wherever the file is missing or cannot be read it goes on: nothing that happens to a window
can disturb a campaign.
"""

import csv
import json
import math
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import astuple, dataclass, fields
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from analysis.checked_fields import check_range, check_shapes
from app.files.atomic import atomic_hdf5, write_json
from app.files.campaign_error import CampaignFileError, Problem
from app.files.hdf5_file import Hdf5FileError, opened_hdf5, read_value, write_value
from app.files.parsed_text import parse_json, read_bytes, read_text

NAME = "events.jsonl"
Whole = Annotated[int, Field(ge=0, le=1_000_000)]
Degrees = Annotated[float, Field(ge=-300.0, le=3000.0)]
DOUBT = "temperature in doubt"
"""Event of a reading, or with ``step`` of a sweep or hit that was kept; why in a list, ``what``."""
LARGEST_EVENTS_FILE = 50_000_000
"""Bytes: some hundred thousand events."""


def seconds(date: str) -> float:
    """Seconds since 1970 of an ISO 8601 date; ValueError for what is none."""
    try:
        return datetime.fromisoformat(date).timestamp()
    except (OverflowError, OSError) as error:  # beyond what this system's clock can be
        raise ValueError(f"{date}: {error}") from error


def append_event(folder: Path, event: dict[str, Any]) -> None:
    """Add one event; returns when it is on the disk. A torn line left by a kill is closed off first."""
    line = json.dumps(event, ensure_ascii=False, allow_nan=False).encode() + b"\n"
    with (folder / NAME).open("ab+") as file:
        whole = _whole(file)
        file.truncate(whole)
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def log_of(folder: Path, begun: Callable[[Path], bool]) -> Callable[[Mapping[str, Any]], None]:
    """Return what appends an event to the log of a folder, once `begun` says that there is one in it."""

    def log(event: Mapping[str, Any]) -> None:
        if begun(folder):
            append_event(folder, dict(event))

    return log


def read_events(folder: Path) -> list[dict[str, Any]]:
    """Read every whole event, oldest first; a torn last line is ignored.

    Raises
    ------
    CampaignFileError
        If a line before the last is no JSON object: that is no kill, that is damage. And if the file is no log.
    """
    path = folder / NAME
    if not path.exists():
        return []
    try:
        lines = read_bytes(path, LARGEST_EVENTS_FILE).split(b"\n")[:-1]
    except ValueError as error:
        raise CampaignFileError(folder, [Problem(NAME, "", str(error), "")]) from error
    events = []
    for number, line in enumerate(lines, 1):
        try:
            events.append(parse_event(line))
        except ValueError as error:
            raise CampaignFileError(folder, [_damaged(number, line)]) from error
    return events


def later_doubts(events: Iterable[Mapping[str, Any]]) -> dict[int, str]:
    """Return why temperatures are in doubt by what the rig learnt after a sweep or a hit, by its number."""
    return {
        int(event["step"]): "; ".join(event["what"])
        for event in events
        if event.get("event") == DOUBT and event.get("step") is not None
    }


def parse_event(line: str | bytes) -> dict[str, Any]:
    """Read one event; ValueError for what is none, or lacks what those who read the log take from it."""
    event: dict[str, Any] = parse_json(line)
    _Event.model_validate(event)
    return event


class _Event(BaseModel):
    """What readers of the log take from an event; there is more in it, for people."""

    model_config = ConfigDict(strict=True, allow_inf_nan=False)

    event: str
    date: Annotated[str, AfterValidator(seconds)] | None = None
    leg: Annotated[int, Field(ge=-1, le=1_000_000)] | None = None  # -1 before the first
    step: Whole | None = None
    attempt: Whole | None = None
    temperature: Degrees | None = None
    place: str | None = None
    point: Whole | None = None
    set_point: Whole | None = None
    command: Literal["ramp", "hold", "safe"] | None = None
    target: Degrees | None = None
    rate: Annotated[float, Field(gt=0.0, le=1e4)] | None = None
    purpose: str | None = None
    what: str | list[str] | None = None
    doubt: str | None = None

    @model_validator(mode="after")
    def _whole(self) -> Self:
        needed = {
            "sweep begun": ("step", "attempt"),
            "missing": ("place",),
            "oven": ("command",),
            "hit rejected": ("step",),
            "hit undone": ("step",),
            "point skipped": ("set_point", "point"),
            DOUBT: ("what",),
        }.get(self.event, ())
        needed += ("target",) if self.command == "ramp" else ()
        needed += ("leg",) if self.purpose == "leg" else ()
        needed += ("step",) if self.event == "missing" and self.date is not None else ()  # a rig's
        lacking = [name for name in needed if getattr(self, name) is None]
        if lacking:
            raise ValueError(f"{self.event} lacks {', '.join(lacking)}")
        if self.event == DOUBT and isinstance(self.what, str):
            raise ValueError(f"{DOUBT}: what is {self.what!r}, not a list")
        return self


def _whole(file: Any) -> int:
    """Bytes up to the end of the last whole line."""
    file.seek(0)
    return int(file.read().rfind(b"\n")) + 1


def _damaged(number: int, line: bytes) -> Problem:
    remedy = "remove that line, or put the file back from a copy"
    return Problem(NAME, f"line {number}", repr(line[:60]), "an event", remedy)


class Tail:
    """Follows a file that another process appends to.

    Parameters
    ----------
    path : Path
        Need not be there yet.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._read = 0

    def lines(self) -> list[str]:
        """Return what is new; a last line without its end is left for the next time."""
        try:
            with self._path.open("rb") as file:
                file.seek(self._read)
                new = file.read()
        except OSError:  # not there yet, or for a moment out of reach
            return []
        whole = new.rfind(b"\n") + 1
        self._read += whole
        return new[:whole].decode("utf-8", errors="replace").splitlines()


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
