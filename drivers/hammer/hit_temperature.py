"""Temperature of the plate when it was hit: with what is in doubt about it, in an oven or in a room."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

from analysis.arrays import Real
from analysis.plate_temperature.plate_sensors import APART
from analysis.plate_temperature.sensor_check import OPEN


@dataclass(frozen=True)
class HitTemperature:
    """Temperature at one moment.

    Attributes
    ----------
    value : float
        Degrees Celsius; NaN where there is no usable reading.
    doubt : str
        Why it may be wrong; empty where nothing says so.
    """

    value: float
    doubt: str = ""


def declared(value: float) -> Callable[[], HitTemperature]:
    """Return what gives a temperature that was written into the experiment."""
    return lambda: HitTemperature(value)


def in_a_room(read: Callable[[], Real], names: Sequence[str]) -> Callable[[], HitTemperature]:
    """Return what gives the mean of the thermocouples on a plate that no oven heats.

    Without an oven no air is measured by which a single reading could be judged: sensors that are open or shorted
    are left out, and several are compared with one another.

    Parameters
    ----------
    read : callable
        Returns a reading of each sensor (C,), degrees Celsius.
    names : (C,) sequence of str
        Of the sensors, for messages.
    """

    def temperature() -> HitTemperature:
        readings = dict(zip(names, map(float, read()), strict=True))
        usable = {name: value for name, value in readings.items() if OPEN[0] < value < OPEN[1]}
        doubts = [
            f"{name} reads {readings[name]:g} °C: open or shorted" for name in readings if name not in usable
        ]
        doubts += [
            f"{one} and {other} read {abs(usable[one] - usable[other]):.1f} K apart"
            for one, other in combinations(usable, 2)
            if abs(usable[one] - usable[other]) > APART
        ]
        mean = sum(usable.values()) / len(usable) if usable else math.nan
        return HitTemperature(mean, "; ".join(doubts))

    return temperature
