"""A mode shape at the points of a structure: dots and arrows in a plane, or a line for every direction."""

import numpy as np
import pyqtgraph
from numpy.typing import NDArray

from analysis.estimation.transfer import direction_sign
from app.view.chart import Chart
from app.view.test_run.held import HeldTest
from app.view.theme import Theme, two_sided

LEAST_DOT, LARGEST_DOT = 7.0, 20.0
"""Diameter of a point at rest, and of the largest motion."""
FLAT_EXTENT = 0.05
"""Second largest extent of the points, over the largest, below which they lie on a line."""
ARROW_LENGTH = 0.12
"""Length of the largest motion within the plane, over the largest extent of the points."""
MOST_NUMBERS = 12
"""Numbers of nodes for which there is room below a chart."""
NAMES = "xyz"


class ShapeChart(Chart):
    """Real part of a shape along the positive axes, its largest component 1.

    Where points lie in a plane, motion out of it is the colour and size of a dot and motion within it a line from
    the point; a dot without motion out of the plane measured there is grey.

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
        self._plane = bool(self._known and np.sort(spread)[-2] > FLAT_EXTENT * spread.max())
        along, apart = int(np.argmax(spread)), bool(self._known and spread.max() > 0.0)
        x = f"{NAMES[first]} [m]" if self._plane else f"{NAMES[along]} [m]" if apart else "node"
        super().__init__("test-shape", "", x, f"{NAMES[second]} [m]" if self._plane else "shape", theme)
        self._sign = np.array([direction_sign(place) for place in held.shapes.places])
        self._axis = np.array(
            [int(place[-1]) - 1 if ":" in place else 2 for place in held.shapes.places], dtype=int
        )
        self._held, self._axes, self._nodes = held, (first, second), np.array(nodes)
        self._at = where[:, [first, second]]
        self._arrow = ARROW_LENGTH * float(spread.max())
        if self._plane:
            self._begin_plane()
        else:
            self._line = where[:, along] if apart else np.unique(nodes, return_inverse=True)[1] + 1.0
            self._begin_line()
            if not apart:
                self._number_nodes()

    def _begin_plane(self) -> None:
        pen = pyqtgraph.mkPen(self.theme.muted)
        self._points = pyqtgraph.ScatterPlotItem(size=14, pen=pen)
        self._within = self.plot([], [], pen=pyqtgraph.mkPen(self.theme.text, width=2.0), connect="pairs")
        self._within.opts["label"] = "motion in the plane"
        self.addItem(self._points)
        self.setAspectLocked(True)

    def _begin_line(self) -> None:
        theme, axes = self.theme, np.unique(self._axis)
        if len(axes) > 1:
            self.legend(columns=len(axes))
        self._curves = {
            int(axis): self.curve(
                [],
                [],
                f"along {NAMES[axis]}" if len(axes) > 1 else "shape",
                theme.series(n),
                width=1.6,
                points=True,
            )
            for n, axis in enumerate(axes)
        }
        self.addItem(pyqtgraph.InfiniteLine(0.0, angle=0, pen=pyqtgraph.mkPen(theme.muted)), ignoreBounds=True)
        self.setYRange(-1.1, 1.1 if len(axes) == 1 else 1.5, padding=0.0)  # the legend stands above all curves

    def _number_nodes(self) -> None:
        """Write the nodes' numbers below the line, not their places in it."""
        numbers = np.unique(self._nodes)
        ticks = [(place, str(number)) for place, number in enumerate(numbers.tolist(), start=1)]
        self.name_ticks("bottom", ticks, MOST_NUMBERS)

    def show_shape(self, number: int) -> None:
        """Show one of the shapes, from 0."""
        held = self._held
        if number >= len(held.shapes.pole):
            return
        motion = self._sign * held.shapes.shape[number].real
        self.setTitle(f"shape at {held.places[number]:.2f} Hz")
        if self._plane:
            self._show_plane(np.nan_to_num(motion))
            return
        for axis, curve in self._curves.items():
            mine = np.flatnonzero(self._axis == axis)
            mine = mine[np.argsort(self._line[mine], kind="stable")]
            curve.setData(self._line[mine], motion[mine])
        self.setXRange(float(self._line.min()), float(self._line.max()), padding=0.04)

    def _show_plane(self, motion: NDArray[np.float64]) -> None:
        """Draw a dot at every point, motion out of the plane in it, and a line for each within it."""
        out = ~np.isin(self._axis, self._axes)
        still = ~out & ~np.isin(self._nodes, self._nodes[out])
        size = np.where(out, LEAST_DOT + (LARGEST_DOT - LEAST_DOT) * np.abs(motion), LEAST_DOT)
        colors = two_sided().map(0.5 + 0.5 * motion)
        brushes = [
            pyqtgraph.mkBrush(*(int(c) for c in row[:3])) if yes else pyqtgraph.mkBrush(self.theme.muted)
            for row, yes in zip(colors, out, strict=True)
        ]
        seen = np.flatnonzero(out | still)
        self._points.setData(
            self._at[seen, 0], self._at[seen, 1], brush=[brushes[n] for n in seen], size=size[seen]
        )
        inside = np.flatnonzero(~out)
        ends = self._at[inside].copy()
        ends[np.arange(len(inside)), (self._axis[inside] == self._axes[1]).astype(int)] += (
            self._arrow * motion[inside]
        )
        lines = np.stack([self._at[inside], ends], axis=1).reshape(-1, 2)
        self._within.setData(lines[:, 0], lines[:, 1])
