"""Temperature readings, and the time for which they may be missing or invalid."""

import math
from dataclasses import dataclass

from drivers.rig.errors import RigStopped

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
