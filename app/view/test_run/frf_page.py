"""FRFs of a test with those rebuilt from its modes: decibels and phase, parts, the Nyquist plane; two cursors."""

import numpy as np
import pyqtgraph
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from analysis.shapes.stabilization import checks
from app.view.chart import Chart
from app.view.cursors import FREQUENCY, Cursors, FrequencyAxis
from app.view.frf_plots import LEFT_AXIS_WIDTH, POINTS_OF_CIRCLE, NyquistChart, PartsChoice, around, decibels
from app.view.test_run.held import HeldTest
from app.view.theme import Theme

REBUILT = "rebuilt"
ALONE, ALL = "alone", "beside all others"
MOST_BESIDE = 60
"""FRFs that are drawn behind one at most, evenly chosen."""


class TestFrfPage(QWidget):
    """One FRF, alone or beside others, and what its drive point or its reciprocal one says about it.

    Parameters
    ----------
    held : HeldTest
    cursors : Cursors
    theme : Theme
    """

    __test__ = False

    def __init__(self, held: HeldTest, cursors: Cursors, theme: Theme) -> None:
        super().__init__()
        self._held, self._cursors, self._theme = held, cursors, theme
        self.axis = FrequencyAxis(held.frfs.frequency, cursors)
        self.choice, self.display = QComboBox(), PartsChoice()
        names = [one.name for one in held.frfs.transfers]
        self.choice.addItems(names)
        self.beside = QComboBox()
        self.beside.addItems([ALONE, ALL, *(f"beside {name}" for name in names)])
        self.checked = QLabel()
        self.checked.setWordWrap(True)
        self._checks = checks(held.frfs.transfers, held.frfs.frequency)
        self.rebuilt = QCheckBox("from poles and residues")
        self.rebuilt.setChecked(True)
        self.rebuilt.setStyleSheet(
            f"QCheckBox {{ border-left: 4px solid {theme.identified}; padding-left: 6px; }}"
        )
        self.readout = QLabel()
        self.readout.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.above = Chart("test-frf", "", FREQUENCY, "", theme)
        self.below = Chart("test-frf-below", "", FREQUENCY, "", theme)
        self.coherence = Chart("test-coherence", "coherence", FREQUENCY, "", theme)
        self.coherence.least = (0.0, 1.0)
        self.nyquist = NyquistChart("test-nyquist", {REBUILT: theme.identified}, theme)
        self._lay_out()
        self._modes: list[pyqtgraph.InfiniteLine] = []
        self._draw()
        self.choice.currentIndexChanged.connect(self._show)
        self.beside.currentIndexChanged.connect(self._show)
        self.display.currentIndexChanged.connect(self._show)
        self.rebuilt.toggled.connect(self._show)
        self.axis.toggled.connect(self._draw_modes)
        cursors.frequency_moved.connect(self._follow)
        self._show()

    def mark(self) -> None:
        """Put the mark where the cursor stands; differences are given from there."""
        self.axis.put_mark()
        self._follow()

    def _lay_out(self) -> None:
        chooser, switches, side, grid = QHBoxLayout(), QHBoxLayout(), QVBoxLayout(), QGridLayout(self)
        self._grid = grid
        for widget in (self.choice, self.beside, self.display):
            widget.setMinimumWidth(80)
            widget.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
            chooser.addWidget(widget, stretch=1)
        self.beside.setEnabled(self.choice.count() > 1)
        switches.addWidget(self.rebuilt)
        switches.addWidget(self.axis)
        side.addLayout(chooser)
        side.addLayout(switches)
        side.addWidget(self.readout)
        side.addWidget(self.checked)
        side.addWidget(self.nyquist, stretch=1)
        for row, (chart, share) in enumerate(((self.above, 5), (self.below, 4), (self.coherence, 2))):
            grid.addWidget(chart, row, 0)
            grid.setRowStretch(row, share)
            chart.getAxis("left").setWidth(LEFT_AXIS_WIDTH)
            self.axis.add(chart)
            if chart is not self.above:
                chart.setXLink(self.above)
        grid.addLayout(side, 0, 1, 3, 1)
        grid.setColumnStretch(0, 7)
        grid.setColumnStretch(1, 4)

    def _draw(self) -> None:
        theme = self._theme
        self._curves = [
            (
                chart.curve([], [], "measured", theme.measured, width=1.5),
                chart.curve([], [], REBUILT, theme.identified),
            )
            for chart in (self.above, self.below)
        ]
        self._others: list[pyqtgraph.PlotDataItem] = []
        self._trust = self.coherence.curve([], [], "coherence", theme.measured)

    def _show(self) -> None:
        """Show another FRF, in another way."""
        held, n = self._held, self.choice.currentIndex()
        x, one = held.frfs.frequency, held.frfs.transfers[n]
        measured, rebuilt = zip(*self._curves, strict=True)
        self.display.draw(measured, x, one.h, 0.0 if one.variance is None else np.sqrt(one.variance))
        self.display.draw(rebuilt, x, held.rebuilt[n])
        for curve in rebuilt:
            curve.setVisible(self.rebuilt.isChecked())
        self._show_beside(n)
        self.above.setTitle(one.name)
        told = [check for check in self._checks if one.name in check.names]
        self.checked.setText("\n".join(check.sentence for check in told))
        self.checked.setVisible(bool(told))
        coherence = one.coherence
        self._trust.setData(x, np.full(len(x), np.nan) if coherence is None else coherence)
        self.coherence.setVisible(coherence is not None)
        self._grid.setRowStretch(2, 0 if coherence is None else 2)
        for chart in (self.above, self.below, self.coherence):
            chart.fit()
        self.display.label(self.above, self.below, self._unit)
        self._draw_modes()
        self._follow()

    def _show_beside(self, shown: int) -> None:
        """Draw others behind the one that is shown: of the same quantity, for they share its axis."""
        for item in self._others:
            for chart in (self.above, self.below):
                chart.removeItem(item)
        self._others = []
        transfers, chosen = self._held.frfs.transfers, self.beside.currentIndex()
        wanted = [chosen - 2] if chosen > 1 else range(len(transfers)) if chosen == 1 else []
        alike = [n for n in wanted if n != shown and transfers[n].quantity == transfers[shown].quantity]
        for n in alike[:: -(-len(alike) // MOST_BESIDE) or 1]:
            color = self._theme.twin if chosen > 1 else self._theme.muted
            pair = tuple(
                chart.curve([], [], transfers[n].name, color, width=0.8 if chosen == 1 else 1.2)
                for chart in (self.above, self.below)
            )
            for item in pair:
                item.setZValue(-8)
            self.display.draw(pair, self._held.frfs.frequency, transfers[n].h)
            self._others += pair

    def _draw_modes(self) -> None:
        for line in self._modes:
            self.above.removeItem(line)
        self._modes = []
        for pole, f in zip(self._held.shapes.pole, self._held.places, strict=True):
            solid = self._held.modes.sure[pole]
            style = Qt.PenStyle.SolidLine if solid else Qt.PenStyle.DotLine
            pen = pyqtgraph.mkPen(self._theme.muted, width=0.8, style=style)
            self._modes.append(pyqtgraph.InfiniteLine(float(self.axis.along(f)), pen=pen))
            self._modes[-1].setZValue(-5)
            self.above.addItem(self._modes[-1], ignoreBounds=True)

    def _follow(self) -> None:
        """Bring Nyquist plane and readout to where the cursor is."""
        held, n, here = self._held, self.choice.currentIndex(), self.axis.line
        frequency, h = held.frfs.frequency, held.frfs.h[n]
        near = around(frequency, here, held.modes)
        circle = held.model(np.linspace(frequency[near][0], frequency[near][-1], POINTS_OF_CIRCLE))[n]
        models = {REBUILT: circle} if self.rebuilt.isChecked() else {}
        self.nyquist.show_circle(h[near], complex(h[here]), models, self._unit)
        self._read_out(here, self.axis.mark_line)

    @property
    def _unit(self) -> str:
        label = self._held.frfs.label(self.choice.currentIndex())
        return label[label.rfind("[") + 1 : -1]

    def _read_out(self, here: int, there: int) -> None:
        held, n = self._held, self.choice.currentIndex()
        unit, f, one, h = self._unit, held.frfs.frequency, held.frfs.transfers[n], held.frfs.h[n]
        turn = np.degrees(np.angle(h[here] / h[there])) if h[there] else float("nan")
        apart = float(decibels(h[here]) - decibels(h[there]))
        values = [
            ("cursor", f"{f[here]:.4f} Hz", f"{abs(h[here]):.4g} {unit}", f"{np.degrees(np.angle(h[here])):.1f}°"),
            ("from mark", f"{f[here] - f[there]:+.4f} Hz", f"{apart:+.2f} dB", f"{turn:+.1f}°"),
        ]
        if one.variance is not None:
            values.append(("σ of H", "", f"{np.sqrt(one.variance[here]):.2g} {unit}", ""))
        if one.coherence is not None:
            values.append(("coherence", "", f"{one.coherence[here]:.5f}", ""))
        rows = ("".join(f"<td style='padding-right:14px'>{cell}</td>" for cell in row) for row in values)
        self.readout.setText(f"<table>{''.join(f'<tr>{row}</tr>' for row in rows)}</table>")
