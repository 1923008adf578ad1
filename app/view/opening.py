"""Which window a folder is shown in."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import is_campaign_folder, is_hammer_folder
from app.files.folder_lock import is_being_written
from app.files.results.run_folder import is_test_run
from app.view.folder import Viewed, viewed
from app.view.theme import Theme
from app.view.window import Window

if TYPE_CHECKING:
    from app.watch.watched import Watched

Kind = Literal["live", "recorded"]


def window_of(found: Viewed, kind: Kind | None, theme: Theme, beside: Path | None = None) -> Window:
    """Build the window asked for, or else the one that fits.

    A campaign that is under way, or that was acquired and has no result yet, is shown live; results of a modal
    test in a window of their own; all else recorded.

    Parameters
    ----------
    found : Viewed
        Campaign and run that were found.
    kind : str or None
        ``live`` or ``recorded``; None for the one that fits.
    beside : Path, optional
        Run folder of a modal test, or of flexura update, whose modes are set beside those of the test that was
        found.

    Raises
    ------
    ResultFileError
        If a live window is asked for of something that no rig writes, and for a run beside what is no modal test.
    """
    window = _fitting(found, kind, theme, beside)
    window.folder_chosen.connect(_try_beside)  # the window is an argument: a closure would keep it for ever
    return window


def open_beside(window: Window, folder: Path) -> Window:
    """Show a campaign or run folder in a window of its own, in the same theme; ResultFileError for others."""
    another = window_of(viewed(folder), None, window.theme)
    window.beside.append(another)
    another.show()
    return another


def _try_beside(window: Window, folder: Path) -> None:
    try:
        open_beside(window, folder)
    except (OSError, ResultFileError) as error:
        window.statusBar().showMessage(str(error))


def _fitting(found: Viewed, kind: Kind | None, theme: Theme, beside: Path | None) -> Window:
    if found.campaign is None and found.run is not None and is_test_run(found.run):
        if kind == "live":
            raise ResultFileError(f"{found.run}: results of a modal test, nothing is live in it")
        from app.view.test_run.window import TestWindow

        return TestWindow(found.run, theme, beside)
    if beside is not None:
        raise ResultFileError(
            f"{found.run or found.campaign}: no run of a modal test, whose modes could be compared with {beside}"
        )
    if found.campaign is not None and is_hammer_folder(found.campaign):
        under_way = found.run is None or is_being_written(found.campaign)
        if kind == "live" or (kind is None and under_way):
            from app.view.live.hammer_window import HammerWindow
            from app.watch.watched_hits import WatchedHits

            return HammerWindow(WatchedHits(found.campaign), theme)
    watched = _watched(found)
    if kind == "live" and watched is None:
        raise ResultFileError(
            f"{found.campaign or found.run}: no campaign of flexura acquire, nothing is live in it"
        )
    if watched is not None and kind != "recorded":
        from app.view.live.window import UNDER_WAY, LiveWindow

        watched.look()
        if kind == "live" or found.run is None or watched.state(time.time()) in UNDER_WAY:
            return LiveWindow(watched, theme)
    from app.view.recorded.window import RecordedWindow

    return RecordedWindow(found, theme)


def _watched(found: Viewed) -> "Watched | None":
    if found.campaign is None or not is_campaign_folder(found.campaign):
        return None
    from app.watch.watched import Watched

    watched = Watched(found.campaign)
    return watched if watched.protocol is not None else None
