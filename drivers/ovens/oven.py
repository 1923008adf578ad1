"""The interface of every oven."""

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable


@dataclass(frozen=True)
class SetPoint:
    """A ramp as the controller has taken it.

    Attributes
    ----------
    target : float
        Temperature at its end, degrees Celsius.
    rate : float
        Magnitude, K/min.
    """

    target: float
    rate: float


@dataclass(frozen=True)
class OvenLimits:
    """What the software never asks the oven to exceed; the oven's own limiter stays in charge of safety.

    Attributes
    ----------
    minimum, maximum : float
        Set-points allowed, degrees Celsius.
    max_rate : float
        Steepest ramp allowed, K/min.
    """

    minimum: float
    maximum: float
    max_rate: float

    def __post_init__(self) -> None:
        if not -273.15 <= self.minimum < self.maximum < math.inf:
            raise ValueError(
                f"oven limits {self.minimum:g} to {self.maximum:g} °C: the lower must be at least -273.15 °C "
                "and below the upper"
            )
        if not 0.0 < self.max_rate < math.inf:
            raise ValueError(f"max_rate {self.max_rate:g} K/min must be above 0 and finite")

    def clamp(self, target: float, rate: float) -> SetPoint:
        """Return the nearest ramp allowed to one asked for.

        Parameters
        ----------
        target : float
            degrees Celsius.
        rate : float
            Magnitude, K/min; above 0.

        Raises
        ------
        ValueError
            For a target that is no number, or a rate that is no positive one.
        """
        if not math.isfinite(target):
            raise ValueError(f"target {target!r} °C is no temperature")
        if not 0.0 < rate < math.inf:
            raise ValueError(
                f"rate {rate!r} K/min must be above 0 and finite; the direction follows from the target"
            )
        return SetPoint(self.clamp_target(target), min(float(rate), self.max_rate))

    def clamp_target(self, target: float) -> float:
        """Return the nearest set-point allowed, degrees Celsius."""
        return min(max(float(target), self.minimum), self.maximum)


@runtime_checkable
class Bounded(Protocol):
    """An oven whose controller reports its own limits of the set-point."""

    def bounds(self) -> tuple[float, float]:
        """Return the lowest and the highest set-point the controller takes, degrees Celsius; may ask it."""
        ...


NEAR = 1.0
"""How far beyond its ends a ramp may begin, K: at the temperature measured, or at the set-point before."""
SAME = 0.11
"""Difference of two set-points that are the same, K: a digit of the coarsest controller, rounded twice."""


@runtime_checkable
class Contested(Protocol):
    """An oven whose controller tells what it was commanded last, so that another master is seen.

    Another master is a hand at its panel, a programme of its own, or another computer.
    """

    def changed(self) -> str:
        """Say what differs from the last command of this driver; empty where nothing does, or none is in force.

        Only reads; may raise `OvenError`.
        """
        ...


def other_set_point(told: float | None, held: float) -> str:
    """Say that a controller's set-point is another than the one it was told last; empty where it is the same.

    Parameters
    ----------
    told : float or None
        As it was taken, degrees Celsius; None where nothing is in force.
    held : float
        As it reads now, degrees Celsius.
    """
    if told is None or abs(held - told) <= SAME:
        return ""
    return f"its set-point is {held:g} °C, and {told:g} °C was commanded"


def beyond_ramp(ends: tuple[float, float] | None, held: float) -> str:
    """Say that the set-point of a ramp is not between where it began and where it ends; empty where it is.

    Parameters
    ----------
    ends : (float, float) or None
        Of the ramp, degrees Celsius; None where nothing is in force.
    held : float
        As it reads now, degrees Celsius.
    """
    if ends is None:
        return ""
    low, high = min(ends) - NEAR, max(ends) + NEAR
    if low <= held <= high:
        return ""
    return f"its set-point is {held:g} °C on a ramp from {ends[0]:g} to {ends[1]:g} °C"


class Oven(Protocol):
    """An oven on a line: five verbs, each of which may raise `OvenError`.

    The controller runs its ramps itself: the computer sets one up, watches the temperature and writes nothing in
    between. Where it has no ramps (`MappedOven`), a thread of the driver moves its set-point in steps. Every
    write is read back.
    """

    @property
    def limits(self) -> OvenLimits:
        """What set-points are clamped to."""
        ...

    @property
    def poll_within(self) -> float:
        """Seconds within which `temperature` must be called again; infinity where it need not be."""
        ...

    def temperature(self) -> float:
        """Air temperature measured by the controller, degrees Celsius."""
        ...

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Start a ramp and return it as taken.

        Parameters
        ----------
        target : float
            degrees Celsius; clamped to the limits.
        rate : float
            Magnitude, K/min; clamped to the limits.
        """
        ...

    def hold(self) -> float:
        """Stop the ramp where it is and stay there; return the set-point kept, degrees Celsius.

        An oven at rest is started at the temperature it has.
        """
        ...

    def safe(self) -> None:
        """Put the oven into the state in which it neither heats nor cools; may be called again at will.

        All commands that this takes are sent before anything is read (`drivers.ovens.line.Line.blind`): a line may
        still carry commands when its answers are lost, or come too late. Then the state is read back, and what
        cannot be read is an error.
        """
        ...

    def close(self) -> None:
        """Let go of the port. The oven goes on doing what it was doing."""
        ...
