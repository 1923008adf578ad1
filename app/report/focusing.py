"""Contrast and spot error before and after compensation (the paper's Figs. 4, 13 and 17), and its Fig. 15."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from analysis.compensation.law_band import ContrastBand
from analysis.compensation.outcome import NETWORK, Compensation
from analysis.focusing.methods import MethodComparison
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.focusing.pareto import FAIR_RIPPLE, ParetoCurve
from analysis.focusing.performance import Aim
from analysis.weather.judged import WeatherJudgement
from app.files.results.best_twin import BY_UPDATE
from app.report.style import BAND, MEASURED, MODEL, frequency_axis, legend_below, panels, temperature_color

PAPER_TEMPERATURES = (0.0, 20.0, 40.0, 60.0)
"""Temperatures of the paper's Figs. 13 and 17, degrees Celsius."""


def before(focusing: Focusing) -> Figure:
    """Contrast and spot error with the filters of one temperature used at every temperature."""
    figure = _over_temperature(focusing.frequency, focusing.temperature, focusing.fixed)
    legend_below(figure, columns=9)
    return figure


def after(compensation: Compensation) -> Figure:
    """Draw the same with the filters the networks give for each temperature."""
    figure = _over_temperature(compensation.frequency, compensation.aim_temperature, compensation.network_aim)
    rows = _rows(compensation.aim_temperature)
    for row in rows:
        figure.axes[0].plot(
            compensation.frequency, compensation.direct_aim.contrast[row], ":", color=MEASURED, lw=0.8
        )
    figure.axes[0].plot([], [], ":", color=MEASURED, lw=0.8, label="filters computed directly")
    legend_below(figure, columns=9)
    return figure


def loss(focusing: Focusing, compensation: Compensation) -> Figure:
    """Mean contrast of the band over temperature: one filter for all, networks, and direct filters."""
    figure, axes = panels(1, 1, height=3.2)
    axes.plot(
        focusing.temperature,
        focusing.fixed.contrast.mean(1),
        "o-",
        color=MODEL,
        ms=3.5,
        label=f"filters of {focusing.reference_temperature:g} °C everywhere",
    )
    place = compensation.methods.index(NETWORK)
    axes.plot(compensation.temperature, compensation.contrast[place].mean(1), color="#00798c", label="networks")
    axes.plot(
        compensation.temperature,
        compensation.contrast_direct.mean(1),
        ":",
        color=MEASURED,
        label="computed directly",
    )
    if compensation.law_band is not None:
        _band(axes, compensation.law_band)
    axes.set(
        xlabel="temperature [°C]", ylabel="mean contrast in band", ylim=(0, 1), title="what temperature costs"
    )
    legend_below(figure)
    return figure


def _band(axes: Axes, band: ContrastBand) -> None:
    """Bars over mean contrast and worst line that the laws' uncertainty leaves."""
    label = f"worst line; bars: {100 * band.share:g} % band of the laws"
    axes.plot(band.temperature, band.nominal[:, 1], "s", ms=3.0, color=BAND, alpha=0.7, label=label)
    for ends in (band.mean, band.worst):
        axes.vlines(band.temperature, ends[:, 0], ends[:, 1], color=BAND, lw=4.0, alpha=0.6)


def correction(focusing: Focusing, uncorrected: Aim) -> Figure:
    """Mean contrast of the band over temperature with and without the effects that the gap workflow found."""
    figure, axes = panels(1, 2, height=3.2)
    own, without = focusing.direct.contrast.mean(1), uncorrected.contrast.mean(1)
    axes[0].plot(focusing.temperature, own, "o-", color=BAND, ms=3.5, label="laws of the corrected twin")
    axes[0].plot(focusing.temperature, without, "o--", color=MODEL, ms=3.5, label=f"laws {BY_UPDATE}")
    axes[0].set(ylabel="mean contrast in band", ylim=(0, 1), title="filters of each temperature")
    legend_below(figure)
    axes[1].plot(focusing.temperature, own - without, "o-", color=BAND, ms=3.5)
    axes[1].axhline(0.0, color=MEASURED, lw=0.8)
    axes[1].set(ylabel="contrast regained", title="what the correction is worth")
    for each in axes:
        each.set_xlabel("temperature [°C]")
    return figure


def tradeoff(curve: ParetoCurve) -> Figure:
    """Contrast against ripple of the sound: all designs, those that no other beats, and the recommended one."""
    figure, axes = panels(1, 1, height=3.6)
    axes.axvspan(0.0, FAIR_RIPPLE, color=MEASURED, alpha=0.08, lw=0)
    axes.plot(curve.ripple, curve.contrast, "o", color=MEASURED, ms=3.0, alpha=0.6, label="designs")
    front = curve.unbeaten
    axes.plot(curve.ripple[front], curve.contrast[front], "o-", color=BAND, ms=4.0, label="not beaten by another")
    best = curve.recommended
    axes.plot(curve.ripple[best], curve.contrast[best], "*", color=MODEL, ms=13.0, label="recommended")
    title = f"contrast against evenness, {curve.temperature:g} °C"
    axes.set(xlabel="third-octave ripple at the listeners [± dB]", ylabel="mean contrast in band", title=title)
    axes.set(xlim=(0.0, None))
    legend_below(figure)
    return figure


def methods(comparison: MethodComparison) -> Figure:
    """STIF beside time reversal, modal control and no control, on the panel's own plate."""
    figure, axes = panels(1, 2, height=3.6, sharex=True)
    for place, name in enumerate(comparison.methods):
        width = 1.8 if name == "stif" else 0.9
        axes[0].plot(comparison.frequency, comparison.contrast[place], lw=width, label=name)
        axes[1].plot(comparison.frequency, 100 * comparison.spot_error[place], lw=width)
    axes[0].set(ylabel="contrast", ylim=(0, 1), title="contrast, eq. (9)")
    axes[1].set(ylabel="spot error [% of Lx]", title="spot error")
    legend_below(figure)
    for each in axes:
        frequency_axis(each)
    return figure


def relative_errors(compensation: Compensation) -> Figure:
    """Relative error of the networks per actuator, and the worst actuator of every method."""
    figure, axes = panels(1, 2, height=3.8, sharey=True)
    place = compensation.methods.index(NETWORK)
    for actuator, curve in enumerate(compensation.relative_error[place].T):
        axes[0].semilogy(
            compensation.temperature, np.maximum(curve, 1e-12), lw=0.9, label=f"actuator {actuator + 1}"
        )
    for row, name in enumerate(compensation.methods):
        worst = compensation.relative_error[row].max(axis=1)
        axes[1].semilogy(compensation.temperature, np.maximum(worst, 1e-12), lw=0.9, label=name)
    axes[0].set(ylabel="relative error, eq. (13) [%]", title="networks, each actuator")
    axes[1].set(title="worst actuator of every method")
    for each in axes:
        each.vlines(compensation.training_temperature, 0.0, 0.03, transform=each.get_xaxis_transform(), color="k")
        each.set_xlabel("temperature [°C] (ticks: trained)")
        each.legend(ncols=2, fontsize=8.5, loc="upper center", bbox_to_anchor=(0.5, -0.18))
    largest = float(compensation.relative_error.max())
    # Where trained, splines are exact: seven decades show all that others reach.
    axes[0].set_ylim(1e-7 * largest, 3.0 * largest)
    return figure


def layout(panel: Panel) -> Figure:
    """Draw the panel with its actuators and the target."""
    figure, axes = panels(1, 1, width=5.0, height=3.8)
    plate = panel.plate
    for loop, width in ((plate.loop, 2.0), *((hole, 1.2) for hole in plate.hole_loops)):
        axes.add_patch(Polygon(loop.polygon, fill=False, lw=width, ec="0.3"))
    for loop in plate.zone_loops:
        axes.add_patch(Polygon(loop.polygon, fill=False, lw=1.0, ls="--", ec="0.6"))
    for number, loop in enumerate(panel.target_loops):
        label = None if number else "target"
        axes.add_patch(Polygon(loop.polygon, fc="#f4d35e", ec="none", label=label))
    for number, patch in enumerate(panel.patch):
        label = "actuators" if number == 0 else None
        axes.add_patch(Polygon(patch.loop.polygon, fc="#00798c", ec="none", label=label))
        axes.annotate(str(number + 1), patch.center, ha="center", va="center", color="white", fontsize=8.5)
    for number, drive in enumerate(panel.drive):
        axes.plot(*drive.point, "o", color="#00798c", ms=12, label=None if number else "actuators")
        axes.annotate(str(number + 1), drive.point, ha="center", va="center", color="white", fontsize=8.5)
    (left, low), (right, high) = plate.bounds
    axes.set(xlim=(left - 0.005, right + 0.005), ylim=(low - 0.005, high + 0.005), aspect="equal")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.grid(visible=False)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _over_temperature(frequency: NDArray[np.float64], temperature: NDArray[np.float64], aim: Aim) -> Figure:
    figure, axes = panels(1, 2, height=3.8, sharex=True)
    span = (float(temperature.min()), float(temperature.max()))
    for row in _rows(temperature):
        color = temperature_color(float(temperature[row]), span)
        label = f"{temperature[row]:g} °C"
        axes[0].plot(frequency, aim.contrast[row], color=color, label=label)
        axes[1].plot(frequency, 100 * aim.spot_error[row], color=color, lw=0.9)
    axes[0].set(ylabel="contrast", ylim=(0, 1), title="contrast, eq. (9)")
    axes[1].set(ylabel="spot error [% of Lx]", title="spot error", ylim=(0, None))
    for each in axes:
        frequency_axis(each)
    return figure


def _rows(temperature: NDArray[np.float64]) -> list[int]:
    """Rows nearest to the paper's temperatures, each once."""
    return sorted({int(np.argmin(np.abs(temperature - t))) for t in PAPER_TEMPERATURES})


def lost_in_weather(found: WeatherJudgement) -> Figure:
    """Temperatures over time, and below the contrast lost at the worst line by each way of knowing them."""
    figure, (above, below) = panels(2, 1, height=5.6, sharex=True, height_ratios=(2, 3))
    coldest, mean, warmest = found.extent.T
    above.fill_between(
        found.time, coldest, warmest, color=MODEL, alpha=0.25, lw=0, label="coldest to warmest place"
    )
    above.plot(found.time, mean, color=MODEL, label="mean of the plate")
    for place, name in enumerate(found.names):
        label = "thermometers" if not place else None
        above.plot(found.time, found.readings[:, place], ":", color=MEASURED, lw=1.0, label=label)
        above.annotate(name, (found.time[-1], found.readings[-1, place]), fontsize=8.5, va="center")
    above.set(ylabel="temperature [°C]", title="a field of temperatures that moves")
    styles = {"one": (MEASURED, "-"), "all": (BAND, "-"), "own": (MODEL, "-")}
    for way, lost in zip(found.ways, found.lost[..., 1], strict=True):
        color, line = styles[way[:3]]
        if "robust" in way:
            line = "--"
        if "tilt" in way:
            line = "o-"
        below.plot(found.time, np.maximum(lost, 1e-5), line, color=color, ms=2.5, lw=1.1, label=way)
    below.set(xlabel="time [s]", ylabel="contrast lost, worst line", yscale="log", ylim=(1e-4, 1.0))
    legend_below(figure, above, below, columns=3)
    return figure
