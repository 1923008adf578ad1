"""Mode shapes and the focused field, moving."""

from dataclasses import replace

import numpy as np
from PySide6.QtWidgets import QComboBox, QGridLayout, QHBoxLayout, QLabel, QPushButton, QWidget

from analysis.arrays import Real
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.geometry.loop import circle
from analysis.material import MaterialLaws
from app.view.chart import Chart, Map
from app.view.cursors import Cursors
from app.view.map_chart import MapChart
from app.view.recorded.fields import Fields
from app.view.recorded.mode_shape import Maker
from app.view.surface import TURN, FromAbove, Movement, SurfaceChart, edges_of
from app.view.theme import Theme, one_sided

QUIET_DB = -40.0
"""Least amplitude distinguished on the map, dB re the largest."""


class FieldsPage(QWidget):
    """A mode shape and the focused field as surfaces that move, and the field's amplitude from above.

    Parameters
    ----------
    panel : Panel
    focusing : Focusing
    laws : MaterialLaws
    cursors : Cursors
    theme : Theme
    """

    def __init__(
        self, panel: Panel, focusing: Focusing, laws: MaterialLaws, cursors: Cursors, theme: Theme
    ) -> None:
        super().__init__()
        self._panel, self._cursors, self._theme = panel, cursors, theme
        self.fields: Fields | None = None
        self._grid = QGridLayout(self)
        self._status = QLabel("the panel's twin is fetched …")
        self._status.setObjectName("fields")
        self._grid.addWidget(self._status, 0, 0, 1, 2)
        self._play = QPushButton("Still")
        self._movement = Movement(self, self.advance, self._play)
        self._maker = Maker(lambda report: Fields.of(panel, focusing, laws, report), self._status, self)
        self._maker.hand_to(self.show_fields)

    def show_fields(self, fields: Fields) -> None:
        """Build the plots, once the twin is there."""
        self.fields = fields
        theme, outlines, edges = self._theme, self._outlines(), edges_of(self._panel.plate)
        self._mode_choice, self._filters = QComboBox(), QComboBox()
        self._filters.addItems(
            ["of each temperature", f"of {fields.focusing.reference_temperature:g} °C everywhere"]
        )
        self.shape = SurfaceChart("mode-shape", "mode", fields.plate.x, fields.plate.y, outlines, theme, edges)
        self.field = SurfaceChart("focused-field", "field", fields.plate.x, fields.plate.y, outlines, theme, edges)
        self._from_above = FromAbove(fields.plate.x, fields.plate.y, self._panel.plate)
        self.amplitude = MapChart("field-amplitude", "its amplitude", "x [m]", "y [m]", theme)
        quiet = Map(fields.plate.x, fields.plate.y, np.full((len(fields.plate.y), len(fields.plate.x)), QUIET_DB))
        self.amplitude.image(quiet, one_sided(), (QUIET_DB, 0.0), "dB re largest")
        self.amplitude.setAspectLocked(lock=True)
        for corners, color in (*outlines, *((edge, theme.text) for edge in edges)):
            closed = np.vstack([corners, corners[:1]])
            self.amplitude.curve(closed[:, 0], closed[:, 1], "outline", color, width=2.0)
        self._tip = Chart("amplitude-along-x", "across the target, along x", "x [m]", "share of largest", theme)
        self._section = self._tip.curve([], [], "amplitude", theme.measured, width=1.8)
        top = QHBoxLayout()
        for widget in (QLabel("mode"), self._mode_choice, QLabel("filters"), self._filters, self._play):
            top.addWidget(widget)
        top.addStretch()
        self._status.hide()
        self._grid.addLayout(top, 0, 0, 1, 2)
        for chart, row, column in (
            (self.shape, 1, 0),
            (self.field, 1, 1),
            (self.amplitude, 2, 1),
            (self._tip, 2, 0),
        ):
            self._grid.addWidget(chart, row, column)
        self._grid.setRowStretch(1, 3)
        self._grid.setRowStretch(2, 2)
        self._mode_choice.currentIndexChanged.connect(self._show_shape)
        self._filters.currentIndexChanged.connect(self._show_field)
        self._cursors.temperature_moved.connect(self._refresh)
        self._cursors.frequency_moved.connect(self._show_field)
        self._refresh()
        self._movement.go(moving=True)

    @property
    def ready(self) -> bool:
        """Whether the twin is there."""
        return self.fields is not None

    def advance(self) -> None:
        """Show the next picture."""
        if self.isVisible():
            self.shape.turn(TURN)
            self.field.turn(TURN)

    def play_or_stop(self) -> None:
        """Let the fields move, or stand still."""
        if self.fields is not None:
            self._movement.toggle()

    def step(self, modes: int) -> None:
        """Show a mode further up or down."""
        if self.fields is not None:
            place = self._mode_choice.currentIndex() + modes
            self._mode_choice.setCurrentIndex(int(np.clip(place, 0, self._mode_choice.count() - 1)))

    def _outlines(self) -> list[tuple[Real, str]]:
        patches = [(patch.loop.polygon, self._theme.muted) for patch in self._panel.patch]
        patches += [(circle(d.point, max(d.radius, 0.002)).polygon, self._theme.muted) for d in self._panel.drive]
        targets = [(loop.polygon, self._theme.warning) for loop in self._panel.target_loops]
        return [*targets, *patches]

    def _refresh(self) -> None:
        """Fetch everything at another temperature."""
        if self.fields is None:
            return
        self._modes = self.fields.modes(self._cursors.temperature)
        names = [f"{n + 1}: {f:.0f} Hz" for n, f in enumerate(self._modes[0])]
        chosen = max(self._mode_choice.currentIndex(), 0)
        self._mode_choice.blockSignals(True)
        self._mode_choice.clear()
        self._mode_choice.addItems(names)
        self._mode_choice.setCurrentIndex(min(chosen, len(names) - 1))
        self._mode_choice.blockSignals(False)
        self._show_shape()
        self._show_field()

    def _show_shape(self) -> None:
        f, eta, shapes = self._modes
        low, high = self._panel.filters.twin_band
        chosen, at = self._mode_choice.currentIndex(), f"at {self._cursors.temperature:.1f} °C"
        if chosen < 0:
            self.shape.show_field(np.zeros(self.shape.deflection.shape, complex))
            self.shape.setTitle(f"no mode of the panel from {low:.0f} to {high:.0f} Hz {at}")
            return
        self.shape.show_field(shapes[chosen].astype(complex))
        self.shape.setTitle(
            f"mode {chosen + 1} of the panel above {low:.0f} Hz {at}: {f[chosen]:.1f} Hz, "
            f"η {100 * eta[chosen]:.2f} %"
        )

    def _show_field(self) -> None:
        if self.fields is None:
            return
        fixed = self._filters.currentIndex() == 1
        temperature, frequency, field = self.fields.focused(
            self._cursors.temperature, self._cursors.frequency, fixed=fixed
        )
        self.field.show_field(field)
        self.field.setTitle(
            f"field of the filters {self._filters.currentText()}, {temperature:g} °C, {frequency:.1f} Hz"
        )
        share = np.abs(field) / np.nanmax(np.abs(field))
        above = self._from_above.amplitude(field)
        level = 20.0 * np.log10(above.value / np.nanmax(np.abs(field)) + 1e-12)
        self.amplitude.show_map(replace(above, value=np.clip(level, QUIET_DB, 0.0)))
        row = int(np.abs(self.fields.plate.y - self._panel.target_center[1]).argmin())
        self._section.setData(self.fields.plate.x, share[:, row])
        self._tip.fit()
