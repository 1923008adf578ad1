"""Temperature readings: how long they may be missing or invalid, and whether they can be true.

Judged here are jumps of the air, the difference of air and plate, and units. What the sensors on the plate may
read is judged by `analysis.plate_temperature`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from drivers.rig.end_requests import RESUME, RigStopped

RESOLUTION = 3
"""Decimals kept of a reading: a millikelvin is a twentieth of the resolution of any sensor here."""


@dataclass(frozen=True)
class Reading:
    """Temperatures at one moment.

    Attributes
    ----------
    air : float
        The oven's own sensor, degrees Celsius.
    plate : float or None
        The sensors on the plate; None where there is none.
    doubts : tuple of str
        Why the plate's temperature may be wrong.
    """

    air: float
    plate: float | None
    doubts: tuple[str, ...] = ()

    @property
    def believable(self) -> bool:
        """Whether both are values that an intact sensor can give."""
        return all(math.isfinite(value) and -120.0 < value < 400.0 for value in self._values)

    @property
    def _values(self) -> tuple[float, ...]:
        return (self.air,) if self.plate is None else (self.air, self.plate)

    def require_within(self, coldest: float, hottest: float) -> None:
        """Raise RigStopped unless both lie within the limits."""
        for name, value in zip(("air", "plate"), self._values, strict=False):
            if not coldest <= value <= hottest:
                raise RigStopped(
                    f"{name} temperature {value:.1f} °C is outside limits.coldest and hottest, "
                    f"{coldest:g} to {hottest:g} °C",
                    "Look at the oven, its set-point and its sensors before going on",
                )


class Patience:
    """Timer of consecutive failures, which raises RigStopped after too long.

    Parameters
    ----------
    limit : float
        s.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._since = math.inf

    @property
    def failing(self) -> bool:
        """Whether the last call reported a failure."""
        return self._since < math.inf

    def good(self) -> None:
        """Reset after a success."""
        self._since = math.inf

    def bad(self, now: float, what: str, next_step: str) -> None:
        """Record a failure.

        Parameters
        ----------
        now : float
            s.
        what : str
            What fails.
        next_step : str
            What to do about it.

        Raises
        ------
        RigStopped
            If failures have lasted as long as the limit, or longer.
        """
        self._since = min(self._since, now)
        if now - self._since >= self._limit:
            raise RigStopped(
                f"{what}, for {now - self._since:.0f} s (limits.lost_after {self._limit:g} s)", next_step
            )


SLACK = 0.5
"""Largest change from the last reading beyond that of the ramp, K."""
OVERSHOOT = 2.0
"""Factor by which the air may change faster than the steepest ramp."""
APART = 2.0
"""Largest difference of air and plate at the end of a soak, K."""
SETTLED = 0.1
"""The plate counts as soaked if it changes by less within a minute, K."""


class CheckedSensor:
    """Reads a sensor a second time if its reading has jumped, to ignore a glitch on the line.

    No controller protocol numbers its answers, and ASCII-2 and P-300 have no checksum: a late answer to an earlier
    request, or one with a wrong digit, looks valid. It is unlikely to happen twice.

    Parameters
    ----------
    ask : callable
        Returns a temperature, degrees Celsius.
    now : callable
        s.
    max_rate : float
        Steepest ramp, K/min.
    """

    def __init__(self, ask: Callable[[], float], now: Callable[[], float], max_rate: float) -> None:
        self._ask = ask
        self._now = now
        self._rate = OVERSHOOT * max_rate / 60.0
        self._last: tuple[float, float] | None = None

    def read(self) -> float:
        """Return the temperature now; a reading that has jumped is replaced by a second one."""
        value = self._ask()
        if self._last is not None and not self._near(value, *self._last):
            value = self._asked_again(value, *self._last)
        self._last = (value, self._now())
        return value

    def _asked_again(self, jumped: float, last: float, moment: float) -> float:
        second = self._ask()
        if self._near(second, last, moment) or self._near(second, jumped, self._now()):
            return second
        return self._ask()  # the second was damaged as well

    def _near(self, value: float, other: float, moment: float) -> bool:
        return abs(value - other) <= SLACK + self._rate * (self._now() - moment)


def require_agreement(reading: Reading, minute_before: float | None) -> None:
    """Raise RigStopped if air and plate differ at the end of a soak although the plate is stationary.

    Parameters
    ----------
    minute_before : float or None
        The plate's temperature a minute before, degrees Celsius; None where there is none.
    """
    if reading.plate is None or minute_before is None or abs(reading.plate - minute_before) > SETTLED:
        return
    if abs(reading.air - reading.plate) > APART:
        raise RigStopped(
            f"after the soak the air reads {reading.air:.1f} °C and the plate, at rest, {reading.plate:.1f} °C; "
            f"{APART:g} K apart allowed",
            "Check the thermocouple's type (cards.thermocouple_type), where it touches the plate, and the unit "
            f"and the sensor of the controller. {RESUME}",
        )


def require_celsius(reading: Reading) -> None:
    """Raise RigStopped if the controller, before anything moves, clearly shows degrees Fahrenheit or kelvin."""
    if reading.plate is None:
        return
    if abs(reading.air - reading.plate) < 10.0:
        return
    for unit, other in (("Fahrenheit", 1.8 * reading.plate + 32.0), ("kelvin", reading.plate + 273.15)):
        if abs(reading.air - other) < 8.0:
            raise RigStopped(
                f"the controller reads {reading.air:.1f}, the plate has {reading.plate:.1f} °C: that is {unit}",
                "Set the controller, its communication included, to degrees Celsius",
            )
