"""Looks at campaigns again and again, tells what is new, and keeps what pages, charts and metrics are made of."""

import json
import math
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from app.files.acquisition.events import seconds
from app.files.acquisition.hammer_folder import begun_with
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import read_protocol
from app.files.campaigns.kind import HAMMER_TEST, PROTOCOL, is_campaign_folder, is_hammer_folder
from app.watch.news import BoundedNews, News, NewsOfCampaign
from app.watch.status import UNDER_WAY, CampaignStatus, gone, status_of, status_of_hits
from app.watch.watched import MeasuredSweep, Watched, set_point_line
from app.watch.watched_hits import WatchedHits
from app.watch.words import in_words, plain

LOOK_INTERVAL = 1.0
"""Seconds between two looks."""
FRFS_KEPT = 2
"""FRFs that are kept: the last one, and the one before it."""


class WatchedFolder:
    """One campaign that may not have begun yet, be begun anew, disappear and come back.

    Parameters
    ----------
    folder : Path
    name : str
        What it is called.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.folder, self.name = folder, name
        self.version = 0
        self._watched: Watched | WatchedHits | None = None
        self._protocol: tuple[int, int, int] | None = None
        self._begun = False
        self._drawn: tuple[int, bytes] = (-1, b"")

    def look(self, now: float) -> CampaignStatus:
        """Read what is new; return how the campaign stands. `now` is the time of day, s since 1970."""
        try:
            mark = self._mark()
            if self._watched is None or mark != self._protocol:
                hits = is_hammer_folder(self.folder)
                self._watched = WatchedHits(self.folder) if hits else Watched(self.folder, FRFS_KEPT)
                self._protocol = mark
                self.version += 1
            if self._watched.look():
                self.version += 1
        except (CampaignFileError, OSError) as error:
            self._watched = None
            if not self._begun and not (is_campaign_folder(self.folder) or is_hammer_folder(self.folder)):
                return CampaignStatus(name=self.name, folder=plain(self.folder), state="not begun")
            why = (error.strerror if isinstance(error, OSError) else "") or str(error)
            return gone(self.name, str(self.folder), why)
        self._begun = True
        if isinstance(self._watched, WatchedHits):
            return status_of_hits(self._watched, self.name, now)
        return status_of(self._watched, self.name, now)

    def charts(self) -> bytes | None:
        """Return what is drawn of it, JSON, made once however many ask; None where nothing is.

        Of a hammer test the page draws nothing: its charts are those of a programme and of sweeps.
        """
        if not isinstance(self._watched, Watched):
            return None
        if self._drawn[0] != self.version:
            self._drawn = self.version, json.dumps(charts(self._watched), allow_nan=False).encode()
        return self._drawn[1]

    def _mark(self) -> tuple[int, int, int]:
        found = (self.folder / (HAMMER_TEST if is_hammer_folder(self.folder) else PROTOCOL)).stat()
        return found.st_ino, found.st_mtime_ns, found.st_size


class Watcher:
    """Several campaigns.

    Parameters
    ----------
    folders : sequence of Path
    tell : callable
        Receives each message that is due.
    clock : callable
        Time of day, s since 1970.
    steady : callable
        Seconds that never run backwards, for the bounds on messages.

    Attributes
    ----------
    statuses : tuple of CampaignStatus
        As of the last look.
    """

    def __init__(
        self,
        folders: Sequence[Path],
        tell: Callable[[News], None],
        clock: Callable[[], float] = time.time,
        steady: Callable[[], float] = time.monotonic,
    ) -> None:
        self._clock, self._tell = clock, tell
        self._turn = threading.Lock()
        self._folders = [WatchedFolder(one, name) for one, name in zip(folders, names(folders), strict=True)]
        self._news = [NewsOfCampaign() for _ in folders]
        self._bounded = BoundedNews(steady)
        self.statuses: tuple[CampaignStatus, ...] = ()

    def look(self) -> tuple[CampaignStatus, ...]:
        """Look at all of them once, and tell what is new."""
        with self._turn:
            now = self._clock()
            self.statuses = tuple(one.look(now) for one in self._folders)
            for news, status in zip(self._news, self.statuses, strict=True):
                for one in news.of(status):
                    self._bounded.take(one)
            due = self._bounded.due()
        for one in due:
            self._tell(one)
        return self.statuses

    def record(self) -> dict[str, Any]:
        """Return how all stand, for the page: JSON without NaN."""
        with self._turn:
            campaigns = [
                status.record() | {"version": folder.version, "under_way": status.state in UNDER_WAY}
                for status, folder in zip(self.statuses, self._folders, strict=False)
            ]
        return {"now": self._clock(), "campaigns": campaigns}

    def charts(self, number: int) -> bytes | None:
        """Return what is drawn of a campaign, counted from 0, as JSON; None where none can be read."""
        with self._turn:
            return self._folders[number].charts() if 0 <= number < len(self._folders) else None


def names(folders: Sequence[Path]) -> tuple[str, ...]:
    """Return what campaigns are called: the folder's name, with those above it where that is not enough."""
    parts = [[plain(part) for part in folder.resolve().parts] for folder in folders]
    found = []
    for mine in parts:
        depth = 1
        while depth < len(mine) and sum(mine[-depth:] == other[-depth:] for other in parts) > 1:
            depth += 1
        found.append("/".join(mine[-depth:]) or "/")
    return tuple(found)


def require_acquired(folder: Path) -> None:
    """Refuse a campaign that no rig writes: ResultFileError for one that was imported."""
    if is_hammer_folder(folder):
        begun_with(folder)
        return
    protocol, _ = read_protocol(folder)
    if "acquired" not in protocol:
        raise ResultFileError(f"{folder}: was imported, no rig writes it; flexura view shows it")


AXIS_INTERVALS = 400
"""Intervals of an axis in which the extremes are kept: a page on a wide screen shows no more."""
EVENTS_SHOWN = 200
"""Lines of the log on the page."""
LOWEST_LEVEL = -100.0
"""Lowest level shown, dB re full scale."""


def charts(watched: Watched) -> dict[str, Any]:
    """Return everything, as JSON that holds no NaN: None in its place.

    Parameters
    ----------
    watched : Watched
        Of a few thousand readings and FRFs of any length; what is returned is bounded.

    Returns
    -------
    dict
        ``time`` (s since 1970) with ``air``, ``plate``; ``set_point``, ``programme`` as corners; ``marks``;
        ``frfs``; ``levels``; ``log``, latest first.
    """
    return {
        "temperatures": _temperatures(watched),
        "marks": _marks(watched),
        "frfs": _frfs(watched),
        "levels": _levels(watched),
        "log": _log(watched),
    }


def thinned(x: Real, *lines: Real) -> tuple[Real, ...]:
    """Return the points of lines that keep their extremes in each of some hundred intervals of x.

    Parameters
    ----------
    x : (N,) ndarray
        Ascending.
    lines : (N,) ndarray
        NaN where nothing is known.

    Returns
    -------
    tuple of (n,) ndarray
        x and the lines, n <= (2 L + 2) AXIS_INTERVALS for L lines; N <= 2 AXIS_INTERVALS points are returned as
        they are.
    """
    if x.size <= 2 * AXIS_INTERVALS:
        return (x, *lines)
    kept: set[int] = {0, x.size - 1}
    for part in np.array_split(np.arange(x.size), AXIS_INTERVALS):
        kept.add(int(part[-1]))
        for line in lines:
            known = part[np.isfinite(line[part])]
            if known.size:
                kept |= {int(known[line[known].argmin()]), int(known[line[known].argmax()])}
    at = np.array(sorted(kept))
    return (x[at], *(line[at] for line in lines))


def _temperatures(watched: Watched) -> dict[str, Any]:
    time = np.array([seconds(reading.date) for reading in watched.readings])
    air = np.array([reading.air_c for reading in watched.readings])
    plate = np.array([reading.plate_c for reading in watched.readings])
    if not time.size:
        return {"time": [], "air": [], "plate": [], "set_point": [], "programme": []}
    commands = watched.events_of("oven")
    line = set_point_line(commands, [seconds(c["date"]) for c in commands], time, air, float(time[-1]))
    programme: list[list[float | None]] = []
    if (planned := watched.course) is not None:
        since, course = planned
        programme = _pairs(course.time + since, course.temperature)
    order = np.argsort(time, kind="stable")  # a clock may be set back
    time, air, plate = thinned(time[order], air[order], plate[order])
    return {
        "time": _numbers(time, 1),
        "air": _numbers(air, 3),
        "plate": _numbers(plate, 3),
        "set_point": _pairs(*(part[-4 * AXIS_INTERVALS :] for part in line)),
        "programme": programme,
    }


def _marks(watched: Watched) -> list[dict[str, Any]]:
    """Sweeps: when, at which temperature, and what came of them."""
    points = (
        {point.step: point.temperature for leg in watched.protocol.legs for point in leg.set_points}
        if (watched.protocol is not None)
        else {}
    )
    found = []
    for event in watched.events:
        if event["event"] in ("finished", "rejected", "missing"):
            here = event.get("temperature", points.get(event.get("step", -1)))
            found.append({"kind": event["event"], "time": seconds(event["date"]), "temperature": here})
    return found[-4 * AXIS_INTERVALS :]


def _frfs(watched: Watched) -> dict[str, Any] | None:
    """Return the last FRF over the one before it, and the coherence of the last."""
    steps = sorted(watched.sweeps)
    if not steps:
        return None
    last = watched.sweeps[steps[-1]]
    before = watched.sweeps[steps[-2]] if len(steps) > 1 else None
    return {
        "last": f"{last.temperature:.2f} °C {last.direction}",
        "before": None if before is None else f"{before.temperature:.2f} °C {before.direction}",
        "sensors": [
            {
                "name": plain(output.id),
                "label": plain(label),
                "last": _curve(last, number),
                "before": None if before is None else _curve(before, number),
            }
            for number, (output, label) in enumerate(
                zip(watched.experiment.outputs, watched.experiment.labels(), strict=True)
            )
            if number < last.h.shape[0]
        ],
    }


def _curve(sweep: MeasuredSweep, sensor: int) -> dict[str, Any]:
    level = 20.0 * np.log10(np.abs(sweep.h[sensor]) + 1e-12)
    frequency, level, coherence = thinned(sweep.frequency, level, sweep.coherence[sensor])
    return {
        "frequency": _numbers(frequency, 2),
        "level": _numbers(level, 2),
        "coherence": _numbers(coherence, 4),
    }


def _levels(watched: Watched) -> dict[str, Any] | None:
    """Return rms and peak of every channel of the last repeat, and which clipped."""
    latest = watched.latest
    if latest is None:
        return None
    signals = latest.signals.astype(float)
    return {
        "place": plain(f"repeat {latest.repeat + 1} of {latest.place}"),
        "channels": [
            {"name": plain(name), "peak": peak, "rms": rms, "clipped": over}
            for name, peak, rms, over in zip(
                latest.channels,
                _decibels(np.abs(signals).max(axis=1), latest.full_scale),
                _decibels(np.sqrt((signals**2).mean(axis=1)), latest.full_scale),
                latest.overloaded.tolist(),
                strict=False,
            )
        ],
    }


def _log(watched: Watched) -> list[dict[str, str]]:
    """Return the latest events and sentences of the watchdog, in words, latest first."""
    said = [(event["date"], in_words(event)) for event in watched.events[-EVENTS_SHOWN:]]
    if not watched.simulated:
        said += [(date, f"watchdog: {plain(sentence)}") for date, sentence in watched.said[-EVENTS_SHOWN:]]
    said.sort(key=lambda one: seconds(one[0]), reverse=True)
    return [{"date": date, "words": words} for date, words in said[:EVENTS_SHOWN]]


def _decibels(volts: NDArray[np.float64], full_scale: float) -> list[float]:
    found = 20.0 * np.log10(np.nan_to_num(volts, posinf=0.0) / (full_scale or 1.0) + 1e-12)
    return [round(float(value), 1) for value in np.maximum(found, LOWEST_LEVEL)]


def _pairs(x: Real, y: Real) -> list[list[float | None]]:
    return [list(pair) for pair in zip(_numbers(x, 1), _numbers(y, 3), strict=True)]


def _numbers(values: Real, digits: int) -> list[float | None]:
    return [round(value, digits) if math.isfinite(value) else None for value in values.tolist()]
