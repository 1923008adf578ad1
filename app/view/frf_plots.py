"""Which parts of an FRF are drawn above each other.

The Nyquist plane of an FRF around the frequency cursor.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PySide6.QtWidgets import QComboBox

from analysis.arrays import Complex, Real
from analysis.drawn_curves import drawn_phase
from analysis.identification.modes import Modes
from app.view.chart import Chart
from app.view.theme import Color, Theme

PHASE_TICKS = [[(v, f"{v}") for v in some] for some in ((-180, 0, 180), (-90, 90))]
"""Degrees: those that are always labelled, and those that are if there is room."""


def decibels(h: Complex) -> Real:
    """20 log10 |h|, with a floor far below any measurement."""
    return np.asarray(20.0 * np.log10(np.abs(h) + 1e-20))


class PartsChoice(QComboBox):
    """Choice between magnitude and phase, and real and imaginary part."""

    def __init__(self) -> None:
        super().__init__()
        self.addItems(["magnitude and phase", "real and imaginary part"])

    @property
    def cartesian(self) -> bool:
        """Whether real and imaginary part are drawn."""
        return self.currentIndex() == 1

    def first(self, h: Complex) -> Real:
        """Return what the upper plot shows of FRFs of any shape: level, dB, or real part."""
        return np.asarray(h.real) if self.cartesian else decibels(h)

    def draw(self, curves: Sequence[Any], frequency: Real, h: Complex, deviation: ArrayLike = 0.0) -> None:
        """Give the curves of both plots their points.

        Parameters
        ----------
        curves : (upper, lower) of pyqtgraph.PlotDataItem
        frequency : (F,) ndarray
            Hz.
        h : (F,) complex ndarray
        deviation : (F,) array_like or float
            Standard deviation of h: where it is as large as h, there is no phase to be drawn.
        """
        curves[0].setData(frequency, self.first(h))
        curves[1].setData(*((frequency, h.imag) if self.cartesian else drawn_phase(frequency, h, deviation)))

    def label(self, above: Chart, below: Chart, unit: str) -> None:
        """Name the axes of both plots, and set the ticks and the range of a phase.

        Parameters
        ----------
        unit : str
            Of the FRF.
        """
        names = (f"Re H [{unit}]", f"Im H [{unit}]") if self.cartesian else (f"|H| [dB re 1 {unit}]", "phase [°]")
        for chart, name in zip((above, below), names, strict=True):
            chart.set_label("left", name)
        below.getAxis("left").setTicks(None if self.cartesian else PHASE_TICKS)
        if not self.cartesian:
            below.setYRange(-180.0, 180.0, padding=0.1)


WIDTHS_AROUND_CURSOR = 6.0
"""Half-power widths of the nearest mode that are shown to either side of the cursor, unless a mode is nearer."""
LEAST_LINES_AROUND = 5
"""Frequency lines that are shown to either side at least."""
POINTS_OF_CIRCLE = 400
"""Points of a model's circle."""
LEFT_AXIS_WIDTH = 62
"""Dots that the left axis takes, so that plots above each other share their frequencies."""


class NyquistChart(Chart):
    """Circle of the measured FRF, with those of models of it, and where the cursor stands on it.

    Parameters
    ----------
    name : str
        Of its files when it is exported.
    models : mapping of str to Color
        Names and colours of the models.
    theme : Theme
    """

    def __init__(self, name: str, models: Mapping[str, Color], theme: Theme) -> None:
        super().__init__(name, "Nyquist plane around the cursor", "real part", "imaginary part", theme)
        self._measured = self.curve([], [], "measured", theme.measured, style="dot", points=True)
        self._models = {model: self.curve([], [], model, color, width=1.4) for model, color in models.items()}
        self._cursor = self.curve([], [], "cursor", theme.warning, points=True)
        self._measured.setSymbolSize(4)
        self._cursor.setSymbolSize(9)
        self.getAxis("left").setWidth(LEFT_AXIS_WIDTH)
        self.setAspectLocked(True)

    def show_circle(self, h: Complex, here: complex, models: Mapping[str, Complex], unit: str) -> None:
        """Draw another circle.

        Parameters
        ----------
        h : (n,) complex ndarray
            Measured, around the cursor.
        here : complex
            At the cursor.
        models : mapping of str to (m,) complex ndarray
            Those that are shown.
        """
        self.set_label("bottom", f"real part [{unit}]")
        self.set_label("left", f"imaginary part [{unit}]")
        self._measured.setData(h.real, h.imag)
        for name, curve in self._models.items():
            curve.setVisible(name in models)
            if name in models:
                curve.setData(models[name].real, models[name].imag)
        self._cursor.setData([here.real], [here.imag])
        self.fit()


def around(frequency: Real, here: int, modes: Modes | None) -> NDArray[np.bool_]:
    """Return which frequency lines (F,) belong to the circle around one of them.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.
    here : int
        Line of the cursor.
    modes : Modes or None
        Identified from the FRF; without any, 6 % to either side are shown.

    Returns
    -------
    (F,) bool ndarray
    """
    reach = 0.01 * WIDTHS_AROUND_CURSOR * frequency[here]
    if modes is not None and modes.real.any():
        poles = modes.poles[modes.real]
        place = poles.imag / (2.0 * np.pi)
        nearest = int(np.abs(place - frequency[here]).argmin())
        width = -poles[nearest].real / np.pi
        apart = np.abs(np.delete(place, nearest) - place[nearest])
        reach = max(width, min(WIDTHS_AROUND_CURSOR * width, *apart))
    near: NDArray[np.bool_] = np.abs(frequency - frequency[here]) <= reach
    near[max(here - LEAST_LINES_AROUND, 0) : here + LEAST_LINES_AROUND + 1] = True
    return near
