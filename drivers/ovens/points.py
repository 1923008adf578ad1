"""Interfaces of a declared controller: values that are read, values that are set, and a switch."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

from drivers.ovens.error import Fault, OvenError

PLAUSIBLE = (-100.0, 400.0)
"""A controller of a climatic chamber reads nothing else, degrees Celsius: scale, unit or word order are wrong."""


class Value(Protocol):
    """A temperature in degrees Celsius, or a rate in K/min, as the controller reports it."""

    def read(self) -> float:
        """Ask for it."""
        ...


class Setting(Value, Protocol):
    """A value that can be set."""

    @property
    def resolution(self) -> float:
        """Smallest difference it can hold."""
        ...

    def send(self, value: float) -> None:
        """Command it to be set to `value`; nothing is read, neither before nor afterwards."""
        ...

    def put(self, value: float) -> float:
        """Set it to `value`, and return what it reads back; OvenError of kind not taken where that differs."""
        ...


class Switch(Protocol):
    """Whether the controller regulates."""

    def on(self) -> bool:
        """Ask whether it does."""
        ...

    def send(self, on: bool) -> None:
        """Command it; nothing is read, neither before nor afterwards."""
        ...

    def put(self, on: bool) -> None:
        """Switch, and read back; OvenError of kind not taken where it reads back otherwise."""
        ...


def no_status() -> None:
    """Do nothing: the controller reports no status."""


@dataclass(frozen=True)
class Points:
    """All of a controller that is used.

    Attributes
    ----------
    temperature : Value
        Of the air.
    set_point : Setting
    working : Value or None
        Where the controller's own ramp is.
    rate : Setting or None
        Of the controller's own ramp; None where it has none.
    run : Switch or None
        None where it regulates whenever it has power.
    rest_at : float or None
        Set-point that takes the place of switching off, degrees Celsius.
    require_good : callable
        Raises OvenError of kind alarm if the controller reports an alarm.
    """

    temperature: Value
    set_point: Setting
    working: Value | None = None
    rate: Setting | None = None
    run: Switch | None = None
    rest_at: float | None = None
    require_good: Callable[[], None] = no_status


def not_taken(name: str, wanted: str, held: str) -> OvenError:
    """Return the error for a controller that reads back something else than it was set to.

    Parameters
    ----------
    name : str
        What was set.
    wanted, held : str
        The values, with their units where they have any.

    Returns
    -------
    OvenError
        Of kind not taken. It is returned, not raised.
    """
    return OvenError(
        Fault.NOT_TAKEN,
        f"{name} was set to {wanted} and reads back {held}",
        "Check the controller's own limits, its keyboard lock, whether somebody uses its front panel, and what is "
        "declared of it.",
    )


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
