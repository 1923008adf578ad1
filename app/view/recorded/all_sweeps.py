"""Every sweep of a run in one plot, coloured by its temperature."""

from PySide6.QtWidgets import QCheckBox

from analysis.arrays import Real
from app.view.chart import Chart


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
