"""A field over a plate at points of a lattice: shown up to the plate's own edges, from above or in perspective.

In perspective it moves, drawn from behind to the front, until somebody wants it to stand still.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pyqtgraph
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, Qt, QTimer
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPen, QPolygonF
from PySide6.QtWidgets import QPushButton, QWidget

from analysis.arrays import Complex, Real
from analysis.declaration.plate import Plate
from app.view.chart import Chart, Map
from app.view.theme import Theme, two_sided

AZIMUTH, ELEVATION = np.radians(-32.0), np.radians(38.0)
TURN = 2.0 * np.pi / 45.0
"""Phase between two pictures."""
RELIEF_HEIGHT = 0.16
"""Height of the largest deflection, share of the plate's diagonal."""


class SurfaceItem(pyqtgraph.GraphicsObject):
    """Quadrilaterals between the points of a rectangular grid, coloured by deflection.

    Parameters
    ----------
    x, y : (X,), (Y,) ndarray
        m.
    outlines : sequence of (ndarray, color)
        Corners (C, 2), m, of what is drawn on the surface, closed.
    theme : Theme
    edges : sequence of ndarray
        Corners (C, 2), m, of the plate's outline and holes, between which the surface is shown.
    """

    def __init__(
        self,
        x: Real,
        y: Real,
        outlines: Sequence[tuple[Real, str]],
        theme: Theme,
        edges: Sequence[Real] = (),
    ) -> None:
        super().__init__()
        self._x, self._y, self._theme = x, y, theme
        self._plane = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        self._center = np.array([x.mean(), y.mean()])
        self._relief = RELIEF_HEIGHT * float(np.hypot(np.ptp(x), np.ptp(y)))
        self._height = np.zeros(self._plane.shape[:2])
        self._edges = [_densely(corners) for corners in edges]
        drawn = [*outlines, *((corners, theme.muted) for corners in edges)]
        self._outlines = [(_densely(corners), QPen(QColor(color), 0.0)) for corners, color in drawn]
        for _, pen in self._outlines:
            pen.setCosmetic(True)
            pen.setWidthF(2.0)
        depth = self._depth(0.25 * sum(self._corners(self._plane), np.zeros(2)))
        self._order = np.argsort(-depth, axis=None)
        table = two_sided().getLookupTable(nPts=256)
        self._brushes = [QBrush(QColor(*(int(c) for c in row[:3]))) for row in table]
        u, v = self._projected(self._plane, np.ones(self._plane.shape[:2]))
        width, height = 1.04 * np.abs(u).max(), 1.02 * np.abs(v).max()
        self._bounds = QRectF(-width, -height, 2.0 * width, 2.0 * height)

    def show_height(self, height: Real) -> None:
        """Show deflections (X, Y), from -1 to 1."""
        self._height = height
        self.update()

    def boundingRect(self) -> QRectF:
        """Return all that may ever be drawn on."""
        return self._bounds

    def paint(self, painter: QPainter, *_: Any) -> None:
        """Draw the farthest quadrilaterals first."""
        u, v = self._projected(self._plane, self._height)
        points = [
            [QPointF(a, b) for a, b in zip(*row, strict=True)] for row in zip(u.tolist(), v.tolist(), strict=True)
        ]
        shade = np.clip(127.5 * (1.0 + 0.25 * sum(self._corners(self._height), np.zeros(1))), 0, 255).astype(int)
        columns = shade.shape[1]
        colors = shade.ravel()[self._order].tolist()
        painter.save()
        self._clip(painter)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, on=False)
        painter.setPen(Qt.PenStyle.NoPen)
        for place, color in zip(self._order.tolist(), colors, strict=True):
            i, j = divmod(place, columns)
            painter.setBrush(self._brushes[color])
            near, far = points[i], points[i + 1]
            painter.drawConvexPolygon(QPolygonF([near[j], far[j], far[j + 1], near[j + 1]]))
        painter.restore()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, on=True)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        for corners, pen in self._outlines:
            painter.setPen(pen)
            painter.drawPolyline(self._on_surface(corners))

    def _clip(self, painter: QPainter) -> None:
        """Draw between the plate's edges only, wherever they have moved to."""
        if self._edges:
            path = QPainterPath()
            path.setFillRule(Qt.FillRule.OddEvenFill)
            for corners in self._edges:
                path.addPolygon(self._on_surface(corners))
            painter.setClipPath(path, Qt.ClipOperation.IntersectClip)

    def _on_surface(self, corners: Real) -> QPolygonF:
        """Return a line drawn on the surface, projected."""
        from scipy.ndimage import map_coordinates

        places = [np.interp(corners[:, k], at, np.arange(len(at))) for k, at in enumerate((self._x, self._y))]
        a, b = self._projected(corners, map_coordinates(self._height, places, order=1))
        return QPolygonF([QPointF(p, q) for p, q in zip(a.tolist(), b.tolist(), strict=True)])

    def _projected(self, plane: Real, height: Real) -> tuple[Real, Real]:
        across, depth = self._turned(plane)
        return across, depth * np.sin(ELEVATION) + self._relief * height * np.cos(ELEVATION)

    def _depth(self, plane: Real) -> Real:
        return self._turned(plane)[1]

    def _turned(self, plane: Real) -> tuple[Real, Real]:
        x, y = (plane - self._center)[..., 0], (plane - self._center)[..., 1]
        return x * np.cos(AZIMUTH) - y * np.sin(AZIMUTH), x * np.sin(AZIMUTH) + y * np.cos(AZIMUTH)

    @staticmethod
    def _corners(values: Real) -> list[Real]:
        """Values at the four corners of every quadrilateral."""
        return [values[:-1, :-1], values[1:, :-1], values[1:, 1:], values[:-1, 1:]]


class PerspectiveChart(Chart):
    """A plot of one item in perspective, without axes."""

    def show_item(self, item: pyqtgraph.GraphicsObject) -> None:
        """Draw what the plot shows, all that it may ever draw on in sight."""
        self._item = item
        self.addItem(item)
        self.hideAxis("bottom")
        self.hideAxis("left")
        self.showGrid(x=False, y=False)
        self.setAspectLocked(lock=True)
        self.setMouseEnabled(x=False, y=False)
        self.fit()

    def fit(self) -> None:
        """Show the whole of it."""
        self.plotItem.vb.setRange(self._item.boundingRect(), padding=0.0)


CELLS_IN_ONE = 6
"""Cells of a picture in one of the lattice."""


def edges_of(plate: Plate) -> list[Real]:
    """Corners (C, 2), m, of a plate's outline and holes."""
    return [loop.polygon for loop in (plate.loop, *plate.hole_loops)]


def widened(at: Real, by: int) -> Real:
    """Return places (N,) with `by` more on either side, as far apart as the outermost ones."""
    beyond = np.arange(1, by + 1)
    before = at[0] - beyond[::-1] * (at[1] - at[0])
    return np.concatenate([before, at, at[-1] + beyond * (at[-1] - at[-2])])


def filled(field: Complex) -> Complex:
    """Continue a field (X, Y) past the plate's edge, where it is NaN: straight on, by the values next to it."""
    found = field.copy()
    while np.isnan(found).any() and not np.isnan(found).all():
        wide = np.pad(found, 2, constant_values=np.nan)
        guesses = []
        for axis in (0, 1):
            for step in (1, -1):
                next_to, behind = (np.roll(wide, k * step, axis)[2:-2, 2:-2] for k in (1, 2))
                guesses.append(np.where(np.isnan(behind), next_to, 2.0 * next_to - behind))
        beside = np.stack(guesses)
        known = ~np.isnan(beside)
        reached = np.isnan(found) & known.any(axis=0)
        mean = np.where(known, beside, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        size = np.nanmax(np.abs(field))  # far from the plate straight on would lead anywhere
        found[reached] = (mean * np.minimum(1.0, 1.5 * size / np.maximum(np.abs(mean), 1e-300)))[reached]
    return found


@dataclass(frozen=True)
class FromAbove:
    """A lattice made finer where the plate's edges cut it.

    Attributes
    ----------
    x, y : (X,), (Y,) ndarray
        Of the lattice, m.
    plate : Plate
    """

    x: Real
    y: Real
    plate: Plate

    @cached_property
    def _fine(self) -> tuple[Real, Real, NDArray[np.bool_]]:
        """Finer places along both axes, and which of their points (x, y) lie off the plate."""
        wide = [widened(at, 2) for at in (self.x, self.y)]
        x, y = (np.linspace(float(at[0]), float(at[-1]), CELLS_IN_ONE * (len(at) - 1) + 1) for at in wide)
        points = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        return x, y, ~self.plate.contains(points).reshape(len(x), len(y))

    def amplitude(self, field: Complex) -> Map:
        """Return amplitudes of a field (X, Y) as a map; NaN off the plate."""
        from scipy.ndimage import map_coordinates

        if not np.isnan(field).any():
            return Map(self.x, self.y, np.abs(field).T)
        x, y, off = self._fine
        whole = filled(np.pad(field, 2, constant_values=np.nan))
        rows = [np.arange(CELLS_IN_ONE * (size - 1) + 1) / CELLS_IN_ONE for size in whole.shape]
        places = np.meshgrid(*rows, indexing="ij")
        real, imaginary = (map_coordinates(part, places, order=1) for part in (whole.real, whole.imag))
        return Map(x, y, np.where(off, np.nan, np.hypot(real, imaginary)).T)


class SurfaceChart(PerspectiveChart):
    """A field over a plate that can be set moving.

    Parameters
    ----------
    name, title : str
    x, y : (X,), (Y,) ndarray
        Points, m.
    outlines : sequence of (ndarray, color)
        See `SurfaceItem`.
    theme : Theme
    edges : sequence of ndarray
        See `SurfaceItem`.
    """

    def __init__(
        self,
        name: str,
        title: str,
        x: Real,
        y: Real,
        outlines: Sequence[tuple[Real, str]],
        theme: Theme,
        edges: Sequence[Real] = (),
    ) -> None:
        super().__init__(name, title, "x [m]", "y [m]", theme)
        self._at = x, y
        self._field = np.zeros((len(x), len(y)), complex)
        self._beside = 2 if edges else 0
        self._shown = self._surface(self._field)
        self._phase = 0.0
        wide = [widened(at, self._beside) for at in (x, y)]
        self._surface_item = SurfaceItem(wide[0], wide[1], outlines, theme, edges)
        self.show_item(self._surface_item)

    @property
    def deflection(self) -> Real:
        """Deflection (X, Y) shown now, share of the largest; NaN off the plate."""
        return np.real(self._field * np.exp(1j * self._phase))

    def show_field(self, field: NDArray[np.complex128]) -> None:
        """Show a field (X, Y) of any unit, NaN off the plate; it is scaled to its largest amplitude."""
        self._field = field / (np.nanmax(np.abs(field)) or 1.0)
        self._shown = self._surface(self._field)
        self.turn(0.0)

    def _surface(self, field: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the field continued past the plate's edges, between which it is shown."""
        return filled(np.pad(field, self._beside, constant_values=np.nan))

    def turn(self, by: float) -> None:
        """Let the phase go on by so many radians."""
        self._phase = (self._phase + by) % (2.0 * np.pi)
        self._surface_item.show_height(np.real(self._shown * np.exp(1j * self._phase)))
        self.map = Map(*self._at, self.deflection.T)


def _densely(corners: Real, steps: int = 48) -> Real:
    """Points along the closed line through `corners`, about `steps` of them besides."""
    ends = np.roll(corners, -1, axis=0)
    length = np.hypot(*(ends - corners).T)
    counts = np.ceil(steps * length / length.sum()).astype(int)
    sides = [
        start + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (end - start)
        for start, end, count in zip(corners, ends, counts, strict=True)
    ]
    return np.vstack([*sides, corners[:1]])


FRAME_INTERVAL = 33
"""Milliseconds from one picture to the next."""


class Movement(QTimer):
    """Asks for the next picture.

    Parameters
    ----------
    parent : QWidget
    advance : callable
        Shows it.
    button : QPushButton, optional
        Starts and stops the movement, and says which of both it would do.
    """

    def __init__(self, parent: QWidget, advance: Callable[[], None], button: QPushButton | None = None) -> None:
        super().__init__(parent)
        self.setInterval(FRAME_INTERVAL)
        self.timeout.connect(advance)
        self._button = button
        if button is not None:
            button.clicked.connect(self.toggle)

    def toggle(self) -> None:
        """Let the pictures move, or stand still."""
        self.go(not self.isActive())

    def go(self, moving: bool) -> None:
        """Let them do one of both."""
        if moving:
            self.start()
        else:
            self.stop()
        if self._button is not None:
            self._button.setText("Still" if moving else "Move")
