"""The watcher's process: looks, serves the page, tells messages, until it is ended."""

import json
import os
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.files.folder_lock import is_being_written
from app.watch.notifiers import Messenger, Notifier
from app.watch.server import Published, WatchServer, is_loopback, metrics, open_server
from app.watch.status import CampaignStatus
from app.watch.watcher import LOOK_INTERVAL, Watcher
from app.watch.words import plain

AT_LEAST_EVERY = 5.0
"""Seconds after which a state is sent that has not changed: pages see that the watcher lives."""
CLOSING_GRACE = 15.0
"""Seconds for which a campaign's own watcher stays after its end: the pages that are open show how it ended."""
DELIVERED_WITHIN = 200.0
"""Seconds for which it stays to deliver messages: all attempts of one."""
MOST_NOTES, LONGEST_NOTE = 20, 190
"""Sentences for the campaign's process, and bytes of each: a pipe holds all, on Windows 4096 bytes."""
NICENESS = 10
"""It gives way to a campaign on the same computer."""


@dataclass(frozen=True)
class Page:
    """Where the page is served.

    Attributes
    ----------
    host : str
    port : int or None
        None: the first free one.
    token : str or None
    """

    host: str = "127.0.0.1"
    port: int | None = None
    token: str | None = None


class CampaignsProcess:
    """The process that started this one: whether it is there, and what it is told, which never waits for it.

    It may be gone, stopped, or read no more: what it is told fits into a pipe that nobody empties.
    """

    def __init__(self) -> None:
        self.left = threading.Event()
        self._notes = os.dup(2)
        self._turn, self._count = threading.Lock(), 0
        threading.Thread(target=self._wait, name="whether the campaign's process is there", daemon=True).start()

    def leave_streams(self) -> None:
        """Write nothing to it from now on but notes."""
        sys.stdout.flush()
        sys.stderr.flush()
        nothing = os.open(os.devnull, os.O_WRONLY)
        for stream in (1, 2):
            os.dup2(nothing, stream)
        os.close(nothing)

    def note(self, text: str) -> None:
        """Tell it a sentence, one line; of many the first, for the page counts them all."""
        with self._turn:
            self._count += 1
            if self._count > MOST_NOTES or self._notes < 0:
                return
            said = plain(text) if self._count < MOST_NOTES else "more could not be told; the page counts them"
            line = said.encode(errors="replace")[:LONGEST_NOTE] + b"\n"
            with suppress(OSError):
                os.write(self._notes, line)

    def end(self) -> None:
        """Tell it nothing more: it need not wait."""
        with self._turn:
            if self._notes >= 0:
                os.close(self._notes)
            self._notes = -1

    def _wait(self) -> None:
        with suppress(OSError, ValueError):
            while os.read(0, 4096):
                pass
        self.left.set()


class Watching:
    """Campaigns watched, with their page.

    Parameters
    ----------
    folders : sequence of Path
    page : Page
    notifiers : sequence of Notifier
    complain : callable
        Told what could not be delivered.

    Attributes
    ----------
    url : str
        Of the page, without a token.

    Raises
    ------
    NoPortError
        If the page cannot be served there.
    """

    def __init__(
        self, folders: Sequence[Path], page: Page, notifiers: Sequence[Notifier], complain: Callable[[str], None]
    ) -> None:
        self._folders = tuple(folders)
        self._messenger = Messenger(notifiers, complain)
        self._watcher = Watcher(folders, self._messenger.tell)
        self._published = Published()
        self._sent: dict[str, Any] = {}
        self._sent_at = -AT_LEAST_EVERY
        self._server: WatchServer = open_server(
            page.host, page.port, self._published, self._watcher.charts, page.token
        )
        host = page.host if not is_loopback(page.host) or ":" in page.host else "127.0.0.1"
        self.url = f"http://{f'[{host}]' if ':' in host else host}:{self._server.server_port}/"

    def run(self, started_by: CampaignsProcess | None = None) -> None:
        """Watch until KeyboardInterrupt; beside a campaign, until its process has left and all have ended."""
        if hasattr(os, "nice"):
            with suppress(OSError):
                os.nice(NICENESS)
        self._look()
        threading.Thread(target=self._server.serve_forever, name="page", daemon=True).start()
        over: float | None = None
        try:
            while over is None or time.monotonic() - over < CLOSING_GRACE:
                time.sleep(LOOK_INTERVAL)
                statuses = self._look()
                if started_by is None or not started_by.left.is_set() or not self._all_over(statuses):
                    over = None
                    continue
                over = over or time.monotonic()
                untold = self._messenger.untold()
                if untold is not None:
                    for one in untold:
                        started_by.note(one)
                    started_by.end()
            self._messenger.wait(DELIVERED_WITHIN)
        finally:
            self._published.end()
            self._messenger.end()
            self._server.shutdown()
            self._server.server_close()

    def _look(self) -> tuple[CampaignStatus, ...]:
        statuses = self._watcher.look()
        messages = {
            "told": self._messenger.delivered,
            "failed": self._messenger.failed,
            "last_failure": self._messenger.last_failure,
        }
        record = self._watcher.record() | {"messages": messages}
        steady = {"messages": messages, "campaigns": [replace(one, silent_for=0.0) for one in statuses]}
        now = time.monotonic()
        if steady != self._sent or now - self._sent_at >= AT_LEAST_EVERY:
            self._sent, self._sent_at = steady, now
            text = metrics(statuses, self._messenger.delivered, self._messenger.failed)
            self._published.publish(json.dumps(record, allow_nan=False).encode(), text.encode())
        return statuses

    def _all_over(self, statuses: Sequence[CampaignStatus]) -> bool:
        """Whether no campaign can come to anything more: ended, or silent because its process is gone."""
        return not any(
            one.state in ("running", "pausing", "paused")
            or (one.state in ("not begun", "silent") and is_being_written(folder))
            for one, folder in zip(statuses, self._folders, strict=True)
        )
