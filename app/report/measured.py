"""Measured FRFs over temperature (the paper's Fig. 7)."""

import numpy as np
from matplotlib.figure import Figure

from analysis.recordings.frf import Frf
from app.report.style import frequency_axis, legend_below, panels, temperature_color

CURVES_DRAWN = 5


def spread(temperature: np.ndarray, count: int) -> list[int]:
    """Rows whose temperatures are spread evenly from the coldest to the hottest, without repeats."""
    order = np.argsort(temperature, kind="stable")
    places = np.unique(np.round(np.linspace(0, len(order) - 1, min(count, len(order)))).astype(int))
    return [int(order[p]) for p in places]


def waterfall(frf: Frf, channel: int = 0) -> Figure:
    """Amplitude of one channel over frequency and temperature, and a few temperatures as lines.

    Of several inputs that drove, the sweeps of the first: `Frf.of_source` gives those of another.
    """
    frf = frf.of_source(frf.driving[0])
    figure, axes = panels(1, 2, height=4.6, width_ratios=[1.15, 1.0])
    order = np.argsort(frf.temperature, kind="stable")
    level = 20.0 * np.log10(np.abs(frf.h[order, channel]) + 1e-20)
    cells = (_edges(frf.frequency), _edges(frf.temperature[order]))
    image = axes[0].pcolormesh(*cells, level, cmap="magma", vmin=float(np.percentile(level, 1)), rasterized=True)
    figure.colorbar(image, ax=axes[0])
    name, unit = frf.label(channel).split(" ")[0], frf.unit(channel)
    axes[0].set(ylabel="temperature [°C]", title=f"|H| {name} [dB re 1 {unit}] over temperature")
    axes[0].grid(visible=False)
    frequency_axis(axes[0])
    span = (float(frf.temperature.min()), float(frf.temperature.max()))
    for row in spread(frf.temperature, CURVES_DRAWN):
        t = float(frf.temperature[row])
        curve = 20.0 * np.log10(np.abs(frf.h[row, channel]) + 1e-20)
        axes[1].plot(frf.frequency, curve, color=temperature_color(t, span), label=f"{t:.1f} °C")
    axes[1].set(ylabel=f"|H| [dB re 1 {unit}]", title="the same, a few temperatures")
    legend_below(figure, axes[1])
    frequency_axis(axes[1])
    return figure


def noise(frf: Frf, channel: int = 0) -> Figure:
    """H1, its standard deviation and the coherence of one sweep in the middle of the range."""
    figure, axes = panels(1, 2, height=3.4)
    row = spread(frf.temperature, 3)[len(spread(frf.temperature, 3)) // 2]
    axes[0].semilogy(frf.frequency, np.abs(frf.h[row, channel]), color="0.15", label="|H1|")
    axes[0].semilogy(
        frf.frequency, np.sqrt(frf.variance[row, channel]), color="#00798c", label="standard deviation of H1"
    )
    used = np.flatnonzero(frf.excluded)
    axes[0].plot(
        frf.frequency[used],
        np.abs(frf.h[row, channel, used]),
        ".",
        color="#d1495b",
        ms=4,
        label="mains lines, not fitted",
    )
    name = frf.label(channel, row).split(" ")[0] if frf.sources else frf.channels[channel]
    axes[0].set(ylabel=f"[{frf.unit(channel, row)}]", title=f"{name} at {frf.temperature[row]:.1f} °C")
    legend_below(figure)
    axes[1].plot(frf.frequency, frf.coherence[row, channel], color="0.15", lw=0.8)
    axes[1].set(
        ylabel="coherence of one repeat",
        title="coherence",
        ylim=(min(0.99, frf.coherence[row, channel].min()), 1.0005),
    )
    for each in axes:
        frequency_axis(each)
    return figure


def _edges(centers: np.ndarray) -> np.ndarray:
    """Cell edges of rows at `centers`, ascending."""
    if len(centers) == 1:
        return np.array([centers[0] - 0.5, centers[0] + 0.5])
    middle = 0.5 * (centers[1:] + centers[:-1])
    return np.concatenate([[centers[0] - (middle[0] - centers[0])], middle, [2 * centers[-1] - middle[-1]]])
