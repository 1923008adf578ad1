"""A measured shape of a structure as a wire frame with faces, moving, in perspective; any geometry."""

import numpy as np
import pyqtgraph
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QBrush, QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from analysis.arrays import Complex, Real
from analysis.estimation.transfer import direction_sign
from analysis.shapes.wire_frame import faces_between, lines_between
from app.view.surface import AZIMUTH, ELEVATION, PerspectiveChart
from app.view.test_run.held import HeldTest
from app.view.theme import Theme, two_sided

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
