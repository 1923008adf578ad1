"""Units of controllers for temperatures and rates, to degrees Celsius and K/min and back."""

from typing import Literal

TemperatureUnit = Literal["degC", "degF", "K"]
RateUnit = Literal["K/min", "K/s", "K/h", "degF/min", "degF/h"]

_FACTORS: dict[str, tuple[float, float]] = {
    "degC": (1.0, 0.0),
    "degF": (5.0 / 9.0, -160.0 / 9.0),
    "K": (1.0, -273.15),
    "K/min": (1.0, 0.0),
    "K/s": (60.0, 0.0),
    "K/h": (1.0 / 60.0, 0.0),
    "degF/min": (5.0 / 9.0, 0.0),
    "degF/h": (5.0 / 540.0, 0.0),
}


def factors(unit: TemperatureUnit | RateUnit) -> tuple[float, float]:
    """Return slope and intercept from a unit to degrees Celsius, or to K/min."""
    return _FACTORS[unit]
