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

AT_LEAST_EVERY = 5.0
"""Seconds after which a state is sent that has not changed: pages see that the watcher lives."""
CLOSING_GRACE = 15.0
"""Seconds for which a campaign's own watcher stays after its end: the pages that are open show how it ended."""
DELIVERED_WITHIN = 200.0
"""Seconds for which it stays to deliver messages: all attempts of one."""
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

    def run(self, left: threading.Event | None = None) -> None:
        """Watch until KeyboardInterrupt; where `left` is given, until it is set and all campaigns have ended."""
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
                if left is None or not left.is_set() or not self._all_over(statuses):
                    over = None
                elif over is None:
                    over = time.monotonic()
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


def left_behind() -> threading.Event:
    """Return an event that is set when the standard input ends: the process that started this one is gone."""
    left = threading.Event()

    def wait() -> None:
        with suppress(OSError, ValueError):
            while os.read(0, 4096):
                pass
        left.set()

    threading.Thread(target=wait, name="whether the campaign's process is there", daemon=True).start()
    return left


def leave_streams() -> None:
    """Write nothing to the process that started this one from now on: it may be gone, or read no more."""
    sys.stdout.flush()
    sys.stderr.flush()
    nothing = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nothing, stream)
    os.close(nothing)
