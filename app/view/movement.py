"""Pictures that follow each other, until somebody wants them to stand still."""

from collections.abc import Callable

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QPushButton, QWidget

FRAME_INTERVAL = 33
"""Milliseconds from one picture to the next."""


class Movement(QTimer):
    """Asks for the next picture.

    Parameters
    ----------
    parent : QWidget
    advance : callable
        Shows it.
    button : QPushButton, optional
        Starts and stops the movement, and says which of both it would do.
    """

    def __init__(self, parent: QWidget, advance: Callable[[], None], button: QPushButton | None = None) -> None:
        super().__init__(parent)
        self.setInterval(FRAME_INTERVAL)
        self.timeout.connect(advance)
        self._button = button
        if button is not None:
            button.clicked.connect(self.toggle)

    def toggle(self) -> None:
        """Let the pictures move, or stand still."""
        self.go(not self.isActive())

    def go(self, moving: bool) -> None:
        """Let them do one of both."""
        if moving:
            self.start()
        else:
            self.stop()
        if self._button is not None:
            self._button.setText("Still" if moving else "Move")
