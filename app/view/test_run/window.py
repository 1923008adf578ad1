"""The window on a modal test."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QTabWidget, QWidget

from app.files.bad_file import ResultFileError
from app.files.campaigns.inputs import origin_of_result
from app.files.results.best_twin import PLAIN
from app.files.results.run_folder import is_test_run
from app.modal_test.edit_journal import FOLDER, EditJournal
from app.modal_test.edits import add_mode, drop_mode, redo_edit, undo_edit
from app.view.cursors import Cursors
from app.view.folder import viewed
from app.view.recorded.results import Results
from app.view.test_run.compared_page import ComparedPage
from app.view.test_run.frf_page import TestFrfPage
from app.view.test_run.held import HeldTest
from app.view.test_run.modes_page import TestModesPage
from app.view.theme import Theme
from app.view.twin_page import TwinPage
from app.view.window import Window


@dataclass(frozen=True)
class TwinBeside:
    """Modes of a plate's twin beside those measured on the plate.

    Attributes
    ----------
    run : Path
        Folder of flexura update.
    pairing : mapping
        Of `app.files.results.pairing_json.pairing_record`.
    """

    run: Path
    pairing: Mapping[str, Any]

    def said_beside(self, test: Path) -> str:
        """Say whether the twin was updated with the files that a test's run was made from."""
        mine = set(origin_of_result(test / "transfers.h5", "identify").inputs.values())
        same = mine & set(origin_of_result(self.run / PLAIN, "update").inputs.values())
        if same:
            return f"Twin of {self.run.name}, updated with the recordings of this test."
        return f"Twin of {self.run.name}, updated with other recordings than this test's: not its modes."


def other_modes(folder: Path) -> HeldTest | TwinBeside:
    """Read the modes of a test's run, or of the twin in a campaign's; ResultFileError where there are none."""
    if is_test_run(folder):
        return HeldTest.read(folder)
    found = viewed(folder)
    results = Results(found)
    pairing = results.pairing
    if found.run is not None and pairing is not None:
        return TwinBeside(found.run, pairing)
    if results.problems:
        raise ResultFileError("; ".join(f"{folder}: {name}: {what}" for name, what in results.problems.items()))
    raise ResultFileError(
        f"{folder}: holds no modes to be compared; name the run folder of flexura identify TEST.toml, or that of "
        "flexura update with an FRF of the plate"
    )


class TestWindow(Window):
    """FRFs and modes of a run of a test, which can be changed from here.

    Parameters
    ----------
    run : Path
        Its folder.
    theme : Theme
    beside : Path, optional
        Run folder of a test, or of a plate's twin, whose modes are set beside these.

    Raises
    ------
    ResultFileError
        Where a file of a run is missing or damaged.
    """

    __test__ = False

    def __init__(self, run: Path, theme: Theme, beside: Path | None = None) -> None:
        self.held, self.other = HeldTest.read(run), None if beside is None else other_modes(beside)
        super().__init__(f"{self.held.frfs.title} – Flexura", theme)
        loudest = int(np.abs(self.held.frfs.h).max(axis=0).argmax())
        self.cursors = Cursors(float(self.held.frfs.frequency[loudest]), self.held.frfs.temperature)
        self._number = 0
        for number in (1, 2, 3):
            self.bind(f"Page {number}", str(number), lambda n=number: self.tabs.setCurrentIndex(n - 1))  # type: ignore[misc]
        for text, key, lines in (
            ("Cursor down", "Left", -1),
            ("Cursor up", "Right", 1),
            ("Cursor down, ten lines", "Shift+Left", -10),
            ("Cursor up, ten lines", "Shift+Right", 10),
        ):
            self.bind(text, key, lambda lines=lines: self.frfs.axis.step(lines))  # type: ignore[misc]
        self.bind("Mark at the cursor, differences from there", "M", lambda: self.frfs.mark())
        self.bind("Logarithmic frequencies", "L", lambda: self.frfs.axis.toggle())
        self.bind("Mode before", "[", lambda: self.modes.step(-1))
        self.bind("Mode after", "]", lambda: self.modes.step(1))
        self.bind("Let the shape move, or stand still", "Space", lambda: self.modes.play_or_stop())
        self._undo = self.bind("Undo the last change of the modes", "Ctrl+Z", self.undo, self._file)
        self._redo = self.bind("Redo it", "Ctrl+Shift+Z", self.redo, self._file)
        self.bind(
            "Compare with the modes of another run, or of a twin …", "Ctrl+M", self._ask_and_compare, self._file
        )
        self.build()

    def content(self) -> QWidget:
        """Return the pages."""
        self._name_changes()
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.frfs = TestFrfPage(self.held, self.cursors, self.theme)
        self.modes = TestModesPage(
            self.held, self.cursors, self.theme, self.ask_and_drop, self.add, self._undo, self._redo
        )
        self.tabs.addTab(self.frfs, "FRFs")
        self.tabs.addTab(self.modes, "Modes")
        pages: list[QWidget] = [self.frfs, self.modes]
        if self.other is not None:
            self.compared = (
                ComparedPage(self.held, self.other, self.theme)
                if isinstance(self.other, HeldTest)
                else TwinPage(self.other.pairing, self.theme, self.other.said_beside(self.held.run))
            )
            self.tabs.addTab(self.compared, "Compared" if isinstance(self.other, HeldTest) else "Twin")
            pages.append(self.compared)
        self.tabs.setCurrentIndex(self._number)
        self.tabs.currentChanged.connect(self._remember)
        for page in pages:
            self.adopt(page)
        return self.tabs

    def compare(self, run: Path) -> None:
        """Set the modes of another run beside these; ResultFileError where it has none, see `other_modes`."""
        self.other, self._number = other_modes(run), 2
        self.build()

    def _ask_and_compare(self) -> None:
        folder = QFileDialog.getExistingDirectory(self, "Run folder of the other test, or of flexura update")
        if folder:
            try:
                self.compare(Path(folder))
            except (OSError, ResultFileError) as error:
                self.statusBar().showMessage(str(error))

    def ask_and_drop(self, frequency: float) -> None:
        """Drop the mode nearest to a frequency, Hz, once that is confirmed."""
        answer = QMessageBox.question(
            self,
            "Drop the mode?",
            f"The mode at {frequency:.3f} Hz is taken out of {self.held.run}; the other modes stay as they are. "
            "Ctrl+Z takes it back.",
        )
        if answer == QMessageBox.StandardButton.Yes:
            self.drop(frequency)

    def undo(self) -> None:
        """Take the last change by hand back."""
        self._change(lambda run, _: f"undone: {undo_edit(run)}", math.nan)

    def redo(self) -> None:
        """Make the change that was taken back last again."""
        self._change(lambda run, _: f"made again: {redo_edit(run)}", math.nan)

    def _name_changes(self) -> None:
        """Say in the menu what undo and redo would do."""
        journal = EditJournal(self.held.run)
        for action, word, what in ((self._undo, "Undo", journal.undone), (self._redo, "Redo", journal.redone)):
            action.setEnabled(what is not None)
            action.setToolTip(f"{word}: {what}" if what is not None else f"{word}: nothing")

    def drop(self, frequency: float) -> None:
        """Drop the mode nearest to a frequency, Hz, and show what is left."""
        self._change(drop_mode, frequency)

    def add(self, frequency: float) -> None:
        """Add a mode at a frequency, Hz, and show what came of it."""
        self._change(add_mode, frequency)

    def _change(self, change: Callable[[Path, float], str], frequency: float) -> None:
        QApplication.setOverrideCursor(Qt.CursorShape.WaitCursor)
        try:
            message = change(self.held.run, frequency)
            self.held = HeldTest.read(self.held.run)
        except (OSError, ResultFileError) as error:
            QMessageBox.warning(self, "Not changed", str(error))
            return
        finally:
            QApplication.restoreOverrideCursor()
        self.build()
        self.statusBar().showMessage(f"{message}; recorded in {self.held.run / FOLDER}")

    def _remember(self, number: int) -> None:
        self._number = number
