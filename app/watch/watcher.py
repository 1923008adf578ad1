"""Looks at campaigns again and again, tells what is new, and keeps what pages and metrics are made of."""

import json
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from app.files.acquisition.hammer_folder import begun_with
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import read_protocol
from app.files.campaigns.kind import HAMMER_TEST, PROTOCOL, is_campaign_folder, is_hammer_folder
from app.watch.charts import charts
from app.watch.news import BoundedNews, News, NewsOfCampaign
from app.watch.status import UNDER_WAY, CampaignStatus, gone, status_of, status_of_hits
from app.watch.watched import Watched
from app.watch.watched_hits import WatchedHits
from app.watch.words import plain

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
