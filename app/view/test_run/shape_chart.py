"""A mode shape at the points of a structure: coloured points in a plane, or a line."""

import numpy as np
import pyqtgraph

from app.view.chart import Chart
from app.view.test_run.held import HeldTest
from app.view.theme import Theme, two_sided

LEAST_DOT, LARGEST_DOT = 7.0, 20.0
"""Diameter of a point at rest, and of the largest motion."""
FLAT = 0.05
"""Second largest extent of the points, over the largest, below which they lie on a line."""


class ShapeChart(Chart):
    """Real part of a shape along the positive axes, its largest component 1.

    Parameters
    ----------
    held : HeldTest
    theme : Theme
    """

    def __init__(self, held: HeldTest, theme: Theme) -> None:
        nodes = [int(place.partition(":")[0]) for place in held.shapes.places]
        self._known = bool(nodes) and all(node in held.frfs.points for node in nodes)
        where = np.array([held.frfs.points[n] for n in nodes]) if self._known else np.zeros((len(nodes), 3))
        spread = np.ptp(where, axis=0) if len(nodes) else np.zeros(3)
        first, second = sorted(int(a) for a in np.argsort(-spread)[:2])
        self._plane = bool(self._known and np.sort(spread)[-2] > FLAT * spread.max())
        along, apart = int(np.argmax(spread)), bool(self._known and spread.max() > 0.0)
        names = "xyz"
        x = f"{names[first]} [m]" if self._plane else f"{names[along]} [m]" if apart else "place"
        super().__init__("test-shape", "", x, f"{names[second]} [m]" if self._plane else "shape", theme)
        self._sign = np.array([-1.0 if ":-" in place else 1.0 for place in held.shapes.places])
        self._held = held
        self._at = where[:, first], where[:, second]
        line = where[:, along] if apart else np.arange(1.0, len(nodes) + 1.0)
        self._order = np.argsort(line, kind="stable")
        self._line = line
        if self._plane:
            self._points = pyqtgraph.ScatterPlotItem(size=14, pen=pyqtgraph.mkPen(theme.muted))
            self.addItem(self._points)
            self.setAspectLocked(True)
        else:
            self._curve = self.curve([], [], "shape", theme.identified, width=1.6, points=True)
            self.addItem(pyqtgraph.InfiniteLine(0.0, angle=0, pen=pyqtgraph.mkPen(theme.muted)), ignoreBounds=True)
            self.setYRange(-1.1, 1.1, padding=0.0)

    def show_shape(self, number: int) -> None:
        """Show one of the shapes, from 0."""
        held = self._held
        if number >= len(held.shapes.pole):
            return
        motion = self._sign * held.shapes.shape[number].real
        self.setTitle(f"shape at {held.places[number]:.2f} Hz")
        if self._plane:
            colors = two_sided().map(0.5 + 0.5 * np.nan_to_num(motion))
            brushes = [pyqtgraph.mkBrush(*(int(c) for c in row[:3])) for row in colors]
            sizes = LEAST_DOT + (LARGEST_DOT - LEAST_DOT) * np.abs(np.nan_to_num(motion))
            self._points.setData(*self._at, brush=brushes, size=sizes)
        else:
            self._curve.setData(self._line[self._order], motion[self._order])
            self.setXRange(float(self._line.min()), float(self._line.max()), padding=0.04)
