"""Which window a folder is shown in."""

import time
from typing import TYPE_CHECKING, Literal

from app.files.bad_file import ResultFileError
from app.files.campaign_kind import is_campaign_folder
from app.files.run_folder import is_test_run
from app.view.folder import Viewed
from app.view.theme import Theme
from app.view.window import Window

if TYPE_CHECKING:
    from app.watch.watched import Watched

Kind = Literal["live", "recorded"]


def window_of(viewed: Viewed, kind: Kind | None, theme: Theme) -> Window:
    """Build the window asked for, or else the one that fits.

    A campaign that is under way, or that was acquired and has no result yet, is shown live; results of a modal
    test in a window of their own; all else recorded.

    Parameters
    ----------
    viewed : Viewed
        Campaign and run that were found.
    kind : str or None
        ``live`` or ``recorded``; None for the one that fits.
    theme : Theme

    Returns
    -------
    Window

    Raises
    ------
    ResultFileError
        If a live window is asked for of something that no rig writes.
    """
    if viewed.campaign is None and viewed.run is not None and is_test_run(viewed.run):
        if kind == "live":
            raise ResultFileError(f"{viewed.run}: results of a modal test, nothing is live in it")
        from app.view.test_run.window import TestWindow

        return TestWindow(viewed.run, theme)
    watched = _watched(viewed)
    if kind == "live" and watched is None:
        raise ResultFileError(
            f"{viewed.campaign or viewed.run}: no campaign of flexura acquire, nothing is live in it"
        )
    if watched is not None and kind != "recorded":
        from app.view.live.window import UNDER_WAY, LiveWindow

        watched.look()
        if kind == "live" or viewed.run is None or watched.state(time.time()) in UNDER_WAY:
            return LiveWindow(watched, theme)
    from app.view.recorded.window import RecordedWindow

    return RecordedWindow(viewed, theme)


def _watched(viewed: Viewed) -> "Watched | None":
    if viewed.campaign is None or not is_campaign_folder(viewed.campaign):
        return None
    from app.watch.watched import Watched

    found = Watched(viewed.campaign)
    return found if found.protocol is not None else None
