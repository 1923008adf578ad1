"""Temperatures of a panel's twin in a declared weather, at moments to be judged."""

from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.declaration.plate import Plate
from analysis.progress import Progress
from analysis.weather.declared_weather import Weather
from analysis.weather.judgement import WeatherFields
from app.files.bad_file import ResultFileError
from app.twins.warm_twin import WarmTwin
from simulation.heat.weathered import PlateTemperatures, plate_temperatures

MOMENTS_OF_WEATHER = 24
"""Between two of them a car that warms up by 70 K changes by 3 K."""


def check_thermometers(plate: Plate, weather: Weather, origin: str) -> None:
    """Raise ResultFileError for a thermometer that is off the plate; `origin` names the weather's file."""
    inside = plate.contains(np.array([one.point for one in weather.thermometer]))
    for one, on in zip(weather.thermometer, inside, strict=True):
        if not on:
            corners = [[float(f"{x:.6g}") for x in corner] for corner in plate.bounds]
            raise ResultFileError(
                f"{origin}: thermometer {one.name!r} at {list(one.point)} m is off the panel's plate, whose box "
                f"is {corners[0]} to {corners[1]} m; move it onto the plate"
            )


def temperatures(twin: WarmTwin, weather: Weather, origin: str, report: Progress) -> PlateTemperatures:
    """Solve the heat equation of a panel's plate.

    Parameters
    ----------
    origin : str
        Name of the weather's file, for messages.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        Where a part of the plate leaves the laws.
    """
    shell = twin.full.shell
    found = plate_temperatures(twin.panel.plate, shell.space.mesh, shell.thickness, weather, twin.points, report)
    low, high = twin.laws.temperature_range
    coldest, warmest = float(found.bending.min()), float(found.bending.max())
    if coldest < low - 1e-6 or warmest > high + 1e-6:
        raise ResultFileError(
            f"{origin}: it takes parts of the plate to {coldest:.1f} and {warmest:.1f} °C; the laws hold from "
            f"{low:g} to {high:g} °C: change the weather, or update a campaign that covers it"
        )
    return replace(found, bending=np.clip(found.bending, low, high))


def thermometer_places(plate: Plate, weather: Weather) -> Real:
    """Places of the thermometers, (K, 2), -1 to 1 over the box around the plate."""
    return np.stack(plate.normalised(np.array([one.point for one in weather.thermometer])), axis=1)


def weather_fields(twin: WarmTwin, weather: Weather, origin: str, report: Progress) -> WeatherFields:
    """Return the fields at `MOMENTS_OF_WEATHER` even moments and at the beginning; arguments of `temperatures`."""
    found = temperatures(twin, weather, origin, report)
    count = len(found.time)
    chosen = np.unique(np.linspace(0, count - 1, min(MOMENTS_OF_WEATHER + 1, count)).round().astype(int))
    return WeatherFields(
        found.time[chosen],
        found.bending[chosen],
        found.readings[chosen],
        thermometer_places(twin.panel.plate, weather),
        tuple(one.name for one in weather.thermometer),
    )
