"""How well the filters focus, over frequency and temperature."""

import numpy as np
from PySide6.QtWidgets import QComboBox, QGridLayout, QHBoxLayout, QLabel, QWidget

from analysis.arrays import Real
from analysis.compensation.outcome import Compensation
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.pareto import ParetoCurve
from analysis.focusing.performance import Aim
from app.view.chart import Chart, Map
from app.view.cursors import FREQUENCY, TEMPERATURE, Cursors
from app.view.map_chart import MapChart
from app.view.theme import Theme, one_sided

CONTRAST, SPOT = "contrast", "spot error [% of Lx]"
TOP_OF_CONTRAST_AXIS = 1.3
"""Upper end of the axis of contrast: the names of the curves stand above 1, where there is no curve."""
ROOM_FOR_NAMES = 0.8
"""Of the designs' span of contrast, above them."""


class FocusingPage(QWidget):
    """Maps of contrast and spot error, cut at the temperature cursor, and what is left over the band.

    Of filters whose aim is heard, also contrast against evenness of the sound.

    Parameters
    ----------
    focusing : Focusing
    compensation : Compensation or None
    cursors : Cursors
    theme : Theme
    pareto : ParetoCurve, optional
    """

    def __init__(
        self,
        focusing: Focusing,
        compensation: Compensation | None,
        cursors: Cursors,
        theme: Theme,
        pareto: ParetoCurve | None = None,
    ) -> None:
        super().__init__()
        self._cursors, self._theme = cursors, theme
        self._found = _aims(focusing, compensation)
        self._choice = QComboBox()
        self._choice.addItems(list(self._found))
        self._choice.setCurrentIndex(1)
        self._maps = (
            MapChart("contrast-map", "contrast", FREQUENCY, TEMPERATURE, theme),
            MapChart("spot-error-map", "spot error", FREQUENCY, TEMPERATURE, theme),
        )
        self._cuts = (
            Chart("contrast-at-temperature", "", FREQUENCY, CONTRAST, theme),
            Chart("spot-error-at-temperature", "", FREQUENCY, SPOT, theme),
        )
        self._mean = Chart(
            "contrast-over-temperature", "what temperature costs", TEMPERATURE, "mean contrast", theme
        )
        self._tradeoff = None if pareto is None else _tradeoff(pareto, theme)
        self._lay_out()
        self._draw()
        self._choice.currentIndexChanged.connect(self._choose)
        cursors.temperature_moved.connect(self._cut)
        self._choose()
        self._cut()

    def _lay_out(self) -> None:
        top = QHBoxLayout()
        top.addWidget(QLabel("filters"))
        top.addWidget(self._choice)
        top.addStretch()
        grid = QGridLayout(self)
        grid.addLayout(top, 0, 0, 1, 2)
        for column in (0, 1):
            grid.addWidget(self._maps[column], 1, column)
            grid.addWidget(self._cuts[column], 2, column)
        if self._tradeoff is None:
            grid.addWidget(self._mean, 3, 0, 1, 2)
        else:
            grid.addWidget(self._mean, 3, 0)
            grid.addWidget(self._tradeoff, 3, 1)
        for row, share in ((1, 5), (2, 4), (3, 3)):
            grid.setRowStretch(row, share)

    def _draw(self) -> None:
        (temperature, frequency, aim), *_ = self._found.values()
        worst = max(100 * float(a.spot_error.max()) for _, _, a in self._found.values())
        for chart, value, levels, label in (
            (self._maps[0], aim.contrast, (0.0, 1.0), CONTRAST),
            (self._maps[1], 100 * aim.spot_error, (0.0, worst), SPOT),
        ):
            chart.image(Map(frequency, temperature, value), one_sided(), levels, label)
        cursors = self._cursors

        def to_temperature(value: float) -> None:
            cursors.temperature = value

        def to_frequency(value: float) -> None:
            cursors.frequency = value

        for chart in (*self._maps, self._mean):
            direction = "x" if chart is self._mean else "y"
            chart.follow(direction, cursors.temperature, cursors.temperature_moved, to_temperature)  # type: ignore[arg-type]
        for chart, above in zip(self._cuts, self._maps, strict=True):
            above.stand_over(chart)
        for chart in (*self._maps, *self._cuts):
            chart.follow("x", cursors.frequency, cursors.frequency_moved, to_frequency)
            chart.getAxis("left").setWidth(58)
        self._cuts[0].legend(columns=3, offset=(8, 2))
        self._cuts[0].setYRange(0.0, TOP_OF_CONTRAST_AXIS, padding=0.0)
        self._cuts[1].setYRange(0.0, worst)
        self._curves = {}
        for number, (name, (at, _, reached)) in enumerate(self._found.items()):
            color = self._theme.series(number)
            self._curves[name] = tuple(chart.curve([], [], name, color) for chart in self._cuts)
            self._mean.curve(at, reached.contrast.mean(axis=1), name, color, points=len(at) < 40, width=1.6)
        self._mean.fit()
        self._mean.setYRange(0.0, 1.0)

    def _choose(self) -> None:
        temperature, frequency, aim = self._found[self._choice.currentText()]
        for chart, value, title in zip(
            self._maps, (aim.contrast, 100 * aim.spot_error), ("contrast", "spot error"), strict=True
        ):
            chart.show_map(Map(frequency, temperature, value))
            chart.setTitle(f"{title}, {self._choice.currentText()}")

    def _cut(self) -> None:
        """Draw every kind of filters at the temperature nearest to the cursor at which it was assessed."""
        shown = {}
        for name, (temperature, frequency, aim) in self._found.items():
            row = int(np.abs(temperature - self._cursors.temperature).argmin())
            self._curves[name][0].setData(frequency, aim.contrast[row])
            self._curves[name][1].setData(frequency, 100 * aim.spot_error[row])
            shown[name] = float(temperature[row])
        nearest = min(shown.values(), key=lambda at: abs(at - self._cursors.temperature))
        elsewhere = {name: f"{name}, at {at:g} °C" for name, at in shown.items() if at != nearest}
        for name, curves in self._curves.items():
            for curve in curves:
                curve.opts["label"] = elsewhere.get(name, name)
        for chart, what in zip(self._cuts, ("contrast", "spot error"), strict=True):
            chart.setTitle("; ".join([f"{what} at {nearest:g} °C", *elsewhere.values()]))


def _tradeoff(curve: ParetoCurve, theme: Theme) -> Chart:
    """Draw contrast against ripple of the sound: all designs, those not beaten, and the recommended one."""
    title = f"contrast against evenness, {curve.temperature:g} °C"
    chart = Chart("contrast-against-evenness", title, "third-octave ripple [± dB]", "mean contrast", theme)
    chart.legend(columns=3, offset=(8, 2))
    front, best = curve.unbeaten, slice(curve.recommended, curve.recommended + 1)
    designs, unbeaten, recommended = (theme.series(number) for number in range(3))
    chart.curve(curve.ripple, curve.contrast, "designs", designs, style="none", points=True)
    chart.curve(curve.ripple[front], curve.contrast[front], "not beaten by another", unbeaten, points=True)
    chart.curve(curve.ripple[best], curve.contrast[best], "recommended", recommended, style="none", points=True)
    chart.fit()
    low, high = np.min(curve.contrast), np.max(curve.contrast)
    chart.setYRange(low, high + ROOM_FOR_NAMES * (high - low))
    return chart


def _aims(focusing: Focusing, compensation: Compensation | None) -> dict[str, tuple[Real, Real, Aim]]:
    """Temperatures, lines and what is reached there, by kind of filters.

    Filters of each temperature are assessed by `flexura compensate`, too, often at more temperatures.
    """
    own, fixed = ((focusing.temperature, focusing.frequency, aim) for aim in (focusing.direct, focusing.fixed))
    more = {}
    if compensation is not None:
        at, lines = compensation.aim_temperature, compensation.frequency
        own = (at, lines, compensation.direct_aim) if len(at) > len(focusing.temperature) else own
        more["of the networks"] = (at, lines, compensation.network_aim)
    return {"of each temperature": own, f"of {focusing.reference_temperature:g} °C everywhere": fixed} | more
