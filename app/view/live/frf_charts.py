"""The last FRF over those before it, and its coherence."""

from typing import Any

import numpy as np

from app.view.chart import Chart
from app.view.theme import Theme
from app.watch.watched import FRFS_SHOWN, Watched


class FrfChart(Chart):
    """FRFs of one sensor, the last one strong, earlier ones in the colour of their temperature.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("live-frf", "FRFs as they come", "frequency [Hz]", "|H| [dB]", theme)
        self._before = [self.curve([], [], "", theme.muted, named=False) for _ in range(FRFS_SHOWN - 1)]
        self._last = self.curve([], [], "last", theme.measured, width=2.0)

    def show_campaign(self, watched: Watched, channel: int) -> None:
        """Draw them."""
        steps = sorted(watched.sweeps)
        if not steps:
            return
        span = watched.experiment.protocol.temperatures
        low, high = min(span), max(span)
        for item, step in zip(self._before, [*steps[:-1], *[None] * FRFS_SHOWN], strict=False):
            item.setVisible(step is not None)
            if step is not None:
                sweep = watched.sweeps[step]
                share = float(np.clip((sweep.temperature - low) / max(high - low, 1e-9), 0.0, 1.0))
                item.setPen((*self.theme.temperature(share), 150), width=1.0)
                item.setData(sweep.frequency, _level(sweep.h[channel]))
                item.opts["label"] = f"{sweep.temperature:.2f} °C {sweep.direction}"
        last = watched.sweeps[steps[-1]]
        self._last.setData(last.frequency, _level(last.h[channel]))
        self._last.opts["label"] = f"{last.temperature:.2f} °C {last.direction}"
        self.setTitle(f"{watched.experiment.labels()[channel]}: {last.temperature:.2f} °C over those before")


class CoherenceChart(Chart):
    """Coherence of the last sweep over that of the one before.

    Parameters
    ----------
    theme : Theme
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__("live-coherence", "", "frequency [Hz]", "coherence", theme)
        self._before = self.curve([], [], "before", theme.muted)
        self._last = self.curve([], [], "last", theme.measured, width=1.6)
        self.least = (0.0, 1.0)
        self.setYRange(0.0, 1.02, padding=0.0)

    def show_campaign(self, watched: Watched, channel: int) -> None:
        """Draw them."""
        items: list[Any] = [self._last, self._before]
        for item, step in zip(items, sorted(watched.sweeps, reverse=True), strict=False):
            item.setData(watched.sweeps[step].frequency, watched.sweeps[step].coherence[channel])


def _level(h: np.ndarray) -> np.ndarray:
    return np.asarray(20.0 * np.log10(np.abs(h) + 1e-12))
