"""Measured FRFs, identified modes and the updated twin over temperature (the paper's Figs. 7 and 9 to 12)."""

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from analysis.drawn_curves import drawn_phase, in_lines
from analysis.estimates import SheetMaterial
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.material import MaterialLaws
from analysis.recordings.frf import Frf
from analysis.updated import Updated
from app.files.results.laws_file import TwinFrf
from app.report.page import PageTable
from app.report.style import BAND, MEASURED, MODEL, frequency_axis, legend_below, panels, temperature_color
from app.summaries.modes import NUMBERS, SWEEP_HEADINGS, sweep_rows
from app.summaries.update import CONSTANTS

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


def overlays(frf: Frf, twin: TwinFrf, updated: Updated, channel: int = 0, source: int = 0) -> Figure:
    """Measured and updated FRFs, amplitude and phase, cold, in the middle and hot.

    Parameters
    ----------
    twin : TwinFrf
        Of the same sweeps and lines.
    channel : int
        From 0.
    source : int
        Which input drove the sweeps that are drawn.
    """
    own = np.flatnonzero(frf.driven_by == source)
    rows = own[spread(frf.temperature[own], 3)].tolist()
    figure, axes = panels(2, len(rows), width=11.0, height=5.2, sharex=True, squeeze=False, height_ratios=[2, 1])
    for column, row in enumerate(rows):
        amplitude, phase = axes[:, column]
        rest = np.abs(frf.h[row, channel] - twin.h[row, channel])
        amplitude.semilogy(frf.frequency, rest, color="0.75", lw=0.4, label="difference")
        noise = np.sqrt(frf.variance[row, channel])
        for h, deviation, color, label, width in (
            (frf.h[row, channel], noise, MEASURED, "measured", 1.8),
            (twin.h[row, channel], 0.0, MODEL, "updated twin", 1.0),
        ):
            amplitude.semilogy(frf.frequency, np.abs(h), color=color, label=label, lw=width)
            phase.plot(*drawn_phase(frf.frequency, h, deviation), color=color, lw=width)
        amplitude.set_title(
            f"{updated.temperature[row]:.1f} °C: misfit {100 * updated.misfit[row]:.2f} %, "
            f"noise {100 * updated.noise_floor[row]:.2f} %"
        )
        amplitude.set_ylim(bottom=0.1 * float(np.median(rest)))
        frequency_axis(phase)
    axes[0, 0].set_ylabel(f"|H| {frf.label(channel, rows[0])}")
    axes[1, 0].set_ylabel("phase [°]")
    legend_below(figure)
    return figure


def laws(
    updated: Updated, fitted: MaterialLaws | None, before: MaterialLaws | None = None, before_said: str = "before"
) -> Figure:
    """E, nu and eta, or constants of a sheet by direction, over temperature: estimates, laws, two-sigma bands.

    Parameters
    ----------
    before : MaterialLaws, optional
        Of the twin that lacks an effect, drawn dashed; not of a sheet.
    before_said : str
        What these are, for the legend.
    """
    if updated.sheet is not None:
        return _sheet(updated, updated.sheet)
    figure, axes = panels(1, 3, height=3.6)
    names = (
        ("youngs_modulus", 1e9, "E [GPa]", "Young's modulus"),
        ("loss_factor", 0.01, "η [%]", "loss factor"),
        ("poisson_ratio", 1.0, "ν", "Poisson's ratio"),
    )
    good = updated.settled
    for each, (name, unit, label, title) in zip(axes, names, strict=True):
        value, sigma = getattr(updated.material, name) / unit, getattr(updated.sigma, name) / unit
        each.errorbar(updated.temperature[good], value[good], 2 * sigma[good], fmt="o", ms=3.5, color=MEASURED)
        if not good.all():
            each.plot(updated.temperature[~good], value[~good], "x", color=MODEL, label="not settled")
        if fitted is not None:
            fine = np.linspace(*fitted.temperature_range, 241)
            law, band = getattr(fitted.at(fine), name) / unit, getattr(fitted.sigma(fine), name) / unit
            each.plot(fine, law, color=BAND)
            each.fill_between(fine, law - 2 * band, law + 2 * band, color=BAND, alpha=0.25, lw=0)
        if before is not None:
            fine = np.linspace(*before.temperature_range, 241)
            law = getattr(before.at(fine), name) / unit
            each.plot(fine, law, "--", color=MODEL, lw=1.0, label=before_said)
        each.set(xlabel="temperature [°C]", ylabel=label, title=title)
    legend_below(figure)
    return figure


def _sheet(updated: Updated, found: SheetMaterial) -> Figure:
    """Constants of an orthotropic sheet by direction over temperature, with two standard deviations."""
    figure, axes = panels(2, 3, height=6.2)
    good, t = updated.settled, updated.temperature
    places = (0, 1, 2, 3, 4, 4, 4)
    for one, place, mark in zip(CONSTANTS, places, ("o", "o", "o", "o", "o", "s", "^"), strict=True):
        each = axes.flat[place]
        value, sigma = (getattr(part, one.name) / one.scale for part in (found.value, found.sigma))
        many = places.count(place) > 1
        color = None if many else MEASURED
        label = one.symbol if many else None
        each.errorbar(t[good], value[good], 2 * sigma[good], fmt=mark, ms=3.5, color=color, label=label)
        if not good.all():
            each.plot(t[~good], value[~good], "x", color=MODEL)
        each.set(xlabel="temperature [°C]", ylabel="η [%]" if many else one.label)
        each.set_title("loss factors" if many else one.title)
    axes.flat[4].legend()
    axes.flat[5].axis("off")
    return figure


def misfit(updated: Updated, frf: Frf) -> Figure:
    """Misfit of every sweep against its noise, a line for the sweeps of each input."""
    figure, axes = panels(1, 1, height=2.8)
    for source, style in zip(frf.driving, cycle(("-", "--", "-.", ":")), strict=False):
        own = np.flatnonzero(frf.driven_by == source)
        driven = f", {frf.sources[source]} driven" if frf.sources else ""
        temperature, missed, floor = (
            each[own] for each in (updated.temperature, 100 * updated.misfit, 100 * updated.noise_floor)
        )
        axes.plot(temperature, missed, "o", ls=style, color=MODEL, ms=3.5, label=f"updated twin{driven}")
        alone = "_" if len(own) == 1 else ""  # of one sweep no line would be drawn
        said = f"noise of the measurement{driven}"
        axes.plot(temperature, floor, ls=style, marker=alone, ms=14, color=MEASURED, label=said)
    axes.set(xlabel="temperature [°C]", ylabel="rms|H - twin| / rms|H| [%]", title="misfit", ylim=(0, None))
    legend_below(figure)
    return figure
