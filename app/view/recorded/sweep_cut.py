"""One sweep over frequency: two parts of its FRF above each other, and its coherence."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from analysis.frf import Frf
from app.view.chart import Chart
from app.view.cursors import FREQUENCY
from app.view.parts import PartsChoice, decibels
from app.view.recorded.overlays import Answer, Identified
from app.view.theme import Theme

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
