"""Pictures of all windows for the documentation."""

import re
import time
from pathlib import Path

from PySide6.QtWidgets import QApplication

from analysis.progress import Progress
from app.view.live.hammer_window import HammerWindow
from app.view.live.window import LiveWindow
from app.view.recorded.fields_page import FieldsPage
from app.view.recorded.modes_page import ModesPage
from app.view.recorded.window import RecordedWindow
from app.view.test_run.window import TestWindow
from app.view.window import Window, picture
from app.watch.watched import AT_A_TIME, FRFS_SHOWN

TWIN_TIMEOUT = 600.0
"""Seconds that a twin may take to be reduced."""
DOTS_PER_POINT = 1.25


def screenshots(window: Window, folder: Path, report: Progress) -> list[Path]:
    """Write every page of a window as PNG into a folder.

    Parameters
    ----------
    report : callable
        Called with the stage's name and the share done.

    Returns
    -------
    list of Path
        The files.
    """
    report("pages", 0.0)
    window.show()
    if isinstance(window, LiveWindow):
        for _ in range(FRFS_SHOWN // AT_A_TIME):
            window.look()
    if isinstance(window, TestWindow):
        return [_page(window, n, folder, report) for n in range(window.tabs.count())]
    if not isinstance(window, RecordedWindow):
        name = "hammer" if isinstance(window, HammerWindow) else "live"
        return [_shot(window, folder / f"view-{name}-{window.theme.name}.png")]
    written = []
    for number in range(window.tabs.count()):
        page = window.page(number)
        begun = time.monotonic()
        while (
            isinstance(page, ModesPage | FieldsPage) and not page.ready and time.monotonic() - begun < TWIN_TIMEOUT
        ):
            QApplication.processEvents()
            time.sleep(0.02)
        name = re.sub(r"\W+", "-", window.tabs.tabText(number).lower())
        written.append(_shot(window, folder / f"view-{name}-{window.theme.name}.png"))
        report("pages", (number + 1) / window.tabs.count())
    return written


def _page(window: TestWindow, number: int, folder: Path, report: Progress) -> Path:
    window.tabs.setCurrentIndex(number)
    name = window.tabs.tabText(number).lower()
    written = _shot(window, folder / f"view-test-{name}-{window.theme.name}.png")
    report("pages", (number + 1) / window.tabs.count())
    return written


def _shot(window: Window, target: Path) -> Path:
    for _ in range(5):  # layouts settle over a few rounds
        QApplication.processEvents()
    picture(window, DOTS_PER_POINT, target)
    return target
