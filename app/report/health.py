"""A panel's health over its dates."""

import numpy as np
from matplotlib.figure import Figure

from analysis.effect_card import PEOPLES
from analysis.health.watch import HealthReport
from app.report.style import BAND, MEASURED, MODEL, panels
from app.summaries.gap import USUAL


def trend(report: HealthReport) -> Figure:
    """Draw temperature, strongest candidate and, where something has changed, its amplitude, date by date."""
    judged = report.judged
    named = report.found is not None and bool(report.found.trend)
    rows = 3 if named else 2
    figure, axes = panels(rows, 1, height=2.0 + 1.6 * rows, sharex=True)
    places = np.arange(len(judged))
    alarm = np.array([one.alarm for one in judged], dtype=bool)
    temperature = [one.temperature for one in judged]
    axes[0].errorbar(
        places, temperature, [1.645 * one.sigma for one in judged], fmt="o", ms=3.0, lw=0.8, color=MEASURED
    )
    axes[0].set(ylabel="own temperature [°C]", title="the panel's own temperature, with 90 % intervals")
    z = np.array([one.z for one in judged])
    axes[1].plot(places[~alarm], z[~alarm], "o", ms=3.5, color=MEASURED)
    axes[1].plot(places[alarm], z[alarm], "o", ms=4.5, mfc="none", color=MODEL)
    axes[1].axhline(report.limit, color=MODEL, lw=1.0, ls="--")
    axes[1].set(
        ylabel="strongest [σ]", title=f"strongest change; dashed: at most {report.rate:g} false alarms a date"
    )
    if z.size and z.max() > 10.0 * report.limit:
        axes[1].set_yscale("symlog", linthresh=report.limit)
    if named and report.found is not None and report.found.change is not None:
        one = report.found.change.candidate.parameter
        shown = one.shown or USUAL.get(one.unit, "")
        factor = PEOPLES.get((one.unit, shown), 1.0)
        unit = shown if (one.unit, shown) in PEOPLES else one.unit
        value, sigma = factor * np.array(report.found.trend).T
        seen = np.isfinite(sigma)
        axes[2].errorbar(places[seen], value[seen], 1.645 * sigma[seen], fmt="o", ms=3.0, lw=0.8, color=BAND)
        axes[2].set(
            ylabel=f"{one.name} [{unit}]",
            title=f"{report.found.change.candidate.title} by each date alone, to first order, 90 %",
        )
    axes[-1].set_xticks(places[:: max(1, len(places) // 12)])
    axes[-1].set_xticklabels([one.date for one in judged[:: max(1, len(places) // 12)]], rotation=30, ha="right")
    return figure
