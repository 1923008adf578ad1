"""A plot that can be read, followed with a cursor, and exported."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pyqtgraph
from numpy.typing import ArrayLike
from PySide6.QtCore import Qt, SignalInstance
from PySide6.QtWidgets import QSizePolicy

from analysis.arrays import Real
from analysis.drawn_curves import in_lines
from app.view.theme import Color, Theme

Style = Literal["line", "dash", "dot", "none"]
Side = Literal["bottom", "left"]
STYLES = {
    "line": Qt.PenStyle.SolidLine,
    "dash": Qt.PenStyle.DashLine,
    "dot": Qt.PenStyle.DotLine,
    "none": Qt.PenStyle.NoPen,
}


MOST_DOTS = 4000
"""Points along a curve that are looked at for a legend's place: 3 dots apart over a screen's width of zigzag."""
MOST_OF_LEGEND = 0.5
"""Share of a plot's height up to which room is made above the curves for a legend."""
MARK = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
"""Points of a mark that count as hidden, in its radius from its centre: at its edge it is hidden in part."""


LEAST_NUMBER_DISTANCE = 44.0
"""Dots between numbers at least."""
LABELLED_NUMBERS = ((1, 2, 3, 4, 5, 6, 7, 8, 9), (1, 2, 3, 5, 7), (1, 2, 5), (1, 3), (1,))
"""Numbers of a decade that are labelled, the largest choice first."""
NARROW_DECADES = 0.3
"""Decades below which the numbers stand at equal distances."""


def log_places(values: ArrayLike, lines: Real) -> Real:
    """Return the decadic logarithm of values; a line at 0, and what lies below it, stands at half the next line.

    Parameters
    ----------
    values : array_like
        Where cursors or columns stand, Hz.
    lines : (F,) ndarray
        Frequencies of the axis, Hz, at least one of them above 0.

    Returns
    -------
    ndarray
        Shaped as `values`, finite.
    """
    places: Real = np.log10(np.maximum(values, 0.5 * lines[lines > 0.0].min()))
    return places


class LogAxis(pyqtgraph.AxisItem):
    """Ticks of a logarithmic axis; a linear one is as pyqtgraph has it."""

    def logTickValues(
        self, minVal: float, maxVal: float, size: float, stdTicks: object
    ) -> list[tuple[float | None, list[float]]]:
        """Return ticks with a number, then those without, as pyqtgraph asks for them.

        Parameters
        ----------
        minVal, maxVal : float
            Ends of the axis, as decadic logarithms.
        size : float
            Its length, dots.
        stdTicks : object
            Those of a linear axis; not used.

        Returns
        -------
        list of (float or None, list of float)
            Spacing, None for ticks without a number, and decadic logarithms.
        """
        decades = max(maxVal - minVal, 1e-9)
        if decades < NARROW_DECADES:
            low, high = 10.0**minVal, 10.0**maxVal
            finest = (high - low) * LEAST_NUMBER_DISTANCE / size
            power = 10.0 ** np.floor(np.log10(finest))
            step = power * next(n for n in (1.0, 2.0, 5.0, 10.0) if n * power >= finest)
            return [(1.0, np.log10(step * np.arange(np.ceil(low / step), high / step)).tolist())]
        below, above = int(np.floor(minVal)), int(np.ceil(maxVal))
        for labelled in LABELLED_NUMBERS:
            gap = float(np.diff(np.log10([*labelled, 10])).min()) * size / decades
            if gap >= LEAST_NUMBER_DISTANCE:
                break
        ticks = {n: [power + float(np.log10(n)) for power in range(below, above + 1)] for n in range(1, 10)}
        shown = {n: [v for v in row if minVal <= v <= maxVal] for n, row in ticks.items()}
        return [
            (1.0, [v for n in labelled for v in shown[n]]),
            (None, [v for n in ticks if n not in labelled for v in shown[n]]),
        ]

    def logTickStrings(self, values: list[float], scale: float, spacing: float | None) -> list[str]:
        """Return the numbers, or nothing for ticks without.

        Parameters
        ----------
        values : list of float
            Decadic logarithms.
        scale : float
            Factor of the numbers.
        spacing : float or None
            Of the ticks; None for those without a number.
        """
        return ["" if spacing is None else f"{scale * 10.0**v:.6g}" for v in values]


@dataclass(frozen=True)
class Map:
    """Values over a grid.

    Attributes
    ----------
    x, y : (C,), (R,) ndarray
        Centres of columns and rows.
    value : (R, C) ndarray
    """

    x: Real
    y: Real
    value: Real


class Chart(pyqtgraph.PlotWidget):
    """One plot.

    Parameters
    ----------
    name : str
        Of its files when it is exported.
    title : str
        The question it answers.
    x, y : str
        Labels with units.
    theme : Theme

    Attributes
    ----------
    least : (float, float) or None
        What `fit` shows of y whatever the curves are: of a coherence 0 to 1, because a good one, from 0.99997 to
        0.99999, would look as a bad one does.
    """

    _fitted: tuple[list[float], list[float]] | None = None  # y that `fit` chose, without and with a legend's room

    def __init__(self, name: str, title: str, x: str, y: str, theme: Theme) -> None:
        super().__init__(background=theme.plot, axisItems={"bottom": LogAxis("bottom")})
        self.name, self.theme = name, theme
        self.labels = (x, y)
        self.map: Map | None = None
        self.least: tuple[float, float] | None = None
        self.setObjectName(name)
        self.setTitle(title)
        for side, label in (("bottom", x), ("left", y)):
            axis = self.getAxis(side)
            axis.setLabel(label, color=theme.text)
            axis.setPen(theme.muted)
            axis.setTextPen(theme.text)
            axis.enableAutoSIPrefix(False)
        self.showGrid(x=True, y=True, alpha=0.14)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(180, 120)

    def setTitle(self, title: str) -> None:
        """Put a title over the plot, at its left; none leaves the plot its room."""
        self.plotItem.setTitle(title or None, color=self.theme.text, size="10pt", bold=True, justify="left")

    def set_label(self, side: Side, label: str) -> None:
        """Name another quantity and unit at an axis, also in what is exported."""
        x, y = self.labels
        self.labels = (label, y) if side == "bottom" else (x, label)
        self.getAxis(side).setLabel(label, color=self.theme.text)

    def name_ticks(self, side: Side, names: Sequence[tuple[float, str]], most: int) -> None:
        """Write names at places along an axis, at most so many, evenly chosen."""
        self.getAxis(side).setTicks([list(names)[:: max(1, -(-len(names) // most))], []])

    def legend(self, columns: int = 1, offset: tuple[int, int] = (-8, 8)) -> None:
        """Name the curves that are drawn from now on, in the corner that hides least of them.

        Parameters
        ----------
        offset : (int, int)
            Dots from the edges, negative from the right and the bottom: the corner that is taken where several
            hide nothing.
        """
        made = self.addLegend(
            offset=offset, colCount=columns, labelTextColor=self.theme.text, labelTextSize="9pt", verSpacing=-4
        )
        self._corner = offset
        made.setBrush(pyqtgraph.mkBrush((*pyqtgraph.mkColor(self.theme.plot).getRgb()[:3], 215)))

    def curve(
        self,
        x: ArrayLike,
        y: ArrayLike,
        label: str,
        color: Color,
        *,
        width: float = 1.0,
        style: Style = "line",
        named: bool = True,
        points: bool = False,
    ) -> Any:
        """Draw a curve.

        Parameters
        ----------
        x, y : (n,) array_like
            In the units of the axes; NaN leaves a gap.
        label : str
            Heads its columns when exported.
        width : float
            Dots.
        style : str
            ``line``, ``dash`` or ``dot``; ``none`` for points alone.
        named : bool
            Whether `label` stands in the legend, too.
        points : bool
            Whether every point is marked.

        Returns
        -------
        pyqtgraph.PlotDataItem
        """
        marks = {"symbol": "o", "symbolSize": 5, "symbolBrush": color, "symbolPen": None} if points else {}
        x, y = np.asarray(x, float), np.asarray(y, float)
        if points and not np.isfinite(y).any():  # of which pyqtgraph's bounds know nothing
            x, y = np.empty(0), np.empty(0)
        item = self.plot(
            x,
            y,
            pen=pyqtgraph.mkPen(color, width=width, style=STYLES[style]),
            name=label if named else None,
            connect="finite",
            **marks,
        )
        item.opts["label"] = label
        return item

    def band(self, x: ArrayLike, low: ArrayLike, high: ArrayLike, color: Color, label: str) -> list[Any]:
        """Fill between two curves; their columns are exported as ``label, low`` and ``label, high``.

        Parameters
        ----------
        x, low, high : (n,) array_like
            In the units of the axes; NaN leaves a gap.

        Returns
        -------
        list
            Both edges and the filling.
        """
        known = np.isfinite(np.asarray(low, float)) & np.isfinite(np.asarray(high, float))
        low, high = (in_lines(np.where(known, np.asarray(values, float), np.nan)) for values in (low, high))
        shade = pyqtgraph.mkColor(color)
        shade.setAlpha(55)
        unseen = pyqtgraph.mkPen(None)  # pen=None would make no path to fill
        edges = [self.plot(x, y, pen=unseen, connect="finite") for y in (low, high)]
        for edge, side in zip(edges, ("low", "high"), strict=True):
            edge.opts["label"] = f"{label}, {side}"
        fill = pyqtgraph.FillBetweenItem(*edges, brush=shade)
        fill.setZValue(-5)
        self.addItem(fill)
        return [*edges, fill]

    def error_bars(self, x: ArrayLike, y: ArrayLike, reach: ArrayLike, color: Color) -> Any:
        """Draw a bar through every point.

        Parameters
        ----------
        x, y, reach : (n,) array_like
            In the units of the axes; reach of a bar to either side.

        Returns
        -------
        pyqtgraph.ErrorBarItem
        """
        item = pyqtgraph.ErrorBarItem(
            x=np.asarray(x, float),
            y=np.asarray(y, float),
            height=2.0 * np.asarray(reach, float),
            beam=0.0,
            pen=pyqtgraph.mkPen(color, width=1.2),
        )
        self.addItem(item)
        return item

    def fit(self) -> None:
        """Show all of it; an axis that follows another plot's is left to that."""
        curves, ranges = self.curves, {}
        for axis, name in ((1, "xRange"), (2, "yRange")):
            if self.plotItem.vb.linkedView(axis - 1) is not None:
                continue
            values = np.concatenate([np.empty(0), *(curve[axis] for curve in curves)])
            if axis == 2 and self.least is not None:
                values = np.append(values, self.least)
            if axis == 1 and self.log_x:
                values = np.log10(values[values > 0.0])
            values = values[np.isfinite(values)]
            if values.size:
                ranges[name] = (float(values.min()), float(values.max()))
        if ranges:  # together: where the aspect is locked, setting one axis alone would undo the other
            self.setRange(**ranges, padding=0.04)
        chosen = list(self.viewRange()[1])
        self.place_legend(room="yRange" in ranges)
        self._fitted = (chosen, list(self.viewRange()[1])) if "yRange" in ranges else None

    def place_legend(self, *, room: bool = False) -> None:
        """Move the legend to the corner where it hides least.

        Parameters
        ----------
        room : bool
            Whether to show more of y above all curves where it would hide some in every corner.
        """
        legend, view = self.plotItem.legend, self.plotItem.vb
        if legend is None or not legend.items:
            return
        size = np.array([legend.width(), legend.height()])
        whole = np.array([view.width(), view.height()])
        if whole[1] <= size[1]:  # one that is only too wide still hides less above the curves
            return
        dots = self._dots(whole)
        right, down = (abs(edge) for edge in self._corner)
        corners = [(x, y) for y in (down, -down) for x in (right, -right)]
        corners.sort(key=lambda corner: corner != self._corner)  # the wanted one first
        hidden = [_inside(dots, np.array(corner), size, whole) for corner in corners]
        best = int(np.argmin(hidden))
        if hidden[best] and room and float(size[1]) < MOST_OF_LEGEND * float(whole[1]):
            low, high = self.viewRange()[1]
            strip = (float(size[1]) + 2.0 * down) / float(whole[1])
            self.setYRange(low, high + (high - low) * strip / (1.0 - strip), padding=0.0)
            best = next(n for n, corner in enumerate(corners) if corner[1] > 0)
        legend.anchor(*_anchors(corners[best]), offset=corners[best])

    def resizeEvent(self, event: Any) -> None:
        """Find the legend's corner anew: its dots hide another part of a smaller plot.

        Its room, too, as long as y shows what `fit` chose: a page is filled before its plots have their sizes.
        """
        super().resizeEvent(event)
        if getattr(self, "plotItem", None) is None:  # the base class resizes before it has one
            return
        if self._fitted is None or not np.allclose(self.viewRange()[1], self._fitted[1]):
            self.place_legend()
            return
        chosen = self._fitted[0]
        self.setYRange(*chosen, padding=0.0)
        self.place_legend(room=True)
        self._fitted = (chosen, list(self.viewRange()[1]))

    def _dots(self, whole: Real) -> Real:
        """Return points along all curves, and of marks, in dots from the upper left corner of the plot, (n, 2)."""
        (left, right), (low, high) = self.viewRange()
        found = [np.empty((0, 2))]
        for item, x, y in self._drawn_curves:
            across = np.log10(np.maximum(x, np.finfo(float).tiny)) if self.log_x else x
            known = np.isfinite(across) & np.isfinite(y)
            a = (across[known] - left) / (right - left) * whole[0]
            b = (high - y[known]) / (high - low) * whole[1]
            if item.opts["symbol"] is not None:
                reach = 0.5 * float(item.opts["symbolSize"]) * MARK
                found.append((np.stack([a, b], axis=1)[:, None] + reach).reshape(-1, 2))
                if _without_line(item):
                    continue
            if len(a) > 1:  # a line between points far apart, too
                apart = np.concatenate([[0.0], np.cumsum(np.maximum(np.hypot(np.diff(a), np.diff(b)), 1e-9))])
                along = np.linspace(0.0, apart[-1], min(MOST_DOTS, 2 + int(apart[-1] / 3.0)))
                a, b = np.interp(along, apart, a), np.interp(along, apart, b)
            found.append(np.stack([a, b], axis=1))
        return np.concatenate(found)

    @property
    def log_x(self) -> bool:
        """Whether x is drawn as its decadic logarithm; curves are given and exported as x all the same."""
        return bool(self.getAxis("bottom").logMode)

    def set_log_x(self, log: bool) -> None:
        """Change that."""
        shown = self.viewRange()[1]
        self.plotItem.setLogMode(x=log)
        self.plotItem.vb.disableAutoRange()  # which that begins, also for the plots that this one follows
        self.fit()
        self.setYRange(*shown, padding=0.0)

    def follow(
        self, direction: Literal["x", "y"], value: float, moved: SignalInstance, move: Callable[[float], None]
    ) -> Any:
        """Show a cursor that follows a signal; dragging it, or a click on the plot, moves it.

        Parameters
        ----------
        direction : str
            Axis along which it moves, ``x`` or ``y``.
        value : float
            Where it begins, in the unit of that axis.
        moved : SignalInstance
            Of Qt; brings the place the cursor goes to.
        move : callable
            Called with the place of a drag or a click.

        Returns
        -------
        pyqtgraph.InfiniteLine
        """
        line = pyqtgraph.InfiniteLine(
            value,
            angle=90 if direction == "x" else 0,
            movable=True,
            pen=pyqtgraph.mkPen(self.theme.warning, width=1.0),
            hoverPen=pyqtgraph.mkPen(self.theme.warning, width=2.5),
        )
        line.setZValue(20)
        self.addItem(line, ignoreBounds=True)
        line.sigDragged.connect(lambda: move(float(line.value())))

        def clicked(event: Any) -> None:
            if event.button() == Qt.MouseButton.LeftButton and self.plotItem.vb.sceneBoundingRect().contains(
                event.scenePos()
            ):
                place = self.plotItem.vb.mapSceneToView(event.scenePos())
                move(float(place.x() if direction == "x" else place.y()))

        self.scene().sigMouseClicked.connect(clicked)
        moved.connect(line.setValue)
        return line

    @property
    def curves(self) -> list[tuple[str, Real, Real]]:
        """Label and points of every curve that is shown now."""
        return [(str(item.opts["label"]), x, y) for item, x, y in self._drawn_curves]

    @property
    def _drawn_curves(self) -> list[tuple[Any, Real, Real]]:
        """Every curve that is shown now, and its points."""
        found = []
        for item in self.plotItem.listDataItems():
            if not isinstance(item, pyqtgraph.PlotDataItem) or "label" not in item.opts or not item.isVisible():
                continue
            x, y = item.getOriginalDataset()
            if x is not None:
                found.append((item, np.asarray(x, float), np.asarray(y, float)))
        return found


def _without_line(item: Any) -> bool:
    """Whether a curve has points alone."""
    pen = item.opts["pen"]
    return pen is None or pyqtgraph.mkPen(pen).style() == Qt.PenStyle.NoPen


def _inside(dots: Real, corner: Real, size: Real, whole: Real) -> int:
    """Count the points that a legend would hide at a corner given by its offset from the edges."""
    start = np.where(corner >= 0, corner, whole + corner - size)
    return int(((dots >= start) & (dots <= start + size)).all(axis=1).sum())


def _anchors(corner: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return which corner of a legend stands at which of the plot."""
    at = (int(corner[0] < 0), int(corner[1] < 0))
    return at, at
