"""A plot of a map: values over two axes as colours, with their bar.

MAC of two lists of modes, with its values in the cells; Ctrl+C copies all of them.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pyqtgraph
from numpy.typing import NDArray
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import QApplication

from analysis.arrays import Real
from app.view.chart import Chart, Map, Side, log_places
from app.view.theme import Theme, one_sided

MOST_CELLS = 1024
"""Rows or columns at most of a map whose cells differ in size."""
OUTWARD = 5
"""Dots of a tick, away from the map: inside, they were minus signs before the values of its first column."""
COLOUR_BAR_WIDTH = 78
"""Dots that the colour bar of a map takes."""


class MapChart(Chart):
    """One plot of a map; `image` draws it, `show_map` changes what it shows."""

    def image(
        self,
        shown: Map,
        colors: pyqtgraph.ColorMap,
        levels: tuple[float, float],
        label: str,
        ticks: Sequence[tuple[float, str]] | None = None,
    ) -> Any:
        """Draw a map with its colour bar; call `show_map` to change what it shows.

        Parameters
        ----------
        levels : (float, float)
            Values at the ends of the colours.
        label : str
            Of the colour bar, with its unit.
        ticks : sequence of (float, str), optional
            Of the colour bar: values and their words.

        Returns
        -------
        pyqtgraph.ImageItem
        """
        item = pyqtgraph.ImageItem()
        item.setZValue(-10)
        self.addItem(item)
        bar = pyqtgraph.ColorBarItem(
            values=levels, colorMap=colors, interactive=False, width=12, pen=self.theme.muted
        )
        bar.setImageItem(item, insert_in=self.plotItem)
        bar.axis.setTextPen(self.theme.text)
        bar.axis.setPen(self.theme.muted)
        bar.axis.setLabel(label, color=self.theme.text)
        bar.axis.enableAutoSIPrefix(False)
        bar.axis.setWidth(COLOUR_BAR_WIDTH - 30)
        bar.setFixedWidth(COLOUR_BAR_WIDTH)
        if ticks is not None:
            bar.axis.setTicks([list(ticks)])
        self.showGrid(x=False, y=False)
        for side in ("bottom", "left"):
            self.getAxis(side).setStyle(tickLength=OUTWARD)
        self._image, self._levels = item, levels
        self.show_map(shown)
        self.fit()
        return item

    def show_map(self, shown: Map) -> None:
        """Show other values; each cell reaches half way to its neighbours, wherever they stand."""
        self.map = shown
        across = self._across
        (left, right), (low, high) = _span(across), _span(shown.y)
        pixels = shown.value[_evenly(shown.y, low, high)][:, _evenly(across, left, right)]
        self._image.setImage(pixels, levels=self._levels, autoLevels=False)
        self._image.setRect(left, low, right - left, high - low)

    def fit(self) -> None:
        """Show all of the map."""
        if self.map is None:
            super().fit()
            return
        self.setXRange(*_span(self._across), padding=0.0)
        self.setYRange(*_span(self.map.y), padding=0.0)

    def set_log_x(self, log: bool) -> None:
        """Draw the map over the decadic logarithm of x, or over x."""
        super().set_log_x(log)
        if self.map is not None:
            self.show_map(self.map)

    @property
    def _across(self) -> Real:
        """Where the columns of the map stand along the axis."""
        x = np.empty(0) if self.map is None else self.map.x
        return log_places(x, x) if self.log_x and len(x) else x

    def stand_over(self, chart: Chart) -> None:
        """Keep the x axis of a chart below exactly under one's own: leave out there what the colour bar takes."""
        chart.showAxis("right")
        axis = chart.getAxis("right")
        axis.setWidth(COLOUR_BAR_WIDTH)
        axis.setStyle(showValues=False, tickLength=0)
        axis.setPen(None)
        chart.setXLink(self)


def _span(centres: Real) -> tuple[float, float]:
    """Outer edges of cells around `centres`."""
    if len(centres) < 2:
        return float(centres[0]) - 0.5, float(centres[0]) + 0.5
    first, last = 0.5 * (centres[1] - centres[0]), 0.5 * (centres[-1] - centres[-2])
    return float(centres[0] - first), float(centres[-1] + last)


def _evenly(centres: Real, low: float, high: float) -> slice | NDArray[np.int_]:
    """Return which cell each of equal pixels from `low` to `high` shows; all of them where cells are equal."""
    apart = np.diff(centres)
    if len(apart) == 0 or np.allclose(apart, apart[0], rtol=1e-3):
        return slice(None)
    pixels = min(MOST_CELLS, max(len(centres), round((high - low) / float(apart.min()))))
    middle = low + (np.arange(pixels) + 0.5) * (high - low) / pixels
    nearest: NDArray[np.int_] = np.abs(middle[:, None] - centres).argmin(axis=1)
    return nearest


BRIGHT_COLOUR = 0.5
"""Lightness of a colour from which black is read on it."""
LARGEST_DIGITS, SMALLEST_DIGITS = 13.0, 8.0
"""Heights of the values, dots; in cells too small for the smaller ones none is written."""
WIDTH_OF_WHOLE, WIDTH_OF_SHORT = 2.7, 2.0
"""Widths of 0.97 and of .97 in heights of their digits, with the room that keeps neighbours apart."""
MOST_WRITTEN = 60
"""Rows or columns up to which values are written at all: a screen has no room for more, and each is an item."""
HEIGHT_OF_LINE = 1.4
"""Height of a line of text in heights of its digits."""
MOST_TICKS: dict[Side, int] = {"bottom": 6, "left": 14}
"""Names of modes that have room along an axis of half the width of a window."""


class MacChart(MapChart):
    """Values 0 to 1 of all pairs of modes; nothing is drawn before `show_mac`."""

    def __init__(self, name: str, title: str, x: str, y: str, theme: Theme) -> None:
        super().__init__(name, title, x, y, theme)
        self._written: list[tuple[pyqtgraph.TextItem, float]] = []
        self._names: tuple[tuple[str, ...], tuple[str, ...]] = ((), ())

    def show_mac(self, value: Real, rows: Sequence[str], columns: Sequence[str]) -> None:
        """Show other values.

        Parameters
        ----------
        value : (S, U) ndarray
            At least one row and column.
        rows, columns : sequence of str
            Names of the modes, upwards and to the right.
        """
        self._names = (tuple(rows), tuple(columns))
        s, u = value.shape
        shown = Map(np.arange(1.0, u + 1.0), np.arange(1.0, s + 1.0), value)
        if self.map is None:
            self.image(shown, one_sided("cividis"), (0.0, 1.0), "MAC")
            self.plotItem.vb.sigResized.connect(self._size_values)
        else:
            self.show_map(shown)
            self.fit()
        self._write_values(shown)
        named: Mapping[Side, Sequence[str]] = {"bottom": columns, "left": rows}
        for side, names in named.items():
            self.name_ticks(side, [(float(n), name) for n, name in enumerate(names, start=1)], MOST_TICKS[side])
        self.setToolTip("Click, then Ctrl+C copies all values")

    def _write_values(self, shown: Map) -> None:
        """Put every value into its cell."""
        for one, _ in self._written:
            self.removeItem(one)
        self._written = []
        if max(shown.value.shape) > MOST_WRITTEN:
            return
        colors = one_sided("cividis").map(shown.value.ravel(), mode="qcolor")
        places = np.array([(x, y) for y in shown.y for x in shown.x])
        for (x, y), value, color in zip(places, shown.value.ravel().tolist(), colors, strict=True):
            ink = "#000000" if color.lightnessF() > BRIGHT_COLOUR else "#ffffff"
            text = pyqtgraph.TextItem("", ink, anchor=(0.5, 0.5))
            text.setPos(x, y)
            self.addItem(text, ignoreBounds=True)
            self._written.append((text, value))
        self._size_values()

    def _size_values(self) -> None:
        """Write the values as large as their cells allow; in small ones without the zero before the point."""
        if self.map is None:
            return
        rows, columns = self.map.value.shape
        view = self.plotItem.vb
        wide, high = view.width() / columns, view.height() / rows
        whole = wide / WIDTH_OF_WHOLE >= SMALLEST_DIGITS
        size = min(LARGEST_DIGITS, wide / (WIDTH_OF_WHOLE if whole else WIDTH_OF_SHORT), high / HEIGHT_OF_LINE)
        font = self.font()
        font.setPixelSize(max(round(size), 1))
        for item, value in self._written:
            text = f"{value:.2f}"
            item.setFont(font)
            item.setText(text if whole else "1" if text == "1.00" else text[1:])
            item.setVisible(size >= SMALLEST_DIGITS)

    @property
    def text(self) -> str:
        """All values with the names of the modes, as spreadsheets take them: tabs and lines."""
        if self.map is None:
            return ""
        rows, columns = self._names
        lines = ["\t".join(("MAC", *columns))]
        for name, values in zip(rows, self.map.value.tolist(), strict=True):
            lines.append("\t".join((name, *(f"{value:.4f}" for value in values))))
        return "\n".join(lines) + "\n"

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Copy all values."""
        if event.matches(QKeySequence.StandardKey.Copy) and self.map is not None:
            QApplication.clipboard().setText(self.text)
        else:
            super().keyPressEvent(event)
