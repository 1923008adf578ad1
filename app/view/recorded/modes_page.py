"""Poles followed over temperature, and the shape that the twin gives to each."""

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QComboBox, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from analysis.drawn_curves import in_lines
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from app.summaries.modes import NUMBERS, READ_AS, SWEEP_HEADINGS, shown_poles, sweep_rows
from app.summaries.numbers import with_sigma
from app.view.chart import Chart
from app.view.cursors import FREQUENCY, TEMPERATURE, Cursors
from app.view.mode_table import ModeTable
from app.view.recorded.mode_shape import ModeShape
from app.view.theme import Theme

LARGEST_LOSS_BAND = 0.3
"""Loss factors with a two-sigma band wider than this share are left out: they would hide what is known."""

THIN, THICK = 1.1, 3.2
"""Dots of the lines of modes, and of the mode that stands out."""


class ModesPage(QWidget):
    """Frequency, its change, and loss factor of every mode, with two-sigma bands; table of one sweep; a shape.

    Parameters
    ----------
    tracked : TrackedModes
    shape : ModeShape or None
        None where no twin was updated.
    cursors : Cursors
    theme : Theme
    """

    def __init__(self, tracked: TrackedModes, shape: ModeShape | None, cursors: Cursors, theme: Theme) -> None:
        super().__init__()
        self._tracked, self.shape, self._cursors, self._theme = tracked, shape, cursors, theme
        runs = np.array(
            [
                f"{way}, {level:g} {tracked.level_unit}"
                for way, level in zip(tracked.direction, tracked.level, strict=True)
            ]
        )
        first = np.flatnonzero(runs == runs[0])
        self._rows = first[np.argsort(tracked.temperature[first], kind="stable")]
        self._reading = tracked.reading()
        self._storage = tracked.reading("hysteretic").frequency_hz  # as the twin gives it
        self._selected = 0
        self._lines: list[list[tuple[object, str]]] = []
        self._charts = (
            Chart("tracks-frequency", "where the modes are", TEMPERATURE, FREQUENCY, theme),
            Chart("tracks-change", "how far they move", TEMPERATURE, "change from the cursor [%]", theme),
            Chart("tracks-damping", "how they are damped", TEMPERATURE, "loss factor [%]", theme),
        )
        self._choice = QComboBox()
        self._choice.addItems([self._named(j) for j in range(tracked.track.shape[1])])
        self._readout = QLabel()
        self._readout.setObjectName("mode")
        self.table = ModeTable(SWEEP_HEADINGS, NUMBERS)
        self.table.verticalHeader().hide()  # the modes have numbers of their own
        self.table.setToolTip(READ_AS[tracked.damping])
        self._lay_out()
        self._draw()
        self._fill_table()
        self._choice.currentIndexChanged.connect(self.select)
        self.table.chosen.connect(self._go)
        cursors.frequency_moved.connect(self._follow)
        for follower in (self._tell, self._change, self._fill_table):
            cursors.temperature_moved.connect(follower)
        self.select(self._best_known())

    @property
    def selected(self) -> int:
        """Mode that stands out, from 0."""
        return self._selected

    @property
    def ready(self) -> bool:
        """Whether the selected mode's shape can be seen, if there is to be one."""
        return self.shape is None or self.shape.chart is not None

    def select(self, mode: int) -> None:
        """Let one mode stand out, and take the frequency cursor there."""
        self._stand_out(int(np.clip(mode, 0, self._tracked.track.shape[1] - 1)))
        here = self._reading.frequency_hz[self._row, self._selected]
        if np.isfinite(here):
            self._cursors.frequency = float(here)

    def step(self, modes: int) -> None:
        """Select a mode further up or down."""
        self.select(self._selected + modes)

    def _stand_out(self, mode: int) -> None:
        before, self._selected = self._selected, mode
        with QSignalBlocker(self._choice):
            self._choice.setCurrentIndex(mode)
        for j, width in ((before, THIN), (mode, THICK)):
            for item, color in self._lines[j]:
                item.setPen(color, width=width)  # type: ignore[attr-defined]
        self._tell()
        self._mark()

    def _fill_table(self) -> None:
        """List the modes of the sweep at the temperature cursor."""
        modes, track = self._tracked.modes[self._row], self._tracked.track[self._row]
        poles = shown_poles(modes)
        self._places = modes.reading().frequency_hz[poles]
        self._numbers = [int(np.append(np.flatnonzero(track == pole), -1)[0]) for pole in poles]
        self.table.show_rows(sweep_rows(modes, track))
        self._mark()

    def _mark(self) -> None:
        """Mark the mode nearest to the frequency cursor, and print the one that stands out in bold."""
        if len(self._places):
            self.table.mark(self._nearest)
        self.table.print_bold([n for n, mode in enumerate(self._numbers) if mode == self._selected])

    @property
    def _nearest(self) -> int:
        return int(np.abs(self._places - self._cursors.frequency).argmin())

    def _follow(self, frequency: float) -> None:
        """Let the tracked mode nearest to the frequency cursor stand out."""
        here = self._reading.frequency_hz[self._row]
        if not len(self._places):
            return
        self.table.mark(self._nearest)
        near = self._numbers[self._nearest]
        if near not in (-1, self._selected) and here[self._selected] != frequency:
            self._stand_out(near)

    def _go(self, line: int) -> None:
        self._cursors.frequency = float(self._places[line])

    def _best_known(self) -> int:
        """Return the mode found at most temperatures; of several, the one nearest to the frequency cursor."""
        found = np.isfinite(self._reading.frequency_hz[self._rows]).sum(axis=0)
        away = np.abs(self._reading.frequency_hz[self._row] - self._cursors.frequency)
        return int(np.lexsort((away, -found))[0])

    @property
    def _row(self) -> int:
        known = self._tracked.temperature[self._rows]
        return int(self._rows[np.abs(known - self._cursors.temperature).argmin()])

    def _named(self, j: int) -> str:
        f = self._reading.frequency_hz[self._rows, j]
        return (
            f"mode {j + 1}: {np.nanmin(f):.0f} to {np.nanmax(f):.0f} Hz"
            if np.isfinite(f).any()
            else f"mode {j + 1}"
        )

    def _lay_out(self) -> None:
        top = QHBoxLayout()
        top.addWidget(self._choice)
        top.addWidget(self._readout)
        top.addStretch()
        left, right, grid = QVBoxLayout(), QVBoxLayout(), QGridLayout(self)
        left.addWidget(self._charts[0], stretch=5)
        left.addWidget(self.table, stretch=4)
        for chart in self._charts[1:]:
            right.addWidget(chart, stretch=1)
        if self.shape is not None:
            right.addWidget(self.shape, stretch=1)
        grid.addLayout(top, 0, 0, 1, 2)
        grid.addLayout(left, 1, 0)
        grid.addLayout(right, 1, 1)
        for column, share in enumerate((7, 5)):
            grid.setColumnStretch(column, share)
        cursors, known = self._cursors, self._tracked.temperature[self._rows]

        def to_temperature(value: float) -> None:
            cursors.temperature = float(known[np.abs(known - value).argmin()])

        def to_frequency(value: float) -> None:
            cursors.frequency = value

        for chart in self._charts:
            chart.follow("x", cursors.temperature, cursors.temperature_moved, to_temperature)
        self._charts[0].follow("y", cursors.frequency, cursors.frequency_moved, to_frequency)

    def _draw(self) -> None:
        rows, reading = self._rows, self._reading
        temperature = self._tracked.temperature[rows]
        count = self._tracked.track.shape[1]
        for j in range(count):
            color, name = self._theme.series(j), f"mode {j + 1}"
            f, sigma_f = reading.frequency_hz[rows, j], reading.sigma_frequency_hz[rows, j]
            eta, sigma_eta = 100 * reading.loss_factor[rows, j], 100 * reading.sigma_loss_factor[rows, j]
            known = 2 * sigma_eta < LARGEST_LOSS_BAND * eta
            eta = np.where(known, eta, np.nan)
            self._charts[0].band(temperature, f - 2 * sigma_f, f + 2 * sigma_f, color, name)
            self._charts[2].band(temperature, eta - 2 * sigma_eta, eta + 2 * sigma_eta, color, name)
            items = [
                (self._charts[0].curve(temperature, f, name, color, width=THIN, points=True), color),
                (self._charts[1].curve(temperature, f, name, color, width=THIN), color),
                (self._charts[2].curve(temperature, eta, name, color, width=THIN, points=True), color),
            ]
            self._lines.append(items)  # type: ignore[arg-type]
        self._change()
        for chart in self._charts:
            chart.fit()
        known = [y for _, _, y in self._charts[2].curves]
        self._charts[2].setYRange(0.0, 1.15 * float(np.nanpercentile(np.concatenate(known), 98.0)), padding=0.0)

    def _change(self) -> None:
        f = self._reading.frequency_hz
        change = in_lines(100 * (f[self._rows] / f[self._row] - 1))
        for j, items in enumerate(self._lines):
            items[1][0].setData(self._tracked.temperature[self._rows], change[:, j])  # type: ignore[attr-defined]
        self._charts[1].fit()

    def _tell(self) -> None:
        r, row, j = self._reading, self._row, self._selected
        status = self._tracked.status[row][j]
        place = f"at {self._tracked.temperature[row]:.2f} °C"
        if self.shape is not None:
            self.shape.show_nearest(float(self._tracked.temperature[row]), float(self._storage[row, j]))
        if not np.isfinite(r.frequency_hz[row, j]):
            self._readout.setText(f"{place}: {status}")
            return
        f = with_sigma(float(r.frequency_hz[row, j]), float(r.sigma_frequency_hz[row, j]), "Hz")
        eta = with_sigma(100 * float(r.loss_factor[row, j]), 100 * float(r.sigma_loss_factor[row, j]), "%")
        self._readout.setText(f"{place}: {f}, η {eta}, {status}")
