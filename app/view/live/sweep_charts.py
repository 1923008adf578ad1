"""The repeat recorded last: signals, spectrum and levels."""

import numpy as np
import pyqtgraph

from app.files.latest_repeat import LatestRepeat
from app.view.chart import Chart
from app.view.theme import Theme

LOWEST_LEVEL = -100.0
"""Lowest level shown, dB re full scale."""


class SignalChart(Chart):
    """Every channel over time, each to its own scale and on its own line, as on an oscilloscope.

    Parameters
    ----------
    channels : tuple of str
        The drive, then the sensors.
    theme : Theme
    """

    def __init__(self, channels: tuple[str, ...], theme: Theme) -> None:
        super().__init__("signals", "repeat recorded last", "time [s]", "", theme)
        self._lines = [
            self.curve([], [], f"{name} [share of its peak, from {-place}]", _color(place, theme))
            for place, name in enumerate(channels)
        ]
        self.setDownsampling(auto=True, mode="peak")
        self.setYRange(-len(channels) + 0.4, 0.6, padding=0.02)

    def show_repeat(self, latest: LatestRepeat) -> None:
        """Draw it."""
        time = np.arange(latest.signals.shape[1]) / latest.sample_rate
        ticks = []
        for place, (line, name, signal) in enumerate(
            zip(self._lines, latest.channels, latest.signals.astype(float), strict=True)
        ):
            peak = float(np.abs(signal).max())
            line.setData(time, 0.45 * signal / (peak or 1.0) - place)
            ticks.append((-float(place), f"{name}\n{peak:.3g} V"))
        self.getAxis("left").setTicks([ticks])
        self.setXRange(0.0, float(time[-1]), padding=0.01)
        self.setTitle(f"repeat {latest.repeat + 1} of {latest.place}")


class SpectrumChart(Chart):
    """Amplitude spectrum of every channel.

    Parameters
    ----------
    channels : tuple of str
    theme : Theme
    """

    def __init__(self, channels: tuple[str, ...], theme: Theme) -> None:
        super().__init__("spectrum", "its spectrum", "frequency [Hz]", "amplitude [dB re 1 V]", theme)
        self.legend(columns=2)
        self._lines = [self.curve([], [], name, _color(place, theme)) for place, name in enumerate(channels)]
        self.setDownsampling(auto=True, mode="peak")

    def show_repeat(self, latest: LatestRepeat) -> None:
        """Draw it, from 10 Hz to half the sample rate."""
        count = latest.signals.shape[1]
        frequency = np.fft.rfftfreq(count, 1.0 / latest.sample_rate)
        shown = frequency > 10.0
        amplitude = 2.0 / count * np.abs(np.fft.rfft(latest.signals.astype(float), axis=1))
        levels = 20.0 * np.log10(amplitude[:, shown] + 1e-12)
        for line, level in zip(self._lines, levels, strict=True):
            line.setData(frequency[shown], level)
        self.setXRange(0.0, float(frequency[-1]), padding=0.01)
        self.setYRange(float(np.percentile(levels, 1.0)), float(levels.max()) + 6.0, padding=0.02)


class LevelChart(Chart):
    """Level meters: rms and peak of every channel against full scale, and a mark on those that clipped.

    Parameters
    ----------
    channels : tuple of str
    theme : Theme
    """

    def __init__(self, channels: tuple[str, ...], theme: Theme) -> None:
        super().__init__("levels", "levels", "", "dB re full scale", theme)
        place = np.arange(len(channels))
        self._peak = pyqtgraph.BarGraphItem(
            x=place, height=0.0, width=0.7, y0=LOWEST_LEVEL, brush=theme.muted, pen=None
        )
        self._rms = pyqtgraph.BarGraphItem(
            x=place, height=0.0, width=0.7, y0=LOWEST_LEVEL, brush=theme.corrected, pen=None
        )
        self._peak.setOpacity(0.5)
        for item in (self._peak, self._rms):
            self.addItem(item)
        self.addItem(pyqtgraph.InfiniteLine(0.0, angle=0, pen=pyqtgraph.mkPen(theme.warning, width=2)))
        self._clipped = [
            pyqtgraph.TextItem("CLIP", color=theme.plot, fill=theme.warning, anchor=(0.5, 1)) for _ in place
        ]
        for at, mark in zip(place, self._clipped, strict=True):
            mark.setPos(float(at), -2.0)
            mark.hide()
            self.addItem(mark)
        self._numbers = self.curve([], [], "peak [dB re full scale]", theme.text, named=False)
        self._numbers.setPen(None)  # for the export
        self.getAxis("bottom").setTicks([list(zip(place.tolist(), channels, strict=True))])
        self.setYRange(LOWEST_LEVEL, 8.0, padding=0.0)
        self.setXRange(-0.6, len(channels) - 0.4, padding=0.0)

    @property
    def clipped(self) -> list[bool]:
        """Channels that are marked, the drive first."""
        return [mark.isVisible() for mark in self._clipped]

    def show_repeat(self, latest: LatestRepeat) -> None:
        """Draw it."""
        signals = latest.signals.astype(float)
        peak = _level(np.abs(signals).max(axis=1), latest.full_scale)
        self._peak.setOpts(height=peak - LOWEST_LEVEL)
        self._rms.setOpts(height=_level(np.sqrt((signals**2).mean(axis=1)), latest.full_scale) - LOWEST_LEVEL)
        self._numbers.setData(np.arange(len(peak)), peak)
        for mark, over in zip(self._clipped, latest.overloaded, strict=True):
            mark.setVisible(bool(over))


def _level(volts: np.ndarray, full_scale: float) -> np.ndarray:
    return np.asarray(np.maximum(20.0 * np.log10(volts / full_scale + 1e-12), LOWEST_LEVEL))


def _color(place: int, theme: Theme) -> str:
    return theme.muted if place == 0 else str(theme.series(place - 1))
