"""E, nu and eta over temperature, and what the twin misses."""

import numpy as np
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from analysis.material import MaterialLaws
from analysis.updated import Updated
from app.files.results.best_twin import BestTwin
from app.summaries.numbers import with_sigma
from app.summaries.update import CONSTANTS
from app.view.chart import Chart
from app.view.cursors import TEMPERATURE, Cursors
from app.view.theme import Theme

LAWS = (
    ("youngs_modulus", 1e9, "E [GPa]", "Young's modulus"),
    ("loss_factor", 0.01, "η [%]", "loss factor"),
    ("poisson_ratio", 1.0, "ν", "Poisson's ratio"),
)


SHEET = tuple((one.name, one.scale, one.label, one.title) for one in CONSTANTS)
"""Those of an orthotropic sheet: constants by direction, as estimated."""


class LawsPage(QWidget):
    """Estimates with error bars, laws with two-sigma bands; those of the corrected twin where there is one.

    Parameters
    ----------
    best : BestTwin
    cursors : Cursors
    theme : Theme
    """

    def __init__(
        self,
        best: BestTwin,
        cursors: Cursors,
        theme: Theme,
    ) -> None:
        super().__init__()
        self._cursors, self._theme, self._laws = cursors, theme, best.twin.laws
        sheet = best.twin.updated.sheet is not None
        self._shown, columns = (SHEET, 4) if sheet else (LAWS, 2)
        plain = best.uncorrected or best.twin
        self._parts = [("updated twin", plain.updated, plain.laws, theme.twin)]
        if best.uncorrected is not None:
            self._parts.append(("corrected twin", best.twin.updated, best.twin.laws, theme.corrected))
        if sheet:
            self._laws = None
            self._parts = [(of, estimates, None, color) for of, estimates, _, color in self._parts]
        grid = QGridLayout(self)
        self._charts = []
        for place, (name, unit, label, title) in enumerate(self._shown):
            chart = Chart(f"law-{name.replace('_', '-')}", title, TEMPERATURE, label, theme)
            chart.legend(offset=(8, 8) if name == "poisson_ratio" else (-8, 8))
            for of, estimates, law, color in self._parts:
                self._draw(chart, name, unit, of, estimates, law, color)
            chart.fit()
            grid.addWidget(chart, *divmod(place, columns))
            self._charts.append(chart)
        grid.addWidget(self._misfit(), 1, columns - 1)
        if best.said:
            said = QLabel(f"The values in the titles: {best.said}")
            said.setObjectName("origin")
            said.setWordWrap(True)
            grid.addWidget(said, 2, 0, 1, columns)
        for chart in (*self._charts, self._last):
            chart.follow("x", cursors.temperature, cursors.temperature_moved, self._to)
        cursors.temperature_moved.connect(self._tell)
        self._tell()

    def _to(self, value: float) -> None:
        self._cursors.temperature = value

    def _draw(
        self,
        chart: Chart,
        name: str,
        unit: float,
        of: str,
        found: Updated,
        law: MaterialLaws | None,
        color: str,
    ) -> None:
        of_value, of_sigma = (
            (found.material, found.sigma) if found.sheet is None else (found.sheet.value, found.sheet.sigma)
        )
        value, sigma = getattr(of_value, name) / unit, getattr(of_sigma, name) / unit
        good = found.settled
        chart.error_bars(found.temperature[good], value[good], 2 * sigma[good], color)
        marks = chart.curve(
            found.temperature[good], value[good], f"{of}, estimates", color, points=True, named=False
        )
        marks.setPen(None)
        if not good.all():
            bad = chart.curve(
                found.temperature[~good], value[~good], "not settled", self._theme.warning, points=True
            )
            bad.setPen(None)
            bad.setSymbol("x")
        if law is not None:
            fine = np.linspace(*law.temperature_range, 241)
            curve, band = getattr(law.at(fine), name) / unit, getattr(law.sigma(fine), name) / unit
            chart.band(fine, curve - 2 * band, curve + 2 * band, color, of)
            chart.curve(fine, curve, of, color, width=1.8)

    def _misfit(self) -> Chart:
        self._last = Chart(
            "misfit", "what the twin misses", TEMPERATURE, "rms|H - twin| / rms|H| [%]", self._theme
        )
        self._last.legend(offset=(8, 8))
        for of, found, _, color in self._parts:
            order = np.argsort(found.temperature, kind="stable")
            misfit = self._last.curve(found.temperature[order], 100 * found.misfit[order], of, color, points=True)
            misfit.setPen(None)
        found = self._parts[0][1]
        order = np.argsort(found.temperature, kind="stable")
        floor = 100 * found.noise_floor[order]
        self._last.curve(found.temperature[order], floor, "noise of the measurement", self._theme.measured)
        self._last.fit()
        self._last.setYRange(0.0, 1.25 * float(100 * found.misfit.max()), padding=0.0)
        return self._last

    def _tell(self) -> None:
        """Put the law's value at the cursor into each title."""
        for chart, (name, unit, label, title) in zip(self._charts, self._shown, strict=True):
            if self._laws is None:
                continue
            low, high = self._laws.temperature_range
            here = np.array([min(max(self._cursors.temperature, low), high)])
            value = float(getattr(self._laws.at(here), name)[0]) / unit
            sigma = float(getattr(self._laws.sigma(here), name)[0]) / unit
            symbol, _, rest = label.partition(" [")
            found = with_sigma(value, sigma, rest.rstrip("]") or "1")
            chart.setTitle(f"{title}: {symbol} = {found} at {here[0]:.1f} °C")
