"""The window on a recorded campaign: a page for each result that is there."""

from collections.abc import Callable

import numpy as np
from PySide6.QtWidgets import QLabel, QTabWidget, QVBoxLayout, QWidget

from app.summaries.gap import modes_before
from app.view.cursors import Cursors
from app.view.folder import Viewed
from app.view.recorded.fields_page import FieldsPage
from app.view.recorded.focusing_page import FocusingPage
from app.view.recorded.frf_page import FrfPage
from app.view.recorded.laws_page import LawsPage
from app.view.recorded.mode_shape import ModeShape
from app.view.recorded.modes_page import ModesPage
from app.view.recorded.results import Results
from app.view.theme import Theme
from app.view.twin_page import TwinPage
from app.view.window import Window


class RecordedWindow(Window):
    """Pages that share their cursors; each is built when it is first looked at.

    Parameters
    ----------
    viewed : Viewed
    theme : Theme
    """

    def __init__(self, viewed: Viewed, theme: Theme) -> None:
        super().__init__(f"{viewed.name} – Flexura", theme)
        self._viewed = viewed
        self.results = Results(viewed)
        if self.results.extent is not None:
            self.setWindowTitle(f"{viewed.name} – {self.results.extent.said} – Flexura")
        self.cursors = self._cursors()
        self._number = 0
        self._bind_keys()
        self.build()

    def content(self) -> QWidget:
        """Tabs under what cannot be read, if anything cannot."""
        whole = QWidget()
        layout = QVBoxLayout(whole)
        layout.setContentsMargins(0, 0, 0, 0)
        self._trouble = QLabel()
        self._trouble.setObjectName("trouble")
        self._trouble.setWordWrap(True)
        self._trouble.setStyleSheet(f"color: {self.theme.warning}; padding: 6px;")
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self._pages = self._offered()
        for title in self._pages:
            self.tabs.addTab(QWidget(), title)
        self._built: dict[int, QWidget] = {}
        layout.addWidget(self._trouble)
        layout.addWidget(self.tabs)
        self.tabs.currentChanged.connect(self._show_page)
        self.tabs.setCurrentIndex(self._number)
        self._show_page(self.tabs.currentIndex())
        return whole

    def page(self, number: int) -> QWidget | None:
        """Go to a page and return it; None where its file cannot be read."""
        self.tabs.setCurrentIndex(number)
        return self._built.get(number)

    def _offered(self) -> dict[str, Callable[[], QWidget | None]]:
        offered: list[tuple[str, bool, Callable[[], QWidget | None]]] = [
            ("FRFs", self._viewed.campaign is not None or self.results.has("frf.h5"), self._frf_page),
            ("Modes", self.results.has("modes.h5"), self._modes_page),
            ("Laws", self.results.has("laws.h5"), self._laws_page),
            ("Twin", self.results.pairing is not None, self._twin_page),
            ("Gap", self.results.has("gap.h5"), self._gap_page),
            ("Focusing", self.results.has("filters.h5"), self._focusing_page),
            ("Fields", self.results.has("filters.h5"), self._fields_page),
        ]
        return {title: build for title, there, build in offered if there}

    def _show_page(self, number: int) -> None:
        holder = self.tabs.widget(number)
        if holder is None:
            return
        self._number = number
        if number not in self._built:
            page = list(self._pages.values())[number]()
            if page is not None:
                self._built[number] = page
                QVBoxLayout(holder).addWidget(page)
                self.adopt(page)
        trouble = self.results.outdated | self.results.problems
        self._trouble.setText("\n".join(f"{name}: {what}" for name, what in trouble.items()))
        self._trouble.setVisible(bool(trouble))

    def _frf_page(self) -> QWidget | None:
        held = self.results.measured
        return None if held is None else FrfPage(held[1], self.results, self.cursors, self.theme)

    def _modes_page(self) -> QWidget | None:
        held = self.results.modes
        if held is None:
            return None
        if not held.track.shape[1]:
            self.results.problems["modes.h5"] = "no modes were found"
            return None
        measured, laws = self.results.measured, self.results.laws
        shape = None if measured is None or laws is None else ModeShape(measured[0], laws, self.theme)
        return ModesPage(held, shape, self.cursors, self.theme)

    def _laws_page(self) -> QWidget | None:
        best = self.results.best
        return None if best is None else LawsPage(best, self.cursors, self.theme)

    def _twin_page(self) -> QWidget | None:
        held = self.results.pairing
        if held is None:
            return None
        gap = self.results.gap if self.results.corrected is not None else None
        return TwinPage(held, self.theme, before="" if gap is None else modes_before(gap[1]))

    def _gap_page(self) -> QWidget | None:
        from app.view.recorded.gap_page import GapPage

        held = self.results.gap
        return (
            None if held is None else GapPage(held[0], self.results.signatures, held[1], self.cursors, self.theme)
        )

    def _focusing_page(self) -> QWidget | None:
        held = self.results.focusing
        if held is None:
            return None
        results = self.results
        return FocusingPage(held[1], results.compensation, self.cursors, self.theme, results.pareto)

    def _fields_page(self) -> QWidget | None:
        held, laws = self.results.focusing, self.results.panel_laws
        if held is None or laws is None:
            return None
        return FieldsPage(held[0], held[1], laws, self.cursors, self.theme)

    def _cursors(self) -> Cursors:
        """Begin at the loudest line in the middle of the temperatures."""
        held = self.results.measured
        if held is None:
            return Cursors(100.0, 20.0)
        frf = held[1]
        row = int(np.argsort(frf.temperature, kind="stable")[len(frf.temperature) // 2])
        return Cursors(float(frf.frequency[np.abs(frf.h[row, 0]).argmax()]), float(frf.temperature[row]))

    def _bind_keys(self) -> None:
        for number in range(1, 8):
            self.bind(f"Page {number}", str(number), lambda n=number: self.tabs.setCurrentIndex(n - 1))  # type: ignore[misc]
        for text, key, lines, sweeps in (
            ("Frequency cursor down", "Left", -1, 0),
            ("Frequency cursor up", "Right", 1, 0),
            ("Frequency cursor down, ten lines", "Shift+Left", -10, 0),
            ("Frequency cursor up, ten lines", "Shift+Right", 10, 0),
            ("Temperature cursor down", "Down", 0, -1),
            ("Temperature cursor up", "Up", 0, 1),
        ):
            self.bind(text, key, lambda lines=lines, sweeps=sweeps: self._step(lines, sweeps))  # type: ignore[misc]
        self.bind("Mark the position of the cursors, from which differences are given", "M", self._put_mark)
        self.bind("Logarithmic frequencies", "L", self._toggle_log)
        self.bind("Mode before", "[", lambda: self._step_mode(-1))
        self.bind("Mode after", "]", lambda: self._step_mode(1))
        self.bind("Fields move, or stop", "Space", self._play)

    def _step(self, lines: int, sweeps: int) -> None:
        for page in self._built.values():
            if isinstance(page, FrfPage):
                page.step(lines, sweeps)

    def _put_mark(self) -> None:
        for page in self._built.values():
            if isinstance(page, FrfPage):
                page.mark()

    def _toggle_log(self) -> None:
        for page in self._built.values():
            if isinstance(page, FrfPage):
                page.axis.toggle()

    def _step_mode(self, by: int) -> None:
        page = self._built.get(self.tabs.currentIndex())
        if isinstance(page, ModesPage | FieldsPage):
            page.step(by)

    def _play(self) -> None:
        page = self._built.get(self.tabs.currentIndex())
        if isinstance(page, FieldsPage):
            page.play_or_stop()
        elif isinstance(page, ModesPage) and page.shape is not None:
            page.shape.play_or_stop()
