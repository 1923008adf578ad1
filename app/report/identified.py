"""Identified modes (the paper's Figs. 9 and 10)."""

import numpy as np
from matplotlib.figure import Figure

from analysis.drawn_curves import drawn_phase, in_lines
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.recordings.frf import Frf
from app.report.page import PageTable
from app.report.style import MEASURED, MODEL, frequency_axis, legend_below, panels
from app.summaries.modes import NUMBERS, SWEEP_HEADINGS, sweep_rows

REFERENCE_TEMPERATURE = 25.4
"""Temperature of the paper's Fig. 10 to which frequencies are referred, degrees Celsius."""


def drawn(tracked: TrackedModes) -> int:
    """Return the sweep that is drawn and whose modes are listed: the one nearest to the reference temperature."""
    return int(np.argmin(np.abs(tracked.temperature - REFERENCE_TEMPERATURE)))


def mode_table(tracked: TrackedModes) -> PageTable:
    """Frequency, damping, standard deviations, status and track of the modes of the sweep that is drawn."""
    row = drawn(tracked)
    return PageTable(SWEEP_HEADINGS, sweep_rows(tracked.modes[row], tracked.track[row]), numbers=NUMBERS)


def overlay(frf: Frf, tracked: TrackedModes, channel: int = 0) -> Figure:
    """Draw one measured FRF, its synthesis from poles and residues in the band identified, and the modes.

    Parameters
    ----------
    tracked : TrackedModes
        Of the same sweeps; the one nearest to the reference temperature is drawn.
    channel : int
        From 0.
    """
    row = drawn(tracked)
    modes = tracked.modes[row]
    low, high = modes.band
    lines = frf.frequency[(frf.frequency >= low) & (frf.frequency <= high)]
    rebuilt = modes.synthesis(lines)[channel]
    figure, axes = panels(2, 1, height=5.4, sharex=True, height_ratios=[2, 1])
    axes[0].semilogy(frf.frequency, np.abs(frf.h[row, channel]), color=MEASURED, lw=1.8, label="measured")
    axes[0].semilogy(lines, np.abs(rebuilt), color=MODEL, lw=1.0, label="from poles and residues")
    axes[0].set_ylim(0.5 * float(np.percentile(np.abs(frf.h[row, channel]), 0.5)), None)
    reading = modes.reading()
    for f, real, sure in zip(reading.frequency_hz, modes.real, modes.sure, strict=True):
        if real:
            axes[0].axvline(f, color="0.6", lw=0.8, ls="-" if sure else ":", zorder=0)
    legend_below(figure, title="vertical lines: modes, solid if kept and confirmed, dotted if weak or unconfirmed")
    noise = np.sqrt(frf.variance[row, channel])
    axes[1].plot(*drawn_phase(frf.frequency, frf.h[row, channel], noise), color=MEASURED, lw=1.8)
    axes[1].plot(*drawn_phase(lines, rebuilt), color=MODEL, lw=1.0)
    count = int(modes.real.sum())
    place = f"{tracked.temperature[row]:.1f} °C, {low:.0f} to {high:.0f} Hz"
    title = f"{place}: {count} modes, misfit {100 * modes.misfit:.2f} %"
    axes[0].set(ylabel=f"|H| {frf.label(channel)}", title=title)
    axes[1].set(ylabel="phase [°]")
    frequency_axis(axes[1])
    return figure


def over_temperature(tracked: TrackedModes) -> Figure:
    """Draw frequencies, relative to those nearest 25.4 °C, and damping ratios of the tracked modes."""
    figure, axes = panels(1, 3, width=11.0, height=4.2)
    reading = tracked.reading()
    order = np.argsort(tracked.temperature, kind="stable")
    temperature = tracked.temperature[order]
    reference = int(np.argmin(np.abs(tracked.temperature - REFERENCE_TEMPERATURE)))
    change = in_lines(100 * (reading.frequency_hz[order] / reading.frequency_hz[reference] - 1))
    for j in range(tracked.track.shape[1]):
        f, zeta = reading.frequency_hz[order, j], 100 * reading.damping_ratio[order, j]
        spread = 200 * reading.sigma_damping_ratio[order, j]
        (line,) = axes[0].plot(temperature, f, ".-", ms=3, lw=0.8)
        hidden = ~(spread < 0.3 * zeta)  # what is hardly known would hide what is known
        axes[1].plot(temperature, change[:, j], color=line.get_color(), lw=0.9)
        zeta[hidden] = np.nan
        axes[2].errorbar(temperature, zeta, spread, color=line.get_color(), lw=0.8, marker=".", ms=3)
    axes[0].set(ylabel="frequency [Hz]", title="tracked modes")
    axes[1].set(
        ylabel="frequency against reference [%]", title=f"relative to {tracked.temperature[reference]:.1f} °C"
    )
    axes[2].set(ylabel="damping ratio [%]", title="damping, where 2σ is below 30 %", ylim=(0, None))
    for each in axes:
        each.set_xlabel("temperature [°C]")
    return figure
