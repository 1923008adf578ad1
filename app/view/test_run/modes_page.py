"""Modes of a test: table, stabilization chart under the indicator function, AutoMAC, shapes; changes by hand.

The wire frame has faces and is seen in perspective; any geometry.
"""

from collections.abc import Callable

import numpy as np
import pyqtgraph
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QAction, QBrush, QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QStackedWidget,
    QStyleOptionGraphicsItem,
    QVBoxLayout,
    QWidget,
)

from analysis.arrays import Complex, Real
from analysis.estimation.transfer import direction_sign
from analysis.shapes.participation import faces_between, lines_between, mac
from analysis.shapes.stabilization import cmif
from app.modal_test.modes_of_test import AXIS, MODE_HEADINGS, mode_names, mode_rows
from app.summaries.modes import READ_AS
from app.view.chart import Chart
from app.view.cursors import FREQUENCY, Cursors
from app.view.map_chart import MacChart
from app.view.mode_table import ModeTable
from app.view.surface import AZIMUTH, ELEVATION, TURN, Movement, PerspectiveChart
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


MOTION_HEIGHT = 0.14
"""Largest motion, as a share of the structure's diagonal."""


class WireFrame(pyqtgraph.GraphicsObject):
    """Points, lines and faces; grey lines where the structure is at rest.

    Parameters
    ----------
    place : (N, 3) ndarray
        m.
    lines : sequence of sequence of int
        Points that are joined, from 0.
    faces : sequence of (int, int, int)
    theme : Theme
    """

    def __init__(
        self, place: Real, lines: list[list[int]], faces: list[tuple[int, int, int]], theme: Theme
    ) -> None:
        super().__init__()
        self._place, self._lines, self._faces = place - place.mean(axis=0), lines, faces
        self._reach = MOTION_HEIGHT * float(np.linalg.norm(np.ptp(place, axis=0)))
        self._motion = np.zeros_like(place)
        table = two_sided().getLookupTable(nPts=256)
        self._brushes = [QBrush(QColor(*(int(c) for c in row[:3]))) for row in table]
        self._rest, self._moved = QPen(QColor(theme.muted), 0.0), QPen(QColor(theme.text), 0.0)
        self._rest.setWidthF(0.8)
        self._moved.setWidthF(1.4)
        for pen in (self._rest, self._moved):
            pen.setCosmetic(True)
        u, v, _ = _seen(self._place)
        margin = self._reach + 0.02 * float(np.ptp(u))
        self._bounds = QRectF(
            float(u.min()) - margin,
            float(v.min()) - margin,
            float(np.ptp(u)) + 2 * margin,
            float(np.ptp(v)) + 2 * margin,
        )

    def show_motion(self, motion: Real) -> None:
        """Show motions (N, 3), the largest 1."""
        self._motion = motion
        self.update()

    def boundingRect(self) -> QRectF:
        """Return all that may ever be drawn on."""
        return self._bounds

    def paint(self, painter: QPainter, _option: QStyleOptionGraphicsItem, _widget: QWidget | None = None) -> None:
        """Draw what is at rest, then faces from the farthest, then moving lines."""
        there = self._place + self._reach * self._motion
        u, v, depth = _seen(there)
        corners = [QPointF(a, b) for a, b in zip(u.tolist(), v.tolist(), strict=True)]
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, on=True)
        a, b, _ = _seen(self._place)
        rest = [QPointF(p, q) for p, q in zip(a.tolist(), b.tolist(), strict=True)]
        painter.setPen(self._rest)
        for line in self._lines:
            painter.drawPolyline(QPolygonF([rest[n] for n in line]))
        if self._faces:
            faces = np.array(self._faces)
            painter.setPen(QPen(QColor(0, 0, 0, 0)))
            shade = self._shade()[faces].mean(axis=1)
            for n in np.argsort(-depth[faces].mean(axis=1)).tolist():
                painter.setBrush(self._brushes[int(np.clip(127.5 * (1.0 + shade[n]), 0, 255))])
                painter.drawPolygon(QPolygonF([corners[k] for k in self._faces[n]]))
        painter.setPen(self._moved)
        painter.setBrush(QBrush())
        for line in self._lines:
            painter.drawPolyline(QPolygonF([corners[n] for n in line]))

    def _shade(self) -> Real:
        """Motion out of the structure's plane, or where it has none the largest component, (N,)."""
        normal = int(np.argmin(np.ptp(self._place, axis=0)))
        return np.asarray(self._motion[:, normal])


class MovingShape(PerspectiveChart):
    """One of a test's shapes, moving; points without a place have none here.

    Parameters
    ----------
    held : HeldTest
    theme : Theme
    """

    def __init__(self, held: HeldTest, theme: Theme) -> None:
        super().__init__("test-shape-moving", "", "", "", theme)
        ends = [place.partition(":") for place in held.shapes.places]
        nodes = sorted({int(node) for node, _, _ in ends} & set(held.frfs.points))
        self._held, self._phase = held, 0.0
        self._row = {node: n for n, node in enumerate(nodes)}
        place = np.array([held.frfs.points[node] for node in nodes]).reshape(-1, 3)
        known = {node: held.frfs.points[node] for node in nodes}
        lines = [[self._row[node] for node in line] for line in lines_between(known)]
        faces = [(self._row[a], self._row[b], self._row[c]) for a, b, c in faces_between(known)]
        self._shape: Complex = np.zeros((len(nodes), 3), complex)
        self.useful = bool(lines)
        if not self.useful:
            return
        self._frame = WireFrame(place, lines, faces, theme)
        self.show_item(self._frame)

    @property
    def motion(self) -> Real:
        """Motions (N, 3) shown now, the largest amplitude 1."""
        return np.real(self._shape * np.exp(1j * self._phase))

    def show_shape(self, number: int) -> None:
        """Show one of the shapes, from 0; directions that were not measured do not move."""
        held = self._held
        if number >= len(held.shapes.pole) or not self.useful:
            return
        self._shape = np.zeros_like(self._shape)
        for place, value in zip(held.shapes.places, np.nan_to_num(held.shapes.shape[number]), strict=True):
            node, _, direction = place.partition(":")
            if int(node) in self._row:
                axis = int(direction[-1]) - 1 if direction and direction[-1] in "123" else 2
                self._shape[self._row[int(node)], axis] += direction_sign(place) * value
        self._shape /= np.abs(self._shape).max() or 1.0
        self.setTitle(f"shape at {held.places[number]:.2f} Hz")
        self._phase = 0.0
        self.turn(0.0)

    def turn(self, by: float) -> None:
        """Let the phase go on by so many radians."""
        if self.useful:
            self._phase = (self._phase + by) % (2.0 * np.pi)
            self._frame.show_motion(self.motion)

    def fit(self) -> None:
        """Show the whole structure."""
        if self.useful:
            super().fit()


def _seen(place: Real) -> tuple[Real, Real, Real]:
    """Return where points (N, 3) stand across and up in the picture, and how far behind it."""
    x, y, z = place.T
    across = x * np.cos(AZIMUTH) - y * np.sin(AZIMUTH)
    behind = x * np.sin(AZIMUTH) + y * np.cos(AZIMUTH)
    up = behind * np.sin(ELEVATION) + z * np.cos(ELEVATION)
    return across, up, behind * np.cos(ELEVATION) - z * np.sin(ELEVATION)


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
