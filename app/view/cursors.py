"""The frequency and the temperature that all plots share, and the frequency axis of a page's plots."""

import numpy as np
import pyqtgraph
from numpy.typing import ArrayLike
from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtWidgets import QCheckBox

from analysis.arrays import Real
from app.view.chart import Chart, log_places

FREQUENCY, TEMPERATURE = "frequency [Hz]", "temperature [°C]"
"""Labels of their axes."""


class Cursors(QObject):
    """One place in frequency and temperature.

    Attributes
    ----------
    frequency_moved, temperature_moved : Signal(float)
        Hz and degrees Celsius; sent only where the value has changed.
    """

    frequency_moved = Signal(float)
    temperature_moved = Signal(float)

    def __init__(self, frequency: float, temperature: float) -> None:
        super().__init__()
        self._frequency = frequency
        self._temperature = temperature

    @property
    def frequency(self) -> float:
        """Hz."""
        return self._frequency

    @frequency.setter
    def frequency(self, value: float) -> None:
        if value != self._frequency:
            self._frequency = value
            self.frequency_moved.emit(value)

    @property
    def temperature(self) -> float:
        """Degrees Celsius."""
        return self._temperature

    @temperature.setter
    def temperature(self, value: float) -> None:
        if value != self._temperature:
            self._temperature = value
            self.temperature_moved.emit(value)


class FrequencyAxis(QCheckBox):
    """Switch to logarithmic frequencies; curves and maps are given in Hz either way.

    Parameters
    ----------
    frequency : (F,) ndarray
        Lines that the cursor steps on, Hz.
    cursors : Cursors

    Attributes
    ----------
    placed, marked : Signal(float)
        Where cursor and mark stand along the axis: Hz, or its decadic logarithm.
    """

    placed = Signal(float)
    marked = Signal(float)

    def __init__(self, frequency: Real, cursors: Cursors) -> None:
        super().__init__("log frequency")
        self._frequency, self._cursors, self._mark = frequency, cursors, cursors.frequency
        self._charts: list[Chart] = []
        cursors.frequency_moved.connect(self._place)
        self.toggled.connect(self._change)

    @property
    def line(self) -> int:
        """Line nearest to the cursor."""
        return self.nearest(self._cursors.frequency)

    @property
    def mark_line(self) -> int:
        """Line nearest to the mark."""
        return self.nearest(self._mark)

    def nearest(self, frequency: float) -> int:
        """Return the line nearest to a frequency, Hz."""
        return int(np.abs(self._frequency - frequency).argmin())

    def step(self, lines: int) -> None:
        """Move the cursor by so many lines."""
        place = int(np.clip(self.line + lines, 0, len(self._frequency) - 1))
        self._cursors.frequency = float(self._frequency[place])

    def put_mark(self) -> None:
        """Put the mark where the cursor stands."""
        self._mark = self._cursors.frequency
        self._place()

    def along(self, frequency: ArrayLike) -> Real:
        """Return where frequencies, Hz, stand along the axis."""
        hertz = np.asarray(frequency, dtype=float)
        return log_places(hertz, self._frequency) if self.isChecked() else hertz

    def add(self, chart: Chart) -> None:
        """Take a plot along, and show cursor and mark in it; the first one is that which others are linked to."""
        self._charts.append(chart)
        chart.follow("x", float(self.along(self._cursors.frequency)), self.placed, self._go)
        pen = pyqtgraph.mkPen(chart.theme.muted, style=Qt.PenStyle.DashLine)
        dashed = pyqtgraph.InfiniteLine(float(self.along(self._mark)), pen=pen)
        chart.addItem(dashed, ignoreBounds=True)
        self.marked.connect(dashed.setValue)

    def _go(self, place: float) -> None:
        hertz = 10.0**place if self.isChecked() else place
        self._cursors.frequency = float(self._frequency[self.nearest(hertz)])

    def _place(self) -> None:
        self.placed.emit(float(self.along(self._cursors.frequency)))
        self.marked.emit(float(self.along(self._mark)))

    def _change(self, log: bool) -> None:
        for chart in reversed(self._charts):  # last the one whose range the others follow
            chart.set_log_x(log)
        self._place()
