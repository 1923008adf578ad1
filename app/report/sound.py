"""Contrast of the field along a piece of sound, and readings of the panel that is its own thermometer."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from app.report.style import BAND, MEASURED, MODEL, legend_below, panels
from app.sound.stretch import RecordingStretch
from app.sound.trace import TraceMoment


def along_the_way(moments: Sequence[TraceMoment]) -> Figure:
    """Temperature and contrast over time, with filters that follow and with those of the beginning."""
    figure, (above, below) = panels(2, 1, height=5.0, sharex=True, height_ratios=(1, 2))
    time = [m.time for m in moments]
    above.plot(time, [m.temperature for m in moments], color=MEASURED, label="panel")
    # Straight from moment to moment: filters change more often, and a step held that long would look like a lag.
    above.plot(time, [m.filters for m in moments], color=BAND, lw=0.9, label="filters in use")
    above.set(ylabel="temperature [°C]", title="sound through filters that follow the temperature")
    for color, name, ways in (
        (BAND, "filters follow", [m.following for m in moments]),
        (MODEL, "those of the beginning kept", [m.kept for m in moments]),
    ):
        below.plot(time, [c.mean for c in ways], color=color, label=f"{name}: mean of the band")
        below.plot(time, [c.worst for c in ways], ":", color=color, lw=1.0, label="worst line")
        below.plot(time, [c.sound for c in ways], color=color, lw=0.7, alpha=0.6, label="weighted with the sound")
    below.set(xlabel="time [s]", ylabel="contrast, eq. (9)", ylim=(0, 1))
    legend_below(figure, above, below, columns=4)
    return figure


def readings(stretches: Sequence[RecordingStretch], true: NDArray[np.float64] | None) -> Figure:
    """Draw readings with their 90 % intervals, the track with its own, and the truth where it is known."""
    figure, axes = panels(1, 1, height=3.4)
    accepted = [stretch for stretch in stretches if not stretch.reading.refused]
    axes.errorbar(
        [stretch.time for stretch in accepted],
        [stretch.reading.temperature for stretch in accepted],
        [1.645 * stretch.reading.sigma for stretch in accepted],
        fmt="o",
        ms=2.5,
        lw=0.8,
        color=MEASURED,
        label="single readings, 90 %",
    )
    tracked = [stretch for stretch in stretches if np.isfinite(stretch.sigma)]
    time, middle = [stretch.time for stretch in tracked], np.array([stretch.temperature for stretch in tracked])
    half = 1.645 * np.array([stretch.sigma for stretch in tracked])
    axes.plot(time, middle, color=BAND, label="track, 90 %")
    axes.fill_between(time, middle - half, middle + half, color=BAND, alpha=0.25, lw=0)
    if true is not None:
        axes.plot(
            [stretch.time for stretch in stretches], true, "--", color=MODEL, lw=1.0, label="simulated panel"
        )
    axes.set(xlabel="time [s]", ylabel="temperature [°C]", title="the panel as its own thermometer")
    legend_below(figure)
    return figure
