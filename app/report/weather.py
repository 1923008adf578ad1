"""Filters in a weather: temperatures of the panel, and contrast lost by what is known of them."""

import numpy as np
from matplotlib.figure import Figure

from analysis.weather.judgement import WeatherJudgement
from app.report.style import BAND, MEASURED, MODEL, legend_below, panels


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
