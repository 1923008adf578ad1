"""E, nu and eta over temperature, and what the twin misses."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from analysis.arrays import Real
from analysis.estimates import FittedLaws, SheetConstants
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.updated import Updated
from app.files.results.best_twin import BEFORE, BY_UPDATE, BestTwin
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


@dataclass(frozen=True)
class Estimates:
    """What is drawn with error bars.

    Attributes
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    value, sigma : Material, MaterialSigma or SheetConstants
        (T,) arrays.
    settled : (T,) bool ndarray
    """

    temperature: Real
    value: Material | SheetConstants
    sigma: MaterialSigma | SheetConstants
    settled: NDArray[np.bool_]

    @classmethod
    def of(cls, found: Updated | FittedLaws) -> "Estimates":
        """Those per sweep, or of the nodes of laws; the constants of a sheet where it is one."""
        t = found.temperature
        settled = np.ones(len(t), bool) if isinstance(found, FittedLaws) else found.settled
        if found.sheet is not None:
            return cls(t, found.sheet.value, found.sheet.sigma, settled)
        if isinstance(found, Updated):
            return cls(t, found.material, found.sigma, settled)
        from analysis.updating.corrected_twin import material_of

        return cls(t, *material_of(found), settled)


@dataclass(frozen=True)
class DrawnLaws:
    """Laws of one twin, and the estimates behind them.

    Attributes
    ----------
    of : str
        Which twin, for the legend.
    estimates : Estimates
    law : MaterialLaws or None
    color : str
    banded : bool
        Whether the law has a band of its own; else it is drawn through the ends of the error bars.
    """

    of: str
    estimates: Estimates
    law: MaterialLaws | None
    color: str
    banded: bool = True


def _before(best: BestTwin, theme: Theme) -> DrawnLaws:
    """Return the laws that the best ones are set against; those of the best twin where it is the plain one."""
    if best.uncorrected is None:
        return DrawnLaws("updated twin", Estimates.of(best.twin.updated), best.twin.laws, theme.twin)
    if best.nodes is None:
        return DrawnLaws(BY_UPDATE, Estimates.of(best.uncorrected.updated), best.before, theme.twin)
    return DrawnLaws(BEFORE, Estimates.of(best.nodes[0]), best.before, theme.twin, banded=False)


class LawsPage(QWidget):
    """Estimates with error bars, laws with two-sigma bands; those of the corrected twin where there is one.

    Beside these the laws before, as in the report. The misfit of single sweeps before is known of update alone.

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
        parts = [_before(best, theme)]
        self._misses = [("updated twin", best.twin.updated, theme.twin)]
        if best.uncorrected is not None:
            corrected = best.twin.updated
            parts.append(DrawnLaws("corrected twin", Estimates.of(corrected), best.twin.laws, theme.corrected))
            self._misses = [
                (BY_UPDATE, best.uncorrected.updated, theme.twin),
                ("corrected twin", corrected, theme.corrected),
            ]
        if sheet:
            self._laws = None
            parts = [replace(part, law=None) for part in parts]
        grid = QGridLayout(self)
        self._charts = []
        for place, (name, unit, label, title) in enumerate(self._shown):
            chart = Chart(f"law-{name.replace('_', '-')}", title, TEMPERATURE, label, theme)
            chart.legend(offset=(8, 8) if name == "poisson_ratio" else (-8, 8))
            for part in parts:
                self._draw(chart, name, unit, part)
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

    def _draw(self, chart: Chart, name: str, unit: float, part: DrawnLaws) -> None:
        of, found, law, color = part.of, part.estimates, part.law, part.color
        value, sigma = getattr(found.value, name) / unit, getattr(found.sigma, name) / unit
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
            if part.banded:
                chart.band(fine, curve - 2 * band, curve + 2 * band, color, of)
            else:
                chart.band(found.temperature, value - 2 * sigma, value + 2 * sigma, color, of)
            chart.curve(fine, curve, of, color, width=1.8)

    def _misfit(self) -> Chart:
        self._last = Chart(
            "misfit", "what the twin misses", TEMPERATURE, "rms|H - twin| / rms|H| [%]", self._theme
        )
        self._last.legend(offset=(8, 8))
        for of, found, color in self._misses:
            order = np.argsort(found.temperature, kind="stable")
            misfit = self._last.curve(found.temperature[order], 100 * found.misfit[order], of, color, points=True)
            misfit.setPen(None)
        found = self._misses[0][1]
        order = np.argsort(found.temperature, kind="stable")
        floor = 100 * found.noise_floor[order]
        self._last.curve(found.temperature[order], floor, "noise of the measurement", self._theme.measured)
        self._last.least = (0.0, 0.0)  # a misfit is read from 0
        self._last.fit()
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
