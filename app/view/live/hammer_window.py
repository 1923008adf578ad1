"""The window on a hammer test: what came of the last hit, in a colour to be seen from the plate."""

import numpy as np
import pyqtgraph
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QGridLayout, QLabel, QPlainTextEdit, QProgressBar, QVBoxLayout, QWidget

from app.view.chart import Chart
from app.view.theme import Theme
from app.view.window import Window
from app.watch.watched_hits import HeardHit, WatchedHits
from app.watch.words import in_words, said_at

LOOK_INTERVAL = 100
"""Milliseconds between two looks at the folder: a hit is to be judged at once."""
TIME_AROUND_PEAK = (-0.01, 0.09)
"""s before and after the largest force that are drawn: a double hit comes within some hundredths."""


class HitChart(Chart):
    """Force of the last hit around its peak.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("force", "force of the last hit", "time [ms]", "force [N]", theme)
        self._line = self.curve([], [], "force [N]", theme.measured, width=1.6, points=True)

    def show_hit(self, hit: HeardHit) -> None:
        """Draw it."""
        if not hit.time.size:
            return
        near = (hit.time >= TIME_AROUND_PEAK[0]) & (hit.time <= TIME_AROUND_PEAK[1])
        self._line.setData(1e3 * hit.time[near], hit.signals[0, near])


class RingingChart(Chart):
    """Responses to the last hit, each in shares of its own peak and on its own line.

    Parameters
    ----------
    names : tuple of str
    theme : Theme
    """

    def __init__(self, names: tuple[str, ...], theme: Theme) -> None:
        super().__init__("responses", "responses: at the end the plate has to be at rest", "time [s]", "", theme)
        self._names = names
        self._lines = [
            self.curve([], [], f"{name} [share of its peak, from {-n}]", theme.series(n))
            for n, name in enumerate(names)
        ]
        self.setDownsampling(auto=True, mode="peak")
        self.setYRange(-len(names) + 0.4, 0.6, padding=0.02)

    def show_hit(self, hit: HeardHit) -> None:
        """Draw it."""
        ticks = []
        for place, (line, signal) in enumerate(zip(self._lines, hit.signals[1:], strict=True)):
            peak = float(np.abs(signal).max(initial=0.0))
            line.setData(hit.time, 0.45 * signal / (peak or 1.0) - place)
            ticks.append((-float(place), f"{self._names[place]}\n{peak:.3g}"))
        self.getAxis("left").setTicks([ticks])


class PointsChart(Chart):
    """The plate with its points: how many hits are there, and which point is asked for.

    Parameters
    ----------
    watched : WatchedHits
    theme : Theme
    """

    def __init__(self, watched: WatchedHits, theme: Theme) -> None:
        super().__init__("points", "points", "x [m]", "y [m]", theme)
        self._watched = watched
        plate = watched.experiment.plate
        for loop in (plate.loop, *plate.hole_loops):
            closed = np.vstack([loop.polygon, loop.polygon[:1]])
            self.curve(closed[:, 0], closed[:, 1], "outline", theme.muted)
        self.setAspectLocked(True)
        self._points = pyqtgraph.ScatterPlotItem(pen=None)
        self.addItem(self._points)
        self._numbers = []
        for number, (x, y) in enumerate(watched.experiment.mallet.places, start=1):
            text = pyqtgraph.TextItem(str(number), color=theme.text, anchor=(0.5, 1.6))
            text.setPos(x, y)
            self.addItem(text)
            self._numbers.append(text)

    def show_progress(self) -> None:
        """Draw what is there."""
        watched, theme = self._watched, self.theme
        at, progress = watched.set_point, watched.progress
        asked = progress.next_point(at)
        spots = []
        for point, place in enumerate(watched.experiment.mallet.places):
            there = len(progress.at(at, point))
            whole = there >= progress.wanted
            colour = theme.corrected if whole else theme.twin if point == asked else theme.muted
            spots.append({"pos": place, "size": 18 if point == asked else 12, "brush": colour})
        self._points.setData(spots)


class HammerWindow(Window):
    """Shows a hammer test as it grows; hits are undone and points skipped on the terminal that records them.

    Parameters
    ----------
    watched : WatchedHits
    theme : Theme
    """

    def __init__(self, watched: WatchedHits, theme: Theme) -> None:
        super().__init__(watched.folder.name, theme)
        self._watched = watched
        watched.look()
        self.build()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self.look)
        self._timer.start(LOOK_INTERVAL)

    def content(self) -> QWidget:
        """Build everything anew, then show all that is known."""
        whole, theme = QWidget(), self.theme
        self.banner, self.asked, self.bar = QLabel(), QLabel(), QProgressBar()
        self.banner.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.banner.setWordWrap(True)
        self.bar.setFormat("%v of %m hits")
        self.force, self.points = HitChart(theme), PointsChart(self._watched, theme)
        self.responses = RingingChart(self._watched.experiment.channels[1:], theme)
        self.log = QPlainTextEdit()
        self.log.setReadOnly(True)
        self._logged = 0
        layout = QVBoxLayout(whole)
        for widget in (self.banner, self.asked, self.bar):
            layout.addWidget(widget)
        grid = QGridLayout()
        grid.addWidget(self.force, 0, 0)
        grid.addWidget(self.points, 0, 1)
        grid.addWidget(self.responses, 1, 0)
        grid.addWidget(self.log, 1, 1)
        layout.addLayout(grid, stretch=1)
        self.adopt(whole)
        self._show()
        return whole

    def look(self) -> None:
        """See whether the folder has grown, and show what it has."""
        if self._watched.look():
            self._show()

    def _show(self) -> None:
        watched, theme = self._watched, self.theme
        hit, progress = watched.latest, watched.progress
        if hit is None:
            self._banner("no hit yet", theme.muted)
        else:
            known = "" if hit.coherence is None else f", coherence {hit.coherence:.3f}"
            peak = f"point {hit.point + 1}: {hit.peak:.1f} N"
            if hit.rejected:
                self._banner(f"REJECTED, {peak}: {hit.rejected}", theme.warning)
            else:
                self._banner(f"ACCEPTED, {peak}{known}", theme.corrected)
            self.force.show_hit(hit)
            self.responses.show_hit(hit)
        temperatures, at = watched.experiment.temperatures, watched.set_point
        point = progress.next_point(at)
        where = "" if temperatures[at] is None else f"{temperatures[at]:g} °C, "
        self.asked.setText(
            "complete"
            if point is None
            else f"next: {where}point {point + 1} of {progress.points}, "
            f"hit {len(progress.at(at, point)) + 1} of {progress.wanted}"
        )
        total = progress.points * progress.wanted * len(temperatures)
        self.bar.setMaximum(total)
        self.bar.setValue(total - sum(progress.missing(number) for number in range(len(temperatures))))
        self.points.show_progress()
        for event in watched.events[self._logged :]:
            date = event.get("date")  # a log written by hand may lack it
            when = "" if date is None else f"{said_at(date, simulated=watched.simulated)}  "
            self.log.appendPlainText(f"{when}{in_words(event)}")
        self._logged = len(watched.events)
        self.statusBar().setStyleSheet(f"color: {theme.warning};")
        self.statusBar().showMessage(watched.trouble)

    def _banner(self, text: str, colour: str) -> None:
        self.banner.setText(text)
        self.banner.setStyleSheet(
            f"background: {colour}; color: {self.theme.plot}; font-size: 26pt; font-weight: bold; padding: 14px; "
            "border-radius: 6px;"
        )
