"""A plot as PNG, SVG and CSV."""

import csv
import io
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QPoint, QRectF, QSize
from PySide6.QtGui import QPainter, QPixmap
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QWidget

from app.files.atomic import write_bytes, write_text
from app.view.chart import Chart

DOTS_PER_SCREEN_DOT = 2.0
"""Dots of a picture for each dot of the screen."""


def export_png(chart: QWidget, target: Path) -> None:
    """Write what is seen, twice as fine as on the screen."""
    picture(chart, DOTS_PER_SCREEN_DOT, target)


def picture(widget: QWidget, scale: float, target: Path) -> None:
    """Write any widget as PNG.

    Parameters
    ----------
    scale : float
        Dots of the picture for each of the widget's own.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    shown = QPixmap(widget.size() * scale)
    shown.setDevicePixelRatio(scale)
    shown.fill(widget.palette().window().color())
    QWidget.render(widget, shown, QPoint())  # a plot's own method draws its scene only
    content = _Content()
    shown.save(content.device, "PNG")
    content.write(target)


def export_svg(chart: Chart, target: Path) -> None:
    """Write lines and words as such; maps go in as pictures."""
    size = QSize(chart.width(), chart.height())
    content = _Content()
    generator = QSvgGenerator()
    generator.setOutputDevice(content.device)
    generator.setSize(size)
    generator.setViewBox(QRectF(0.0, 0.0, size.width(), size.height()))
    generator.setTitle(chart.name)
    painter = QPainter(generator)
    painter.fillRect(QRectF(0.0, 0.0, size.width(), size.height()), chart.backgroundBrush())
    chart.render(painter)
    painter.end()
    content.write(target)


class _Content:
    """What Qt draws into memory: of a file that it writes itself, it does not say why it cannot."""

    def __init__(self) -> None:
        self._bytes = QByteArray()
        self.device = QBuffer(self._bytes)
        self.device.open(QIODevice.OpenModeFlag.WriteOnly)

    def write(self, target: Path) -> None:
        """Write it, whole or not at all."""
        self.device.close()
        write_bytes(target, bytes(self._bytes.data()))


def export_csv(chart: Chart, target: Path) -> None:
    """Write the numbers: a table of the map where there is one, else two columns for each curve."""
    stream = io.StringIO()
    rows = csv.writer(stream, lineterminator="\n")
    x_label, y_label = chart.labels
    if chart.map is not None:
        rows.writerow([f"{y_label} \\ {x_label}", *(f"{x:.9g}" for x in chart.map.x)])
        for y, values in zip(chart.map.y, chart.map.value, strict=True):
            rows.writerow([f"{y:.9g}", *(_cell(v) for v in values)])
    else:
        curves = chart.curves
        rows.writerow([f"{label}: {axis}" for label, _, _ in curves for axis in (x_label, y_label)])
        columns = [values for _, x, y in curves for values in (x, y)]
        for row in zip_longest(*columns):
            rows.writerow(["" if value is None else _cell(value) for value in row])
    write_text(target, stream.getvalue())


def _cell(value: float) -> str:
    return f"{value:.9g}" if np.isfinite(value) else ""


EXPORTERS: dict[str, Callable[[Chart, Path], None]] = {"png": export_png, "svg": export_svg, "csv": export_csv}
"""By what a file's name ends with."""
