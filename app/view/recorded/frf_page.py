"""Measured FRFs over temperature, cut along both, with what was identified and updated laid over."""

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QCheckBox, QComboBox, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from analysis.chosen_actuator import sweeps_of_modes
from analysis.frf import Frf
from app.view.chart import Chart
from app.view.cursors import Cursors
from app.view.frequency_axis import FrequencyAxis
from app.view.map import Map
from app.view.map_chart import MapChart
from app.view.recorded.all_sweeps import AllSweeps
from app.view.recorded.mark import Mark
from app.view.recorded.overlays import Answer, Computed, answers, decibels
from app.view.recorded.readout import readout
from app.view.recorded.results import Results
from app.view.theme import Theme, one_sided

OVER_MAP = (255, 255, 255, 170)
"""Colour of lines on a map."""
FREQUENCY, TEMPERATURE = "frequency [Hz]", "temperature [°C]"
PHASE_TICKS = [[(v, f"{v}") for v in some] for some in ((-180, 0, 180), (-90, 90))]
"""Degrees: those that are always labelled, and those that are if there is room."""


class FrfPage(QWidget):
    """Waterfall with the two cuts that its cursors choose.

    Parameters
    ----------
    frf : Frf
    results : Results
        For what is laid over.
    cursors : Cursors
    theme : Theme
    """

    def __init__(self, frf: Frf, results: Results, cursors: Cursors, theme: Theme) -> None:
        super().__init__()
        self._frf, self._results, self._cursors, self._theme = frf, results, cursors, theme
        self._channel = _choice(list(frf.channels))
        units = set(frf.units or [frf.unit(0)])
        self._level = f"|H| [dB re 1 {units.pop()}]" if len(units) == 1 else "|H| [dB]"
        runs = [f"{way}, {frf.drive(s)}" for s, way in enumerate(frf.direction)]
        self._sweeps = _choice(list(dict.fromkeys(runs)))
        self._of_run = np.array(runs)
        self._waterfall = MapChart("waterfall", "FRF over temperature", FREQUENCY, TEMPERATURE, theme)
        self._along_t = Chart("frf-at-frequency", "", self._level, TEMPERATURE, theme)
        self._along_f = Chart("frf-at-temperature", "", FREQUENCY, self._level, theme)
        self._phase = Chart("phase-at-temperature", "", FREQUENCY, "phase [°]", theme)
        self._coherence = Chart("coherence", "coherence of one repeat", FREQUENCY, "", theme)
        self._answers = answers(frf, results)
        self._overlays = {name: self._switch(name, color) for name, color in self._offered().items()}
        self._tracks = self._switch("tracked modes", theme.text, "dotted")
        self._tracks.setVisible(results.modes is not None)
        self._every = AllSweeps(self._along_f)
        self.axis = FrequencyAxis(frf.frequency, cursors)
        self._lay_out()
        self._mark = Mark(frf, self.axis.line, self.row)
        self._choose()
        self._every.toggled.connect(self._choose)
        self._channel.currentIndexChanged.connect(self._choose)
        self._sweeps.currentIndexChanged.connect(self._choose)
        cursors.frequency_moved.connect(self._cut_temperature)
        cursors.temperature_moved.connect(self._cut_frequency)

    @property
    def rows(self) -> NDArray[np.intp]:
        """Sweeps shown, the coldest first."""
        mine = np.flatnonzero(self._of_run == self._sweeps.currentText())
        return mine[np.argsort(self._frf.temperature[mine], kind="stable")]

    @property
    def row(self) -> int:
        """Sweep nearest to the temperature cursor."""
        rows = self.rows
        return int(rows[np.abs(self._frf.temperature[rows] - self._cursors.temperature).argmin()])

    def step(self, lines: int, sweeps: int) -> None:
        """Move the cursors by so many lines and sweeps."""
        if lines:
            self.axis.step(lines)
        if sweeps:
            rows = self.rows
            place = np.clip(int(np.flatnonzero(rows == self.row)[0]) + sweeps, 0, len(rows) - 1)
            self._cursors.temperature = float(self._frf.temperature[rows[place]])

    def mark(self) -> None:
        """Put the mark where the cursors stand; differences are given from there."""
        self._mark.put(self.axis.line, self.row)
        self.axis.put_mark()
        self._read_out()

    def _offered(self) -> dict[str, str]:
        theme = self._theme
        colors = {
            "from poles and residues": theme.identified,
            "updated twin": theme.twin,
            "corrected twin": theme.corrected,
        }
        return {name: colors[name] for name in self._answers} | {"standard deviation": theme.muted}

    def _switch(self, name: str, color: str, line: str = "solid") -> QCheckBox:
        switch = QCheckBox(name)
        switch.setChecked(name != "standard deviation")
        switch.setStyleSheet(f"QCheckBox {{ border-left: 4px {line} {color}; padding-left: 6px; }}")
        switch.toggled.connect(self._choose)
        return switch

    def _lay_out(self) -> None:
        panel = QVBoxLayout()
        self._readout = QLabel()
        self._readout.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._readout.setObjectName("readout")
        chooser = QHBoxLayout()
        for word, choice in (("sensor", self._channel), ("sweeps", self._sweeps)):
            chooser.addWidget(QLabel(word))
            chooser.addWidget(choice)
        chooser.addStretch()
        panel.addLayout(chooser)
        for switch in (*self._overlays.values(), self._tracks, self._every, self.axis):
            panel.addWidget(switch)
        panel.addWidget(self._readout)
        panel.addWidget(self._coherence, stretch=1)
        grid = QGridLayout(self)
        grid.addWidget(self._waterfall, 0, 0)
        grid.addWidget(self._along_t, 0, 1)
        grid.addWidget(self._along_f, 1, 0)
        grid.addWidget(self._phase, 2, 0)
        grid.addLayout(panel, 1, 1, 2, 1)
        for column, share in enumerate((7, 3)):
            grid.setColumnStretch(column, share)
        for row, share in enumerate((5, 5, 3)):
            grid.setRowStretch(row, share)
        cursors = self._cursors

        def to_temperature(value: float) -> None:
            known = self._frf.temperature[self.rows]
            cursors.temperature = float(known[np.abs(known - value).argmin()])

        for chart in (self._waterfall, self._along_f, self._phase, self._coherence):
            self.axis.add(chart)
        for chart in (self._waterfall, self._along_t):
            chart.follow("y", cursors.temperature, cursors.temperature_moved, to_temperature)
        for chart in (self._along_f, self._phase):
            self._waterfall.stand_over(chart)
        self._along_t.setYLink(self._waterfall)
        self._draw_map()
        for chart in (self._along_f, self._phase, self._along_t, self._waterfall):
            chart.getAxis("left").setWidth(58)

    def _draw_map(self) -> None:
        level = decibels(self._frf.h)
        low, high = (float(x) for x in np.percentile(level, (1.0, 99.95)))
        shown = Map(self._frf.frequency, np.array([0.0, 1.0]), np.zeros((2, len(self._frf.frequency))))
        self._waterfall.image(shown, one_sided(), (low, high), self._level)
        self._along_f.setYRange(low - 4.0, high + 4.0, padding=0.0)
        self._along_t.setXRange(low - 4.0, high + 4.0, padding=0.0)
        self._phase.setYRange(-180.0, 180.0, padding=0.1)
        self._phase.getAxis("left").setTicks(PHASE_TICKS)
        self._lines: list[object] = []
        theme = self._theme
        self._trust = self._coherence.curve([], [], "coherence", theme.measured)
        self._cuts = {
            "measured": (
                self._along_f.curve([], [], "measured", theme.measured, width=1.6),
                self._phase.curve([], [], "measured", theme.measured),
                self._along_t.curve([], [], "measured", theme.measured, points=True),
            )
        }
        for name, color in self._offered().items():
            curves = [self._along_f.curve([], [], name, color)]
            if name in self._answers:
                curves += [self._phase.curve([], [], name, color), self._along_t.curve([], [], name, color)]
            self._cuts[name] = tuple(curves)

    def _choose(self) -> None:
        """Show another sensor, direction, level or overlay."""
        frf, rows, channel = self._frf, self.rows, self._channel.currentIndex()
        self._waterfall.show_map(Map(frf.frequency, frf.temperature[rows], decibels(frf.h[rows, channel])))
        self._waterfall.setTitle(f"FRF over temperature: {frf.label(channel, int(rows[0]))}")
        span = float(frf.temperature[rows].min()), float(frf.temperature[rows].max())
        reach = 0.55 * (span[1] - span[0]) / max(len(rows) - 1, 1) or 0.5
        self._waterfall.setYRange(span[0] - reach, span[1] + reach, padding=0.0)
        for line in self._lines:
            self._waterfall.removeItem(line)
        self._lines = []
        self._every.show_sweeps(frf.frequency, decibels(frf.h[rows, channel]), frf.temperature[rows])
        modes, shown = self._results.modes, frf.temperature[rows]
        found = None if modes is None else sweeps_of_modes(frf, modes)[rows]
        if self._tracks.isChecked() and modes is not None and found is not None and (found >= 0).all():
            self._lines = [
                self._waterfall.curve(f, shown, f"mode {j}", OVER_MAP, style="dot", width=1.4)
                for j, f in enumerate(modes.reading().frequency_hz[found].T, start=1)
            ]
        self._cut_frequency()
        self._cut_temperature()

    def _shown(self) -> dict[str, Answer]:
        """All that is switched on."""
        on = {name: answer for name, answer in self._answers.items() if self._overlays[name].isChecked()}
        return {"measured": Computed(self._frf.frequency, self._frf.h), **on}

    def _cut_frequency(self) -> None:
        """Draw the sweep at the temperature cursor."""
        row, channel, frf = self.row, self._channel.currentIndex(), self._frf
        shown = self._shown()
        for name, curves in self._cuts.items():
            for curve in curves[:2]:
                curve.setVisible(name in shown)
        for name, answer in shown.items():
            h = answer.sweep(row)[channel]
            self._cuts[name][0].setData(answer.frequency, decibels(h))
            self._cuts[name][1].setData(answer.frequency, np.degrees(np.angle(h)))
        spread = self._cuts["standard deviation"][0]
        spread.setVisible(self._overlays["standard deviation"].isChecked())
        spread.setData(frf.frequency, 10.0 * np.log10(frf.variance[row, channel] + 1e-40))
        self._trust.setData(frf.frequency, frf.coherence[row, channel])
        self._coherence.fit()
        self._along_f.setTitle(f"at {frf.temperature[row]:.2f} °C, on the way {frf.direction[row]}")
        self._read_out()

    def _cut_temperature(self) -> None:
        """Draw all sweeps at the frequency cursor."""
        rows, channel, line = self.rows, self._channel.currentIndex(), self.axis.line
        shown = self._shown()
        for name, curves in self._cuts.items():
            for curve in curves[2:]:
                curve.setVisible(name in shown)
            if name in shown:
                h = shown[name].line(rows, float(self._frf.frequency[line]))[:, channel]
                curves[-1].setData(decibels(h), self._frf.temperature[rows])
        self._along_t.setTitle(f"at {self._frf.frequency[line]:.2f} Hz")
        self._read_out()

    def _read_out(self) -> None:
        channel = self._channel.currentIndex()
        from_mark = self._mark.differences(self.axis.line, self.row, channel)
        self._readout.setText(readout(self._frf, self.row, channel, self.axis.line, from_mark))


def _choice(names: list[str]) -> QComboBox:
    box = QComboBox()
    box.addItems(names)
    box.setEnabled(len(names) > 1)
    return box
