"""The window on a campaign being acquired."""

import time
from collections.abc import Callable

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QComboBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QMessageBox,
    QPlainTextEdit,
    QProgressBar,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from app.files.acquisition.running_campaign import request
from app.summaries.numbers import duration
from app.view.live.charts import CoherenceChart, FrfChart, LevelChart, OvenChart, SignalChart, SpectrumChart
from app.view.theme import Theme
from app.view.window import Window
from app.watch.watched import Watched
from app.watch.words import in_words, said_at

LOOK_INTERVAL = 250
"""Milliseconds between two looks at the folder."""
UNDER_WAY = ("running", "pausing", "paused")


class LiveWindow(Window):
    """Shows a campaign as it grows, and passes requests to the runner.

    Parameters
    ----------
    watched : Watched
    theme : Theme
    clock : callable
        Time of day, s since 1970.
    """

    def __init__(self, watched: Watched, theme: Theme, clock: Callable[[], float] = time.time) -> None:
        super().__init__(watched.folder.name, theme)
        self._watched, self._clock, self._channel = watched, clock, 0
        self._pause_action = self.bind("Pause, or continue", "P", self.pause_or_continue, self._file)
        self._stop_action = self.bind("Stop safely …", "Ctrl+S", self.ask_and_stop, self._file)
        self.build()
        self._timer = QTimer(self)
        self._timer.timeout.connect(self.look)
        self._timer.start(LOOK_INTERVAL)
        self.look()

    def content(self) -> QWidget:
        """Build everything anew, then show all that is known."""
        whole, theme = QWidget(), self.theme
        channels = ("drive", *(output.id for output in self._watched.experiment.outputs))
        self.oven, self.signals = OvenChart(theme), SignalChart(channels, theme)
        self.spectrum, self.levels = SpectrumChart(channels, theme), LevelChart(channels, theme)
        self.frfs, self.coherence = FrfChart(theme), CoherenceChart(theme)
        self.coherence.setXLink(self.frfs)
        self.log = QPlainTextEdit()
        self.log.setReadOnly(True)
        self.log.setMaximumBlockCount(5000)
        self._logged = 0
        layout = QVBoxLayout(whole)
        layout.addLayout(self._strip())
        grid = QGridLayout()
        for chart, row, column, rows, columns in (
            (self.oven, 0, 0, 1, 2),
            (self.levels, 0, 2, 1, 1),
            (self.frfs, 1, 0, 2, 1),
            (self.coherence, 3, 0, 1, 1),
            (self.signals, 1, 1, 1, 2),
            (self.spectrum, 2, 1, 1, 2),
        ):
            grid.addWidget(chart, row, column, rows, columns)
        grid.addWidget(self.log, 3, 1, 1, 2)
        for column, share in enumerate((10, 6, 4)):
            grid.setColumnStretch(column, share)
        for row, share in enumerate((6, 4, 4, 4)):
            grid.setRowStretch(row, share)
        layout.addLayout(grid, stretch=1)
        self.adopt(whole)
        self._show()
        return whole

    def look(self) -> None:
        """See whether the folder has grown, and show what it has."""
        if self._watched.look():
            self._show()
        self._show_state()

    def pause_or_continue(self) -> None:
        """Request a pause, or its end."""
        state = self._watched.state(self._clock())
        if state in UNDER_WAY:
            request(self._watched.folder, "pause" if state == "running" else "go on")
            self._show_state()

    def ask_and_stop(self) -> None:
        """Request a stop, once that is confirmed: drive to 0 V, oven to rest."""
        if self._watched.state(self._clock()) not in UNDER_WAY:
            return
        answer = QMessageBox.question(
            self,
            "Stop the campaign?",
            "The drive is brought to 0 V and the oven to rest. Finished sweeps are kept; the same flexura "
            "acquire continues later.",
        )
        if answer == QMessageBox.StandardButton.Yes:
            request(self._watched.folder, "stop")

    def _strip(self) -> QHBoxLayout:
        """Build state, progress and buttons."""
        strip = QHBoxLayout()
        self.badge, self.stage, self.left = QLabel(), QLabel(), QLabel()
        self.badge.setObjectName("state")
        self.bar = QProgressBar()
        self.bar.setFormat("%v of %m sweeps")
        self.bar.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.pause, self.stop = QPushButton("Pause"), QPushButton("Stop")
        self.pause.clicked.connect(self.pause_or_continue)
        self.stop.clicked.connect(self.ask_and_stop)
        self._sensor = QComboBox()
        self._sensor.addItems([output.id for output in self._watched.experiment.outputs])
        self._sensor.setCurrentIndex(self._channel)
        self._sensor.currentIndexChanged.connect(self._choose)
        for widget, stretch in (
            (self.badge, 0),
            (self.stage, 2),
            (self.bar, 3),
            (self.left, 1),
            (QLabel("sensor"), 0),
            (self._sensor, 0),
            (self.pause, 0),
            (self.stop, 0),
        ):
            strip.addWidget(widget, stretch)
        return strip

    def _choose(self, channel: int) -> None:
        self._channel = channel
        self._show()

    def _show(self) -> None:
        watched = self._watched
        self.oven.show_campaign(watched)
        self.frfs.show_campaign(watched, self._channel)
        self.coherence.show_campaign(watched, self._channel)
        if watched.latest is not None and len(watched.latest.channels) == 1 + len(watched.experiment.outputs):
            for chart in (self.signals, self.spectrum, self.levels):
                chart.show_repeat(watched.latest)
        for event in watched.events[self._logged :]:
            self.log.appendPlainText(f"{said_at(event['date'], simulated=watched.simulated)}  {in_words(event)}")
        self._logged = len(watched.events)
        done, total, left = watched.progress
        self.bar.setMaximum(max(total, 1))
        self.bar.setValue(done)
        self.left.setText(f"{duration(left)} left" if left == left and done < total else "")
        if watched.readings:
            last = watched.readings[-1]
            plate = f"plate {last.plate_c:.2f} °C, " if last.plate_c == last.plate_c else ""
            self.stage.setText(f"{last.stage}: {plate}air {last.air_c:.2f} °C")

    def _show_state(self) -> None:
        theme, state = self.theme, self._watched.state(self._clock())
        calm = {"running": theme.corrected, "complete": theme.corrected, "not begun": theme.muted}
        _, total, _ = self._watched.progress
        finished = len({event.get("step") for event in self._watched.events_of("finished")})
        self.setWindowTitle(f"{self._watched.folder.name} – {state}, {finished} of {total} sweeps – Flexura")
        self.badge.setText(state.upper())
        self.badge.setStyleSheet(
            f"background: {calm.get(state, theme.warning)}; color: {theme.plot}; font-weight: bold; "
            "padding: 4px 12px; border-radius: 4px;"
        )
        self.pause.setText("Pause" if state == "running" else "Continue")
        for part in (self.pause, self.stop, self._pause_action, self._stop_action):
            part.setEnabled(state in UNDER_WAY)
        trouble = "; ".join(f"{name}: {what}" for name, what in self._watched.problems.items())
        self.statusBar().setStyleSheet(f"color: {theme.warning};")
        self.statusBar().showMessage(trouble)
