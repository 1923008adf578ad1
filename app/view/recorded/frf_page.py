"""Measured FRFs over temperature, cut along both, with what was identified and updated laid over.

One sweep is shown over frequency: two parts of its FRF above each other, and its coherence.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QCheckBox, QComboBox, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from analysis.arrays import Real
from analysis.identification.modes import Modes
from analysis.recordings.frf import Frf, sweeps_of_modes
from app.view.chart import Chart, Map
from app.view.cursors import FREQUENCY, TEMPERATURE, Cursors, FrequencyAxis
from app.view.frf_plots import LEFT_AXIS_WIDTH, NyquistChart, PartsChoice, around, decibels
from app.view.map_chart import MapChart
from app.view.recorded.results import Answer, Computed, Identified, Results, answers
from app.view.theme import Theme, one_sided


class Mark:
    """A place in frequency and temperature that the cursors are compared with.

    Parameters
    ----------
    frf : Frf
    line, row : int
        Where it stands first: frequency line and sweep.
    """

    def __init__(self, frf: Frf, line: int, row: int) -> None:
        self._frf, self.line, self.row = frf, line, row

    def put(self, line: int, row: int) -> None:
        """Move it."""
        self.line, self.row = line, row

    def differences(self, line: int, row: int, channel: int) -> list[tuple[str, str]]:
        """Differences of a line of a sweep from the mark, for the readout; none where both are one.

        Parameters
        ----------
        line, row, channel : int
            Frequency line, sweep and output.

        Returns
        -------
        list of (str, str)
        """
        if (line, row) == (self.line, self.row):
            return []
        frf, here, there = self._frf, self._frf.h[row, channel, line], self._frf.h[self.row, channel, self.line]
        apart = frf.frequency[line] - frf.frequency[self.line], frf.temperature[row] - frf.temperature[self.row]
        turn = np.degrees(np.angle(here * np.conj(there)))
        return [
            ("from mark (M)", f"{apart[0]:+.2f} Hz, {apart[1]:+.2f} K"),
            ("", f"{float(decibels(here) - decibels(there)):+.2f} dB, {turn:+.1f}°"),
        ]


class AllSweeps(QCheckBox):
    """Switch that lays all sweeps under the one at the cursor.

    Parameters
    ----------
    chart : Chart
        Level over frequency.
    """

    def __init__(self, chart: Chart) -> None:
        super().__init__("all temperatures, cold to hot")
        self._chart = chart
        self._curves: list[object] = []

    def show_sweeps(self, frequency: Real, level: Real, temperature: Real) -> None:
        """Draw sweeps (T, F), dB, in the colours of their temperatures (T,), or none where it is switched off.

        Parameters
        ----------
        frequency : (F,) ndarray
            Hz.
        level : (T, F) ndarray
            dB.
        temperature : (T,) ndarray
            Degrees Celsius.
        """
        for curve in self._curves:
            self._chart.removeItem(curve)
        self._curves = []
        if not self.isChecked():
            return
        low, high = float(temperature.min()), float(temperature.max())
        for own, t in zip(level, temperature, strict=True):
            color = self._chart.theme.temperature((float(t) - low) / (high - low) if high > low else 0.5)
            curve = self._chart.curve(frequency, own, f"{t:.2f} °C", color, width=0.8, named=False)
            curve.setZValue(-3)
            self._curves.append(curve)


def readout(frf: Frf, row: int, channel: int, line: int, more: Sequence[tuple[str, str]] = ()) -> str:
    """Return one measured value with its uncertainty as a table in HTML.

    Parameters
    ----------
    row, channel, line : int
        Sweep, output and frequency line.
    more : sequence of (str, str)
        Further rows, below.
    """
    value = frf.h[row, channel, line]
    values = [
        ("frequency", f"{frf.frequency[line]:.2f} Hz"),
        ("temperature", f"{frf.temperature[row]:.3f} °C"),
        ("|H1|", f"{abs(value):.4g} {frf.unit(channel, row)} = {decibels(value):.2f} dB"),
        ("phase", f"{np.degrees(np.angle(value)):.1f}°"),
        ("σ of H1", f"{np.sqrt(frf.variance[row, channel, line]):.2g} {frf.unit(channel, row)}"),
        ("coherence", f"{frf.coherence[row, channel, line]:.6f}"),
    ]
    if frf.excluded[line]:
        values.append(("mains line", "never fitted"))
    rows = "".join(
        f"<tr><td style='padding-right:12px'>{what}</td><td>{seen}</td></tr>" for what, seen in (*values, *more)
    )
    return f"<table>{rows}</table>"


OVER_MAP = (255, 255, 255, 170)
"""Colour of lines on a map."""
TRACKS = "tracked modes"


class FrfChoices(QWidget):
    """Sensor, run of sweeps, parts of the FRF, and switches of what is laid over.

    Parameters
    ----------
    channels, runs : sequence of str
    overlays : mapping of str to (str, str)
        Names of what may be laid over, with style and colour of its line.
    off : sequence of str
        Those that are not laid over at first.

    Attributes
    ----------
    changed : Signal()
        Something else was chosen.
    channel, sweeps : QComboBox
    display : PartsChoice
    overlays : dict of str to QCheckBox
    """

    changed = Signal()

    def __init__(
        self,
        channels: Sequence[str],
        runs: Sequence[str],
        overlays: Mapping[str, tuple[str, str]],
        off: Sequence[str],
    ) -> None:
        super().__init__()
        self.channel, self.sweeps, self.display = _choice(channels), _choice(runs), PartsChoice()
        self.overlays = {name: _switch(name, *line) for name, line in overlays.items()}
        chooser, whole = QHBoxLayout(), QVBoxLayout(self)
        for word, choice in (("sensor", self.channel), ("sweeps", self.sweeps)):
            chooser.addWidget(QLabel(word))
            chooser.addWidget(choice)
        self.display.setMinimumWidth(80)
        chooser.addWidget(self.display, stretch=1)
        self._grid = QGridLayout()
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addLayout(chooser)
        whole.addLayout(self._grid)
        for name, switch in self.overlays.items():
            switch.setChecked(name not in off)
            self.add(switch)
        for box in (self.channel, self.sweeps, self.display):
            box.currentIndexChanged.connect(lambda _: self.changed.emit())

    def add(self, switch: QCheckBox) -> None:
        """Put a switch beside the others, two in a row."""
        self._grid.addWidget(switch, *divmod(self._grid.count(), 2))
        switch.toggled.connect(lambda _: self.changed.emit())

    def on(self, name: str) -> bool:
        """Whether something is to be laid over."""
        return self.overlays[name].isChecked()


def _choice(names: Sequence[str]) -> QComboBox:
    box = QComboBox()
    box.addItems(list(names))
    box.setEnabled(len(names) > 1)
    return box


def _switch(name: str, line: str, color: str) -> QCheckBox:
    switch = QCheckBox(name)
    switch.setStyleSheet(f"QCheckBox {{ border-left: 4px {line} {color}; padding-left: 6px; }}")
    return switch


DEVIATION = "standard deviation"


class SweepCut:
    """Plots of one sweep; `show` brings another one.

    Parameters
    ----------
    frf : Frf
    display : PartsChoice
    colors : mapping of str to str
        Colours of what may be laid over, by its name.
    theme : Theme

    Attributes
    ----------
    above, below, coherence : Chart
    """

    def __init__(self, frf: Frf, display: PartsChoice, colors: Mapping[str, str], theme: Theme) -> None:
        self._frf, self._display = frf, display
        self.above = Chart("frf-at-temperature", "", FREQUENCY, "", theme)
        self.below = Chart("phase-at-temperature", "", FREQUENCY, "", theme)
        self.coherence = Chart("coherence", "", FREQUENCY, "coherence", theme)
        self._trust = self.coherence.curve([], [], "coherence", theme.measured)
        self.coherence.least = (0.0, 1.0)
        self.coherence.setYRange(0.0, 1.0, padding=0.05)
        self._curves = {
            name: (
                self.above.curve([], [], name, color, width=1.6 if name == "measured" else 1.0),
                self.below.curve([], [], name, color),
            )
            for name, color in ({"measured": theme.measured} | dict(colors)).items()
        }
        low, high = (float(x) for x in np.percentile(decibels(frf.h), (1.0, 99.95)))
        self.levels = (low - 4.0, high + 4.0)

    def scale(self, channel: int, rows: NDArray[np.intp]) -> None:
        """Show ranges that hold all sweeps of an output, so that one sweep can be compared with the next.

        Parameters
        ----------
        rows : (R,) int ndarray
            Sweeps that can be chosen.
        """
        self._display.label(self.above, self.below, self._frf.unit(channel, int(rows[0])))
        if not self._display.cartesian:
            self.above.setYRange(*self.levels, padding=0.0)
            return
        h = self._frf.h[rows, channel]
        for chart, part in ((self.above, h.real), (self.below, h.imag)):
            chart.setYRange(float(part.min()), float(part.max()), padding=0.05)

    def show(self, row: int, channel: int, shown: Mapping[str, Answer], *, deviation: bool) -> None:
        """Draw a sweep.

        Parameters
        ----------
        row, channel : int
            Sweep and output.
        shown : mapping of str to Answer
            The measured FRFs and what is laid over them.
        deviation : bool
            Whether the standard deviation of the measured FRF is drawn, too.
        """
        frf, spread = self._frf, np.sqrt(self._frf.variance[row, channel])
        for name, curves in self._curves.items():
            for curve in curves:
                curve.setVisible(name in shown)
        for name, answer in shown.items():
            own = spread if name == "measured" else 0.0
            self._display.draw(self._curves[name], answer.frequency, answer.sweep(row)[channel], own)
        curve = self._curves[DEVIATION][0]
        curve.setVisible(deviation)
        curve.setData(frf.frequency, spread / np.sqrt(2.0) if self._display.cartesian else decibels(spread))
        self._trust.setData(frf.frequency, frf.coherence[row, channel])
        bands = [answer.narrower(row) for answer in shown.values() if isinstance(answer, Identified)]
        identified = [f"identified from {band[0]:.0f} to {band[1]:.0f} Hz" for band in bands if band is not None]
        place = f"at {frf.temperature[row]:.2f} °C, on the way {frf.direction[row]}"
        self.above.setTitle("; ".join([place, *identified]))


class FrfPage(QWidget):
    """Waterfall with the two cuts that its cursors choose, and the Nyquist plane around them.

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
        self._frf, self._cursors, self._theme, self._modes = frf, cursors, theme, results.modes
        units = set(frf.units or [frf.unit(0)])
        self._level = f"|H| [dB re 1 {units.pop()}]" if len(units) == 1 else "|H| [dB]"
        runs = [f"{way}, {frf.drive(s)}" for s, way in enumerate(frf.direction)]
        self._of_run = np.array(runs)
        self._answers = answers(frf, results)
        self._colors = {name: _color(name, theme) for name in self._answers}
        lines = {name: ("solid", color) for name, color in self._colors.items()}
        lines |= {DEVIATION: ("solid", theme.muted)}
        lines |= {} if self._modes is None else {TRACKS: ("dotted", theme.text)}
        self.choices = FrfChoices(frf.channels, list(dict.fromkeys(runs)), lines, (DEVIATION,))
        self._waterfall = MapChart("waterfall", "FRF over temperature", FREQUENCY, TEMPERATURE, theme)
        self._along_t = Chart("frf-at-frequency", "", self._level, TEMPERATURE, theme)
        self.cut = SweepCut(frf, self.choices.display, self._colors | {DEVIATION: theme.muted}, theme)
        self.nyquist = NyquistChart("nyquist", self._colors, theme)
        self._every = AllSweeps(self.cut.above)
        self.axis = FrequencyAxis(frf.frequency, cursors)
        self._readout = QLabel()
        self._lay_out()
        self._draw()
        self._mark = Mark(frf, self.axis.line, self.row)
        self._choose()
        self.choices.changed.connect(self._choose)
        cursors.frequency_moved.connect(self._cut_temperature)
        cursors.temperature_moved.connect(self._cut_frequency)

    @property
    def rows(self) -> NDArray[np.intp]:
        """Sweeps shown, the coldest first."""
        mine = np.flatnonzero(self._of_run == self.choices.sweeps.currentText())
        return mine[np.argsort(self._frf.temperature[mine], kind="stable")]

    @property
    def row(self) -> int:
        """Sweep nearest to the temperature cursor."""
        rows = self.rows
        return int(rows[np.abs(self._frf.temperature[rows] - self._cursors.temperature).argmin()])

    @property
    def _channel(self) -> int:
        return self.choices.channel.currentIndex()

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

    def _lay_out(self) -> None:
        panel, grid, cut = QVBoxLayout(), QGridLayout(self), self.cut
        self._readout.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._readout.setObjectName("readout")
        self.choices.add(self._every)
        self.choices.add(self.axis)
        panel.addWidget(self.choices)
        panel.addWidget(self._readout)
        panel.addWidget(self.nyquist, stretch=1)
        grid.addWidget(self._waterfall, 0, 0)
        grid.addWidget(self._along_t, 0, 1)
        grid.addLayout(panel, 1, 1, 3, 1)
        for row, (chart, share) in enumerate(
            ((self._waterfall, 9), (cut.above, 9), (cut.below, 6), (cut.coherence, 5))
        ):
            grid.addWidget(chart, row, 0)
            grid.setRowStretch(row, share)
            self.axis.add(chart)
            if chart is not self._waterfall:
                self._waterfall.stand_over(chart)
        for column, share in enumerate((7, 4)):
            grid.setColumnStretch(column, share)
        for chart in (self._waterfall, self._along_t, cut.above, cut.below, cut.coherence):
            chart.getAxis("left").setWidth(LEFT_AXIS_WIDTH)

    def _draw(self) -> None:
        cursors, theme = self._cursors, self._theme

        def to_temperature(value: float) -> None:
            known = self._frf.temperature[self.rows]
            cursors.temperature = float(known[np.abs(known - value).argmin()])

        for chart in (self._waterfall, self._along_t):
            chart.follow("y", cursors.temperature, cursors.temperature_moved, to_temperature)
        self._along_t.setYLink(self._waterfall)
        low, high = self.cut.levels
        nothing = Map(self._frf.frequency, np.array([0.0, 1.0]), np.zeros((2, len(self._frf.frequency))))
        self._waterfall.image(nothing, one_sided(), (low + 4.0, high - 4.0), self._level)
        self._along_t.setXRange(low, high, padding=0.0)
        self._lines: list[object] = []
        self._points = {"measured": self._along_t.curve([], [], "measured", theme.measured, points=True)}
        self._points |= {name: self._along_t.curve([], [], name, color) for name, color in self._colors.items()}

    def _choose(self) -> None:
        """Show another sensor, direction, level, other parts or another overlay."""
        frf, rows, channel = self._frf, self.rows, self._channel
        self._waterfall.show_map(Map(frf.frequency, frf.temperature[rows], decibels(frf.h[rows, channel])))
        self._waterfall.setTitle(f"FRF over temperature: {frf.label(channel, int(rows[0]))}")
        span = float(frf.temperature[rows].min()), float(frf.temperature[rows].max())
        reach = 0.55 * (span[1] - span[0]) / max(len(rows) - 1, 1) or 0.5
        self._waterfall.setYRange(span[0] - reach, span[1] + reach, padding=0.0)
        for line in self._lines:
            self._waterfall.removeItem(line)
        self._lines = []
        self._every.show_sweeps(
            frf.frequency, self.choices.display.first(frf.h[rows, channel]), frf.temperature[rows]
        )
        modes, shown = self._modes, frf.temperature[rows]
        found = None if modes is None else sweeps_of_modes(frf, modes)[rows]
        if modes is not None and found is not None and (found >= 0).all() and self.choices.on(TRACKS):
            self._lines = [
                self._waterfall.curve(f, shown, f"mode {j}", OVER_MAP, style="dot", width=1.4)
                for j, f in enumerate(modes.reading().frequency_hz[found].T, start=1)
            ]
        self.cut.scale(channel, rows)
        self._cut_frequency()
        self._cut_temperature()

    def _shown(self) -> dict[str, Answer]:
        """All that is switched on."""
        on = {name: answer for name, answer in self._answers.items() if self.choices.on(name)}
        return {"measured": Computed(self._frf.frequency, self._frf.h), **on}

    def _cut_frequency(self) -> None:
        """Draw the sweep at the temperature cursor."""
        self.cut.show(self.row, self._channel, self._shown(), deviation=self.choices.on(DEVIATION))
        self._circle()
        self._read_out()

    def _cut_temperature(self) -> None:
        """Draw all sweeps at the frequency cursor."""
        rows, channel, line = self.rows, self._channel, self.axis.line
        shown = self._shown()
        for name, points in self._points.items():
            points.setVisible(name in shown)
            if name in shown:
                h = shown[name].line(rows, float(self._frf.frequency[line]))[:, channel]
                points.setData(decibels(h), self._frf.temperature[rows])
        self._along_t.setTitle(f"at {self._frf.frequency[line]:.2f} Hz")
        self._circle()
        self._read_out()

    def _circle(self) -> None:
        """Draw the Nyquist plane around the frequency cursor, of the sweep at the temperature cursor."""
        frf, row, channel, line = self._frf, self.row, self._channel, self.axis.line
        near = around(frf.frequency, line, self._modes_of(row))
        band = float(frf.frequency[near][0]), float(frf.frequency[near][-1])
        models = {
            name: answer.between(row, band)[channel]
            for name, answer in self._shown().items()
            if name != "measured"
        }
        h = frf.h[row, channel]
        self.nyquist.show_circle(h[near], complex(h[line]), models, frf.unit(channel, row))

    def _modes_of(self, row: int) -> Modes | None:
        place = -1 if self._modes is None else int(sweeps_of_modes(self._frf, self._modes)[row])
        return None if self._modes is None or place < 0 else self._modes.modes[place]

    def _read_out(self) -> None:
        from_mark = self._mark.differences(self.axis.line, self.row, self._channel)
        self._readout.setText(readout(self._frf, self.row, self._channel, self.axis.line, from_mark))


def _color(name: str, theme: Theme) -> str:
    return {
        "from poles and residues": theme.identified,
        "updated twin": theme.twin,
        "corrected twin": theme.corrected,
    }[name]
