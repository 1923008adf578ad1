"""Modes of a test: table, stabilization chart under the indicator function, AutoMAC, shape; changes by hand."""

from collections.abc import Callable

import numpy as np
import pyqtgraph
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from analysis.shapes.assurance import mac
from analysis.shapes.stabilization import cmif
from app.modal_test.records import AXIS, MODE_HEADINGS, mode_names, mode_rows
from app.summaries.modes import READ_AS
from app.view.chart import Chart
from app.view.cursors import FREQUENCY, Cursors
from app.view.mac_chart import MacChart
from app.view.mode_table import ModeTable
from app.view.surface import TURN, Movement
from app.view.test_run.held import HeldTest
from app.view.test_run.shape_chart import MovingShape, ShapeChart
from app.view.theme import Theme

ORDERS = "poles over the order: full dots stable, rings in frequency only"
CMIF_SHOWN = 3
"""Singular values drawn: each further one shows one more mode at the same line."""
SHOWN_AS = ("moving wire frame", "values at the points")


class TestModesPage(QWidget):
    """All modes at once, one selected.

    Parameters
    ----------
    held : HeldTest
    cursors : Cursors
    theme : Theme
    drop, add : callable
        Called with the frequency, Hz, of a mode to remove or to add.
    undo, redo : QAction
        Of the window; they say what they would take back or make again.
    """

    __test__ = False

    def __init__(
        self,
        held: HeldTest,
        cursors: Cursors,
        theme: Theme,
        drop: Callable[[float], None],
        add: Callable[[float], None],
        undo: QAction,
        redo: QAction,
    ) -> None:
        super().__init__()
        self._held, self._cursors, self._theme = held, cursors, theme
        self.table = ModeTable(MODE_HEADINGS, range(5))
        self.table.setToolTip(READ_AS[held.modes.damping])
        self.table.show_rows(mode_rows(held.modes, held.shapes))
        self.dropping, self.adding = QPushButton("Drop the selected mode"), QPushButton("Add a mode at the cursor")
        self.dropping.clicked.connect(lambda: drop(float(held.places[self.selected])))
        self.undoing, self.redoing = QPushButton("Undo"), QPushButton("Redo")
        for button, action in ((self.undoing, undo), (self.redoing, redo)):
            button.clicked.connect(action.trigger)
            button.setEnabled(action.isEnabled())
            button.setToolTip(action.toolTip())
        self.adding.clicked.connect(lambda: add(cursors.frequency))
        self.dropping.setEnabled(bool(held.modes.real.sum() > 1))
        self.cmif = Chart("test-cmif", "how many modes act: CMIF", FREQUENCY, "dB re the largest", theme)
        self.stabilization = Chart(
            "test-stabilization",
            ORDERS,
            FREQUENCY,
            "pole pairs",
            theme,
        )
        self.alike = MacChart("test-auto-mac", "how alike the shapes are: AutoMAC", AXIS, AXIS, theme)
        self.shape, self.moving = ShapeChart(held, theme), MovingShape(held, theme)
        self.shown_as, self._shapes, self._still = QComboBox(), QStackedWidget(), QPushButton("Still")
        self._movement = Movement(self, self.advance, self._still)
        self._lay_out()
        self._draw()
        self.shown_as.currentIndexChanged.connect(self._show_as)
        self.shown_as.setCurrentIndex(0 if self.moving.useful else 1)
        self._show_as()
        self.table.chosen.connect(lambda _: self._select())
        if len(held.shapes.pole):
            self.table.mark(int(np.abs(held.places - cursors.frequency).argmin()))
            self._select()

    @property
    def selected(self) -> int:
        """Mode that stands out, from 0."""
        return max(self.table.currentRow(), 0)

    def step(self, modes: int) -> None:
        """Select a mode further up or down."""
        if self.table.rowCount():
            self.table.selectRow(int(np.clip(self.selected + modes, 0, self.table.rowCount() - 1)))

    def _select(self) -> None:
        self._cursors.frequency = float(self._held.places[self.selected])
        self.shape.show_shape(self.selected)
        self.moving.show_shape(self.selected)

    def advance(self) -> None:
        """Show the next picture."""
        if self.moving.isVisible():
            self.moving.turn(TURN)

    def play_or_stop(self) -> None:
        """Let the shape move, or stand still."""
        self._movement.toggle()

    def _show_as(self) -> None:
        moving = self.shown_as.currentIndex() == 0
        self._shapes.setCurrentIndex(0 if moving else 1)
        self._still.setVisible(moving)
        self._movement.go(moving)

    def _lay_out(self) -> None:
        left, buttons, grid = QVBoxLayout(), QHBoxLayout(), QGridLayout(self)
        buttons.addWidget(self.dropping)
        buttons.addWidget(self.adding)
        buttons.addWidget(self.undoing)
        buttons.addWidget(self.redoing)
        buttons.addStretch()
        left.addLayout(buttons)  # above what grows and shrinks: a second click meets the same button
        left.addWidget(self.table, stretch=1)
        if self._held.frfs.notes:
            last = QLabel(self._held.frfs.notes[-1])
            last.setWordWrap(True)
            last.setToolTip("\n".join(self._held.frfs.notes))
            left.addWidget(last)
        charts = QVBoxLayout()
        charts.addWidget(self.cmif, stretch=1)
        charts.addWidget(self.stabilization, stretch=1)
        grid.addLayout(left, 0, 0)
        choices, right = QHBoxLayout(), QVBoxLayout()
        if self.moving.useful:
            self.shown_as.addItems(SHOWN_AS)
            choices.addWidget(self.shown_as)
            choices.addWidget(self._still)
            choices.addStretch()
            right.addLayout(choices)
        self._shapes.addWidget(self.moving)
        self._shapes.addWidget(self.shape)
        right.addWidget(self._shapes, stretch=1)
        grid.addLayout(right, 0, 1)
        grid.addLayout(charts, 1, 0)
        grid.addWidget(self.alike, 1, 1)
        for column, share in enumerate((7, 4)):
            grid.setColumnStretch(column, share)
        for row, share in enumerate((4, 5)):
            grid.setRowStretch(row, share)

    def _draw(self) -> None:
        held, theme, frfs = self._held, self._theme, self._held.frfs
        values = cmif(frfs.transfers)
        level = 20.0 * np.log10(np.maximum(values / values.max(), 1e-12))
        for number, row in enumerate(level[:CMIF_SHOWN]):
            self.cmif.curve(frfs.frequency, row, f"singular value {number + 1}", theme.series(number), width=1.3)
        chart = held.chart
        for stable in (0, 1, 2):
            here = chart.stable == stable
            item = pyqtgraph.ScatterPlotItem(
                chart.frequency[here],
                chart.order[here],
                size=8 if stable else 3,
                brush=pyqtgraph.mkBrush(theme.identified if stable == 2 else None),
                pen=pyqtgraph.mkPen(theme.identified if stable else theme.muted),
            )
            self.stabilization.addItem(item)
        if len(chart.order):
            self.stabilization.setYRange(0.0, float(chart.order.max()) + 1.0, padding=0.0)
        for one in (self.cmif, self.stabilization):
            one.getAxis("left").setWidth(62)
            one.follow("x", self._cursors.frequency, self._cursors.frequency_moved, self._go)
        self.stabilization.setXLink(self.cmif)
        self.cmif.fit()
        if len(held.shapes.places) < 2:
            self.alike.setTitle("AutoMAC: one place alone has no shape")
        elif len(held.shapes.pole):
            names = mode_names(held.modes, held.shapes)
            self.alike.show_mac(mac(held.shapes.shape, held.shapes.shape), names, names)

    def _go(self, frequency: float) -> None:
        lines = self._held.frfs.frequency
        self._cursors.frequency = float(lines[np.abs(lines - frequency).argmin()])
