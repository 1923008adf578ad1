"""Commands that end by themselves: an oven whose computer has died, or whose cable was pulled, comes to rest.

The controller is given a program, or a timer, of limited time with every command. Whoever watches the oven renews
it. Nothing is renewed more often than every half of that time, so that the controller's memory is not worn.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, runtime_checkable

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.oven import SetPoint

HARMLESS = 20.0
"""Where a controller is sent that has to have a set-point while no program runs, degrees Celsius."""
LONGEST, SHORTEST = 86_400.0, 600.0
"""An oven may be left to itself for so long, s."""


@runtime_checkable
class Expiring(Protocol):
    """An oven that comes to rest by itself if its last command is not renewed."""

    def renew(self) -> None:
        """Renew the last command if that is due; cheap where it is not. May raise `OvenError`."""
        ...


class Expiry:
    """When a command is to be renewed.

    Parameters
    ----------
    rest_after : float
        The controller goes on by itself for so long after its ramp, s.

    Attributes
    ----------
    under_way : tuple of SetPoint or None
        The ramp asked for last, and as it was taken: asked for again while it runs, it is not begun anew.
    starting : bool
        Whether a program is being started, or a start was broken off: then it has to be tried again.
    """

    def __init__(self, rest_after: float) -> None:
        self.rest_after = rest_after
        self._at = math.inf
        self.under_way: tuple[SetPoint, SetPoint] | None = None
        self.starting = False

    def begin(self, now: float, ramp: float = 0.0) -> None:
        """Begin at `now` a command whose ramp takes so long, both s."""
        self._at = now + ramp + 0.5 * self.rest_after
        self.starting = False

    def end(self) -> None:
        """Nothing is left to renew."""
        self._at = math.inf
        self.under_way, self.starting = None, False

    def due(self, now: float) -> bool:
        """Whether to renew at `now`, s."""
        return now >= self._at


@contextmanager
def of(program: str, without: str) -> Iterator[None]:
    """Say of what is refused, or not taken, that it was a program's, and how to go `without` one."""
    try:
        yield
    except OvenError as error:
        if error.fault in (Fault.REFUSED, Fault.NOT_TAKEN):
            raise OvenError(error.fault, f"{program}: {error.what}", without, error.code) from error
        raise


@contextmanager
def refused_is_none() -> Iterator[None]:
    """Take a controller that refuses to end its program for one that has none: nothing of it has to rest."""
    try:
        yield
    except OvenError as error:
        if error.fault is not Fault.REFUSED:
            raise
