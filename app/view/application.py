"""Qt begun, or the reason why it cannot be: it ends the process by SIGABRT where no window can be opened.

Garbage is collected in the thread of the windows alone. Python collects wherever memory happens to be asked for.
In a thread that computes, that would take windows apart which belong to another, and Qt does not survive it.
"""

import gc
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click
from PySide6.QtCore import QTimer

if TYPE_CHECKING:
    from PySide6.QtCore import QMessageLogContext, QtMsgType
    from PySide6.QtWidgets import QApplication


DRAWS_INTO_MEMORY = ("offscreen", "minimal")
DESKTOP_TIMEOUT = 30.0
"""Seconds: a desktop answers within one, one at the other end of a slow network in a few."""
TRIAL = "from PySide6.QtGui import QGuiApplication; QGuiApplication(['flexura'])"
ONWARD = (
    "--screenshot DIR writes every page as a picture and needs no display; to see the window, log in with ssh -X "
    "(X forwarding), or call flexura view on a computer with a desktop"
)


def display_fault() -> str | None:
    """Return why no window can be opened, and what to do; None where one can.

    A display that is named may be gone, or refuse this user, and a part of Qt's own may be missing: it is opened
    in a process of its own first. Windows and macOS always have one.
    """
    chosen = os.environ.get("QT_QPA_PLATFORM", "").partition(":")[0]
    if chosen in DRAWS_INTO_MEMORY or (not chosen and sys.platform in ("win32", "darwin")):
        return None
    try:
        tried = subprocess.run(  # noqa: S603 (words of ours)
            [sys.executable, "-P", "-c", TRIAL],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=DESKTOP_TIMEOUT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"no window can be opened: {_named()} does not answer within {DESKTOP_TIMEOUT:.0f} s; {ONWARD}"
    return None if tried.returncode == 0 else f"no window can be opened: {_unusable(chosen)}; {ONWARD}"


def _unusable(chosen: str) -> str:
    if chosen:
        return f"QT_QPA_PLATFORM = {chosen} cannot be used here"
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return "there is no display (neither DISPLAY nor WAYLAND_DISPLAY is set)"
    return f"{_named()} cannot be opened (if it is there: apt install libxcb-cursor0, which Qt needs)"


def _named() -> str:
    names = [f"{name}={os.environ[name]}" for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)]
    return f"the display {' '.join(names)}" if names else "the display"


LIBRARIES = "libegl1 libgl1 libx11-6 libxkbcommon0 libdbus-1-3 libfontconfig1 libglib2.0-0"
"""What Qt's wheels need of a Debian that has never had a screen; a desktop has them all."""


def application() -> "QApplication":
    """Return the application, begun if need be.

    Raises ClickException where this system lacks what Qt needs, or a display. Where there is none,
    ``QT_QPA_PLATFORM=offscreen`` lets Qt draw into memory.
    """
    os.environ.setdefault("PYQTGRAPH_QT_LIB", "PySide6")  # whatever other binding may be about
    try:
        import pyqtgraph
        from PySide6.QtCore import qInstallMessageHandler
        from PySide6.QtWidgets import QApplication
    except ImportError as error:
        raise click.ClickException(
            f"Qt cannot be loaded ({error}). On a Debian or Ubuntu without a desktop: "
            f"apt install {LIBRARIES}; everything but flexura view works without"
        ) from error
    pyqtgraph.setConfigOptions(antialias=True, imageAxisOrder="row-major", exitCleanup=False)
    running = QApplication.instance()
    if isinstance(running, QApplication):
        return running
    fault = display_fault()
    if fault is not None:
        raise click.ClickException(fault)
    qInstallMessageHandler(_message)
    begun = QApplication(["flexura"])
    begun.setApplicationDisplayName("Flexura")
    begun.setStyle("Fusion")
    return begun


def _message(kind: "QtMsgType", context: "QMessageLogContext", text: str) -> None:
    """Pass on messages of Qt, except those on functions that a plugin without a screen does not have."""
    from PySide6.QtCore import qFormatLogMessage

    if not text.startswith("This plugin does not support"):
        click.echo(qFormatLogMessage(kind, context, text), err=True)


LOOK_INTERVAL = 200
"""Milliseconds between two looks."""


@contextmanager
def collected_here() -> Iterator[None]:
    """Collect from this thread's event loop, and from nowhere else, within the block."""
    timer = QTimer()
    timer.timeout.connect(collect)
    gc.disable()
    timer.start(LOOK_INTERVAL)
    try:
        yield
    finally:
        timer.stop()
        gc.enable()


def collect() -> None:
    """Collect the oldest generation that is due, as Python would."""
    for generation in (2, 1, 0):
        if gc.get_count()[generation] > gc.get_threshold()[generation]:
            gc.collect(generation)
            return
