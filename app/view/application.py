"""Qt begun, or the reason why it cannot be."""

import os
from typing import TYPE_CHECKING

import click

from app.view.display import display_fault

if TYPE_CHECKING:
    from PySide6.QtCore import QMessageLogContext, QtMsgType
    from PySide6.QtWidgets import QApplication

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
