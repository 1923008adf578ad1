"""A plot of a map: values over two axes as colours, with their bar."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyqtgraph
from numpy.typing import NDArray

from analysis.arrays import Real
from app.view.chart import Chart, Map, log_places

MOST_CELLS = 1024
"""Rows or columns at most of a map whose cells differ in size."""
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
