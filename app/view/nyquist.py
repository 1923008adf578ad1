"""The Nyquist plane of an FRF around the frequency cursor."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.identification.modes import Modes
from app.view.chart import Chart
from app.view.theme import Color, Theme

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
