"""What takes a while made in a thread, so that the window goes on."""

from collections.abc import Callable

from PySide6.QtCore import QThread, Signal
from PySide6.QtWidgets import QLabel, QWidget

from analysis.progress import Progress


class Maker(QThread):
    """Makes one thing for a widget, which waits for it before it goes.

    Parameters
    ----------
    task : callable
        Makes it, telling how far it is.
    shown : QLabel
        Shows how far, or what went wrong.
    owner : QWidget

    Attributes
    ----------
    progressed : Signal(str)
        How far it is.
    made, failed : Signal(object)
        The thing, or the words of an error.
    """

    progressed = Signal(str)
    made = Signal(object)
    failed = Signal(object)

    def __init__(self, task: Callable[[Progress], object], shown: QLabel, owner: QWidget) -> None:
        super().__init__(owner)
        self._task = task
        self.progressed.connect(shown.setText)
        self.failed.connect(shown.setText)
        owner.destroyed.connect(self.wait)

    def hand_to(self, take: Callable[..., None]) -> None:
        """Begin, and hand over what is made."""
        self.made.connect(take)
        self.start()

    def run(self) -> None:
        """Work in the thread."""
        try:
            self.made.emit(self._task(lambda stage, share: self.progressed.emit(f"{stage}: {100 * share:.0f} %")))
        except (OSError, ValueError) as error:
            self.failed.emit(str(error))
