"""The updated twin beside the measurement (the paper's Figs. 11 and 12)."""

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from analysis.drawn_curves import drawn_phase
from analysis.material import MaterialLaws
from analysis.recordings.frf import Frf
from analysis.sheet_material import SheetMaterial
from analysis.updated import Updated
from app.files.results.laws_file import TwinFrf
from app.report.measured import spread
from app.report.style import BAND, MEASURED, MODEL, frequency_axis, legend_below, panels
from app.summaries.sheet import CONSTANTS


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


def laws(updated: Updated, fitted: MaterialLaws | None, uncorrected: MaterialLaws | None = None) -> Figure:
    """E, nu and eta, or constants of a sheet by direction, over temperature: estimates, laws, two-sigma bands.

    Parameters
    ----------
    uncorrected : MaterialLaws, optional
        Of the twin that lacks an effect, drawn dashed; not of a sheet.
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
        if uncorrected is not None:
            fine = np.linspace(*uncorrected.temperature_range, 241)
            law = getattr(uncorrected.at(fine), name) / unit
            each.plot(fine, law, "--", color=MODEL, lw=1.0, label="uncorrected")
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
        axes.plot(temperature, floor, ls=style, color=MEASURED, label=f"noise of the measurement{driven}")
    axes.set(xlabel="temperature [°C]", ylabel="rms|H - twin| / rms|H| [%]", title="misfit", ylim=(0, None))
    legend_below(figure)
    return figure
