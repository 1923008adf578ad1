"""What takes a while made in a thread, so that the window goes on."""

from collections.abc import Callable

from PySide6.QtCore import QObject, QThread, Signal

from app.progress import Report


class Maker(QThread):
    """Makes one thing.

    Attributes
    ----------
    told : Signal(str)
        How far it is.
    made, failed : Signal(object)
        The thing, or the words of an error.
    """

    told = Signal(str)
    made = Signal(object)
    failed = Signal(object)

    def __init__(self, task: Callable[[Report], object], parent: QObject) -> None:
        super().__init__(parent)
        self._task = task

    def run(self) -> None:
        """Work in the thread."""
        try:
            self.made.emit(self._task(lambda stage, share: self.told.emit(f"{stage}: {100 * share:.0f} %")))
        except (OSError, ValueError) as error:
            self.failed.emit(str(error))
