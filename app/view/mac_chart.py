"""MAC of two lists of modes, with its values in the cells; Ctrl+C copies all of them."""

from collections.abc import Mapping, Sequence

import numpy as np
import pyqtgraph
from PySide6.QtGui import QKeyEvent, QKeySequence
from PySide6.QtWidgets import QApplication

from analysis.arrays import Real
from app.view.chart import Map, Side
from app.view.map_chart import MapChart
from app.view.theme import Theme, one_sided

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
