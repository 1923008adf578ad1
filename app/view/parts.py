"""Which parts of an FRF are drawn above each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from PySide6.QtWidgets import QComboBox

from analysis.arrays import Complex, Real
from analysis.drawn_curves import drawn_phase
from app.view.chart import Chart

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
