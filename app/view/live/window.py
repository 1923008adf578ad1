"""The window on a campaign being acquired: its repeat recorded last, the FRF of the sweep before, the oven."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pyqtgraph
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

from app.files.acquisition.events import LatestRepeat, request, seconds
from app.summaries.numbers import duration
from app.view.chart import Chart
from app.view.theme import Theme
from app.view.window import Window
from app.watch.watched import FRFS_SHOWN, Watched, set_point_line
from app.watch.words import in_words, said_at

LOWEST_LEVEL = -100.0
"""Lowest level shown, dB re full scale."""


class SignalChart(Chart):
    """Every channel over time, each to its own scale and on its own line, as on an oscilloscope.

    Parameters
    ----------
    channels : tuple of str
        The drive, then the sensors.
    theme : Theme
    """

    def __init__(self, channels: tuple[str, ...], theme: Theme) -> None:
        super().__init__("signals", "repeat recorded last", "time [s]", "", theme)
        self._lines = [
            self.curve([], [], f"{name} [share of its peak, from {-place}]", _color(place, theme))
            for place, name in enumerate(channels)
        ]
        self.setDownsampling(auto=True, mode="peak")
        self.setYRange(-len(channels) + 0.4, 0.6, padding=0.02)

    def show_repeat(self, latest: LatestRepeat) -> None:
        """Draw it."""
        time = np.arange(latest.signals.shape[1]) / latest.sample_rate
        ticks = []
        for place, (line, name, signal) in enumerate(
            zip(self._lines, latest.channels, latest.signals.astype(float), strict=True)
        ):
            peak = float(np.abs(signal).max())
            line.setData(time, 0.45 * signal / (peak or 1.0) - place)
            ticks.append((-float(place), f"{name}\n{peak:.3g} V"))
        self.getAxis("left").setTicks([ticks])
        self.setXRange(0.0, float(time[-1]), padding=0.01)
        self.setTitle(f"repeat {latest.repeat + 1} of {latest.place}")


class SpectrumChart(Chart):
    """Amplitude spectrum of every channel.

    Parameters
    ----------
    channels : tuple of str
    theme : Theme
    """

    def __init__(self, channels: tuple[str, ...], theme: Theme) -> None:
        super().__init__("spectrum", "its spectrum", "frequency [Hz]", "amplitude [dB re 1 V]", theme)
        self.legend(columns=2)
        self._lines = [self.curve([], [], name, _color(place, theme)) for place, name in enumerate(channels)]
        self.setDownsampling(auto=True, mode="peak")

    def show_repeat(self, latest: LatestRepeat) -> None:
        """Draw it, from 10 Hz to half the sample rate."""
        count = latest.signals.shape[1]
        frequency = np.fft.rfftfreq(count, 1.0 / latest.sample_rate)
        shown = frequency > 10.0
        amplitude = 2.0 / count * np.abs(np.fft.rfft(latest.signals.astype(float), axis=1))
        levels = 20.0 * np.log10(amplitude[:, shown] + 1e-12)
        for line, level in zip(self._lines, levels, strict=True):
            line.setData(frequency[shown], level)
        self.setXRange(0.0, float(frequency[-1]), padding=0.01)
        self.setYRange(float(np.percentile(levels, 1.0)), float(levels.max()) + 6.0, padding=0.02)


class LevelChart(Chart):
    """Level meters: rms and peak of every channel against full scale, and a mark on those that clipped.

    Parameters
    ----------
    channels : tuple of str
    theme : Theme
    """

    def __init__(self, channels: tuple[str, ...], theme: Theme) -> None:
        super().__init__("levels", "levels", "", "dB re full scale", theme)
        place = np.arange(len(channels))
        self._peak = pyqtgraph.BarGraphItem(
            x=place, height=0.0, width=0.7, y0=LOWEST_LEVEL, brush=theme.muted, pen=None
        )
        self._rms = pyqtgraph.BarGraphItem(
            x=place, height=0.0, width=0.7, y0=LOWEST_LEVEL, brush=theme.corrected, pen=None
        )
        self._peak.setOpacity(0.5)
        for item in (self._peak, self._rms):
            self.addItem(item)
        self.addItem(pyqtgraph.InfiniteLine(0.0, angle=0, pen=pyqtgraph.mkPen(theme.warning, width=2)))
        self._clipped = [
            pyqtgraph.TextItem("CLIP", color=theme.plot, fill=theme.warning, anchor=(0.5, 1)) for _ in place
        ]
        for at, mark in zip(place, self._clipped, strict=True):
            mark.setPos(float(at), -2.0)
            mark.hide()
            self.addItem(mark)
        self._numbers = self.curve([], [], "peak [dB re full scale]", theme.text, named=False)
        self._numbers.setPen(None)  # for the export
        self.getAxis("bottom").setTicks([list(zip(place.tolist(), channels, strict=True))])
        self.setYRange(LOWEST_LEVEL, 8.0, padding=0.0)
        self.setXRange(-0.6, len(channels) - 0.4, padding=0.0)

    @property
    def clipped(self) -> list[bool]:
        """Channels that are marked, the drive first."""
        return [mark.isVisible() for mark in self._clipped]

    def show_repeat(self, latest: LatestRepeat) -> None:
        """Draw it."""
        signals = latest.signals.astype(float)
        peak = _level(np.abs(signals).max(axis=1), latest.full_scale)
        self._peak.setOpts(height=peak - LOWEST_LEVEL)
        self._rms.setOpts(height=_level(np.sqrt((signals**2).mean(axis=1)), latest.full_scale) - LOWEST_LEVEL)
        self._numbers.setData(np.arange(len(peak)), peak)
        for mark, over in zip(self._clipped, latest.overloaded, strict=True):
            mark.setVisible(bool(over))


class FrfChart(Chart):
    """FRFs of one sensor, the last one strong, earlier ones in the colour of their temperature.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("live-frf", "FRFs as they come", "frequency [Hz]", "|H| [dB]", theme)
        self._before = [self.curve([], [], "", theme.muted, named=False) for _ in range(FRFS_SHOWN - 1)]
        self._last = self.curve([], [], "last", theme.measured, width=2.0)

    def show_campaign(self, watched: Watched, channel: int) -> None:
        """Draw them."""
        steps = sorted(watched.sweeps)
        if not steps:
            return
        span = watched.experiment.protocol.temperatures
        low, high = min(span), max(span)
        for item, step in zip(self._before, [*steps[:-1], *[None] * FRFS_SHOWN], strict=False):
            item.setVisible(step is not None)
            if step is not None:
                sweep = watched.sweeps[step]
                share = float(np.clip((sweep.temperature - low) / max(high - low, 1e-9), 0.0, 1.0))
                item.setPen((*self.theme.temperature(share), 150), width=1.0)
                item.setData(sweep.frequency, _decibels(sweep.h[channel]))
                item.opts["label"] = f"{sweep.temperature:.2f} °C {sweep.direction}"
        last = watched.sweeps[steps[-1]]
        self._last.setData(last.frequency, _decibels(last.h[channel]))
        self._last.opts["label"] = f"{last.temperature:.2f} °C {last.direction}"
        self.setTitle(f"{watched.experiment.labels()[channel]}: {last.temperature:.2f} °C over those before")


class CoherenceChart(Chart):
    """Coherence of the last sweep over that of the one before.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("live-coherence", "", "frequency [Hz]", "coherence", theme)
        self._before = self.curve([], [], "before", theme.muted)
        self._last = self.curve([], [], "last", theme.measured, width=1.6)
        self.least = (0.0, 1.0)
        self.setYRange(0.0, 1.02, padding=0.0)

    def show_campaign(self, watched: Watched, channel: int) -> None:
        """Draw them."""
        items: list[Any] = [self._last, self._before]
        for item, step in zip(items, sorted(watched.sweeps, reverse=True), strict=False):
            item.setData(watched.sweeps[step].frequency, watched.sweeps[step].coherence[channel])


MARKS = {"finished": "o", "rejected": "x", "missing": "t"}


class OvenChart(Chart):
    """Air, plate, set-point and programme over time.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("oven", "oven and plate against the programme", "time [min]", "temperature [°C]", theme)
        self.legend(columns=4, offset=(8, 4))
        self._programme = self.curve([], [], "programme", theme.muted, style="dash")
        self._set_point = self.curve([], [], "set-point", theme.corrected, width=1.4)
        self._air = self.curve([], [], "air", theme.identified, width=1.4)
        self._plate = self.curve([], [], "plate", theme.twin, width=2.0)
        self._asked = self._mark("asked for", "o", None, theme.muted)
        colors = {"finished": theme.measured, "rejected": theme.warning, "missing": theme.warning}
        self._marks = {
            kind: self._mark(kind, symbol, colors[kind], colors[kind]) for kind, symbol in MARKS.items()
        }

    def _mark(self, label: str, symbol: str, fill: str | None, edge: str) -> pyqtgraph.PlotDataItem:
        item = self.plot(
            [], [], pen=None, symbol=symbol, symbolSize=9, symbolBrush=fill, symbolPen=edge, name=label
        )
        item.opts["label"] = label
        return item

    def show_campaign(self, watched: Watched) -> None:
        """Draw all that is known."""
        if not watched.readings:
            return
        origin = seconds(watched.events[0]["date"]) if watched.events else seconds(watched.readings[0].date)

        def minutes(date: str) -> float:
            return (seconds(date) - origin) / 60.0

        time = np.array([minutes(reading.date) for reading in watched.readings])
        air = np.array([reading.air_c for reading in watched.readings])
        self._air.setData(time, air)
        self._plate.setData(time, np.array([reading.plate_c for reading in watched.readings]))
        commands = watched.events_of("oven")
        line = set_point_line(
            commands, [60.0 * minutes(c["date"]) for c in commands], 60.0 * time, air, 60.0 * float(time[-1])
        )
        self._set_point.setData(line[0] / 60.0, line[1], connect="finite")
        if (planned := watched.course) is not None:
            since, course = planned
            self._programme.setData((since - origin + course.time) / 60.0, course.temperature)
            self._asked.setData((since - origin + course.asked_at) / 60.0, course.asked)
        for kind, item in self._marks.items():
            happened = watched.events_of(kind)
            at = [minutes(event["date"]) for event in happened]
            item.setData(np.array(at), np.array([_temperature(watched, event) for event in happened]))


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


def _level(volts: np.ndarray, full_scale: float) -> np.ndarray:
    return np.asarray(np.maximum(20.0 * np.log10(volts / full_scale + 1e-12), LOWEST_LEVEL))


def _color(place: int, theme: Theme) -> str:
    return theme.muted if place == 0 else str(theme.series(place - 1))


def _decibels(h: np.ndarray) -> np.ndarray:
    return np.asarray(20.0 * np.log10(np.abs(h) + 1e-12))


def _temperature(watched: Watched, event: dict[str, object]) -> float:
    if "temperature" in event:
        return float(str(event["temperature"]))
    if watched.protocol is not None:
        for leg in watched.protocol.legs:
            for point in leg.set_points:
                if point.step == event.get("step"):
                    return point.temperature
    return float("nan")
