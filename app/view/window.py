"""What all windows have in common: keys, help, themes, and export of plots as PNG, SVG and CSV."""

import csv
import io
from collections.abc import Callable
from itertools import zip_longest
from pathlib import Path

import numpy as np
from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QPoint, QRectF, QSize, Signal
from PySide6.QtGui import QAction, QKeySequence, QPainter, QPixmap
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QFileDialog, QLabel, QMainWindow, QMenu, QWidget

from app.files.atomic import write_bytes, write_text
from app.view import theme as themes
from app.view.chart import Chart
from app.view.theme import DARK, LIGHT, Theme

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


class Window(QMainWindow):
    """A window whose contents can be built anew in another theme.

    Parameters
    ----------
    title : str
    theme : Theme
    """

    folder_chosen = Signal(object, object)
    """This window, and another folder (Path) to show; `app.view.opening`, which knows all windows, answers."""

    def __init__(self, title: str, theme: Theme) -> None:
        super().__init__()
        self.theme = theme
        self.setWindowTitle(title)
        self.resize(1280, 800)
        self._bound: list[QAction] = []
        self._file, self._look = self.menuBar().addMenu("&File"), self.menuBar().addMenu("&View")
        self._help = QLabel(self)
        self._help.setObjectName("help")
        self._help.hide()
        self.beside: list[Window] = []
        self.bind("Open …", "Ctrl+O", self._ask_and_open, self._file)
        self.bind("Export the plots in sight …", "Ctrl+E", self._ask_and_export, self._file)
        self.bind("Close", "Ctrl+Q", self.close, self._file)
        self.bind("Dark or light", "D", self.change_theme, self._look)
        self.bind("Whole plots again", "Home", self.reset, self._look)
        self.bind("Full screen", "F11", self._full_screen, self._look)
        self.bind("Keys", "F1", self.toggle_help, self._look)

    def content(self) -> QWidget:
        """Build what the window shows, in the window's theme."""
        raise NotImplementedError

    def build(self) -> None:
        """Build the contents (anew)."""
        themes.apply(self.theme)
        self.setCentralWidget(self.content())
        self._help.setStyleSheet(
            f"QLabel {{ background: {self.theme.plot}; color: {self.theme.text}; border: 1px solid "
            f"{self.theme.muted}; border-radius: 8px; padding: 18px; }}"
        )

    def adopt(self, page: QWidget) -> None:
        """Offer the export of every plot on a page that was just built."""
        for chart in page.findChildren(Chart):
            self._offer_export(chart)

    def bind(self, text: str, keys: str, slot: Callable[[], object], menu: QMenu | None = None) -> QAction:
        """Bind keys to something the window does; it stands in the help, and in a menu if one is named.

        Parameters
        ----------
        text : str
            What it does.
        keys : str
            As Qt writes them, ``Ctrl+E``.
        slot : callable
            Called without arguments.
        """
        action = QAction(text, self)
        action.setShortcut(QKeySequence(keys))
        action.triggered.connect(lambda: slot())
        self._bound.append(action)
        (menu or self).addAction(action)
        return action

    @property
    def charts(self) -> list[Chart]:
        """Plots in sight."""
        return [chart for chart in self.findChildren(Chart) if chart.isVisible()]

    def change_theme(self) -> None:
        """Go from dark to light, or back."""
        self.theme = LIGHT if self.theme is DARK else DARK
        self.build()

    def reset(self) -> None:
        """Show all of every plot in sight."""
        for chart in self.charts:
            chart.fit()

    def toggle_help(self) -> None:
        """Show or hide every key."""
        rows = "".join(
            f"<tr><td style='padding-right:24px'><b>{keys}</b></td><td>{action.text().replace('&', '')}</td></tr>"
            for action in self._bound
            if (keys := action.shortcut().toString(QKeySequence.SequenceFormat.NativeText))
        )
        self._help.setText(
            f"<h3>Keys</h3><table>{rows}</table><p>Wheel: zoom; drag: move; drag with the right button: stretch; "
            "click: cursor there.<br>Right click on a plot: export it.</p>"
        )
        self._help.adjustSize()
        self._help.move((self.width() - self._help.width()) // 2, (self.height() - self._help.height()) // 2)
        self._help.setVisible(not self._help.isVisible())
        self._help.raise_()

    def export(self, folder: Path) -> list[Path]:
        """Write every plot in sight as PNG, SVG and CSV; return the files."""
        written = []
        for chart in self.charts:
            for ending, exporter in EXPORTERS.items():
                written.append(folder / f"{chart.name}.{ending}")
                exporter(chart, written[-1])
        return written

    def _ask_and_open(self) -> None:
        folder = QFileDialog.getExistingDirectory(self, "Campaign or run folder")
        if folder:
            self.folder_chosen.emit(self, Path(folder))

    def _ask_and_export(self) -> None:
        folder = QFileDialog.getExistingDirectory(self, "Folder for PNG, SVG and CSV of the plots in sight")
        if folder:
            try:
                written = self.export(Path(folder))
            except OSError as error:
                self.statusBar().showMessage(str(error))
            else:
                self.statusBar().showMessage(f"{len(written)} files in {folder}")

    def _offer_export(self, chart: Chart) -> None:
        """Put the three formats first in a plot's own menu, instead of pyqtgraph's exporter."""
        chart.plotItem.setContextMenuActionVisible("Transforms", False)
        chart.plotItem.setContextMenuActionVisible("Downsample", False)
        chart.scene().contextMenu.clear()
        for ending, exporter in EXPORTERS.items():
            action = QAction(f"Export as {ending.upper()} …", chart)
            action.triggered.connect(
                lambda _=False, ending=ending, exporter=exporter: self._ask_one(chart, ending, exporter)
            )
            chart.scene().contextMenu.append(action)

    def _ask_one(self, chart: Chart, ending: str, exporter: Callable[[Chart, Path], None]) -> None:
        name, _ = QFileDialog.getSaveFileName(self, "Export", f"{chart.name}.{ending}", f"*.{ending}")
        if name:
            try:
                exporter(chart, Path(name))
            except OSError as error:
                self.statusBar().showMessage(str(error))

    def _full_screen(self) -> None:
        self.showNormal() if self.isFullScreen() else self.showFullScreen()
