"""All sweeps of a protocol."""

from dataclasses import dataclass

from analysis.protocol.programme import Direction, Programme
from analysis.protocol.sweep import SweepSettings


@dataclass(frozen=True)
class SweepSetPoint:
    """One sweep to be made.

    Attributes
    ----------
    step : int
        Place in the order asked for; names the sweep for ever.
    temperature : float
        degrees Celsius.
    direction : str
        Of the leg.
    level : float
        V.
    offset : float
        Where in the group of levels at this temperature the sweep comes, in sweep lengths from the
        group's middle: -0.5 and 0.5 for two levels.
    """

    step: int
    temperature: float
    direction: Direction
    level: float
    offset: float

    def __str__(self) -> str:
        return f"{self.temperature:g} °C {self.direction} {self.level:g} V"


@dataclass(frozen=True)
class Leg:
    """One ramp through the set-points.

    Attributes
    ----------
    number : int
        From 0.
    direction : str
    start, end : float
        Of the ramp, degrees Celsius.
    set_points : tuple of SweepSetPoint
        In the order they are met.
    """

    number: int
    direction: Direction
    start: float
    end: float
    set_points: tuple[SweepSetPoint, ...]

    @property
    def sign(self) -> float:
        """1 on the way up, -1 on the way down."""
        return 1.0 if self.direction == "up" else -1.0


def legs(programme: Programme, sweep: SweepSettings) -> tuple[Leg, ...]:
    """Return the legs in order, each with its sweeps, levels in turn at every temperature."""
    found: list[Leg] = []
    step = 0
    middle = 0.5 * (len(sweep.levels) - 1)
    for number, direction in enumerate(programme.legs):
        points = []
        for temperature in programme.temperatures[:: 1 if direction == "up" else -1]:
            for place, level in enumerate(sweep.levels):
                points.append(SweepSetPoint(step, temperature, direction, level, place - middle))
                step += 1
        found.append(Leg(number, direction, *programme.ends(direction), tuple(points)))
    return tuple(found)
