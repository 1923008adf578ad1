"""Sound at the listeners and its direction, over temperature."""

import numpy as np
from matplotlib.figure import Figure

from analysis.focusing.radiated import DEGREES, Radiation
from app.report.style import MEASURED, frequency_axis, legend_below, panels, temperature_color

TEMPERATURES_DRAWN = 5
"""Temperatures drawn, at most."""


def levels(found: Radiation) -> Figure:
    """Level at the listeners over frequency, with filters that follow and with those of one temperature."""
    figure, axes = panels(1, 2, height=3.6, sharex=True, sharey=True)
    titles = ("filters of each temperature", f"those of {found.reference_temperature:g} °C kept")
    span = (float(found.temperature[0]), float(found.temperature[-1]))
    for each, sound, title in zip(axes, (found.following, found.kept), titles, strict=True):
        lines = found.line_levels(sound)
        for t in _shown(len(found.temperature)):
            color = temperature_color(float(found.temperature[t]), span)
            for listener, level in enumerate(lines[t]):
                label = f"{found.temperature[t]:g} °C" if each is axes[0] and not listener else None
                each.plot(found.frequency, level, color=color, lw=1.0, label=label)
        each.axhspan(-1.0, 1.0, color=MEASURED, alpha=0.1, lw=0)
        each.set_title(title)
        frequency_axis(each)
    axes[0].set(ylabel="level, dB of the sound wanted", ylim=(-25.0, 10.0))
    legend_below(figure, columns=6)
    return figure


def polar(found: Radiation) -> Figure:
    """Directivity in third-octave bands, in both planes, at the middle one of the temperatures."""
    figure, axes = panels(1, 2, height=3.6, sharex=True, sharey=True)
    middle = len(found.temperature) // 2
    for each, plane, name in zip(axes, found.following.polar[middle], "xy", strict=True):
        for band, frequency in enumerate(found.middles):
            color = temperature_color(float(band), (0.0, float(len(found.middles) - 1) or 1.0))
            label = f"{frequency:.0f} Hz" if name == "x" else None
            each.plot(DEGREES, plane[:, band], color=color, lw=1.0, label=label)
        each.set(xlabel="degrees from the normal", title=f"plane of {name}, {found.temperature[middle]:g} °C")
    axes[0].set(ylabel="dB of the normal's", ylim=(-20.0, 10.0))
    legend_below(figure, columns=5)
    return figure


def powers(found: Radiation) -> Figure:
    """Share of the power from the target, and radiation efficiency, over frequency."""
    figure, axes = panels(1, 2, height=3.4, sharex=True)
    span = (float(found.temperature[0]), float(found.temperature[-1]))
    for t in _shown(len(found.temperature)):
        color = temperature_color(float(found.temperature[t]), span)
        axes[0].plot(
            found.frequency, found.following.target_share[t], color=color, label=f"{found.temperature[t]:g} °C"
        )
        axes[1].semilogy(found.frequency, found.following.efficiency[t], color=color)
    axes[0].set(ylabel="share", title="power from the target", ylim=(-0.5, 2.0))
    axes[1].set(title="radiation efficiency")
    legend_below(figure, columns=6)
    for each in axes:
        frequency_axis(each)
    return figure


def _shown(count: int) -> list[int]:
    """Return some temperatures, the ends among them."""
    return sorted(set(np.linspace(0, count - 1, min(TEMPERATURES_DRAWN, count)).round().astype(int).tolist()))
