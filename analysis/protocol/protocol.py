"""Sweep, temperature programme and limits together: all settings of a campaign, and all sweeps that follow."""

from dataclasses import dataclass
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from analysis import experiment
from analysis.declaration.strict import Declared, Temperature
from analysis.protocol.limits import Limits
from analysis.protocol.sweep import SweepSettings

OVERHEAD = 0.5
"""Time to set the cards up for one repeat and to bring them to rest again, s."""
Direction = Literal["up", "down"]
Rate = Annotated[float, Field(gt=0.0, le=60.0, description="K/min, magnitude")]


class Settling(Declared):
    """When a temperature counts as reached."""

    within: Annotated[float, Field(ge=0.05, le=10.0, description="K from the target")] = 0.5
    lasting: Annotated[float, Field(ge=0.0, le=36_000.0, description="s without leaving that band")] = 300.0
    timeout: Annotated[float, Field(ge=60.0, le=172_800.0, description="s to get there, the ramp included")] = (
        14_400.0
    )


class Programme(Declared):
    """Where the oven takes the plate, and at which temperatures of it to measure.

    The oven runs each leg as one ramp of constant rate, so that the plate is in the steady state of
    the ramp at every set-point. Sweeps are triggered by the temperature measured, never by time.
    """

    lowest: Annotated[Temperature, Field(description="degrees Celsius, first set-point of the way up")]
    highest: Annotated[Temperature, Field(description="degrees Celsius, last set-point of the way up")]
    every: Annotated[float, Field(ge=0.05, le=100.0, description="K from one set-point to the next")]
    legs: Annotated[tuple[Direction, ...], Field(min_length=1, max_length=2)] = ("up",)
    ramp_rate: Rate
    approach_rate: Annotated[
        Rate | None, Field(description="K/min on the way to a leg's start; unset: ramp_rate")
    ] = None
    lead: Annotated[
        float, Field(ge=0.0, le=50.0, description="K of ramp before the first and after the last set-point")
    ] = 2.0
    soak_before: Annotated[
        float, Field(ge=0.0, le=86_400.0, description="s at the start of every leg, once settled")
    ] = 600.0
    soak_after: Annotated[float, Field(ge=0.0, le=86_400.0, description="s at the end of the last leg")] = 0.0
    settling: Settling = Settling()
    watch: Annotated[Literal["plate", "air"], Field(description="temperature that triggers a sweep")] = "plate"
    tolerance: Annotated[
        float, Field(ge=0.02, le=5.0, description="K from the set-point within which a sweep counts")
    ] = 0.5
    poll_interval: Annotated[float, Field(ge=0.1, le=60.0, description="s between two readings")] = 5.0

    @property
    def temperatures(self) -> tuple[float, ...]:
        """Set-points in ascending order, degrees Celsius."""
        count = round((self.highest - self.lowest) / self.every)
        return tuple(round(self.lowest + index * self.every, 6) for index in range(count + 1))

    @property
    def to_start(self) -> float:
        """Rate of the approach to a leg's start, K/min."""
        return self.approach_rate or self.ramp_rate

    def ends(self, direction: Direction) -> tuple[float, float]:
        """Temperatures at which a leg's ramp starts and ends, degrees Celsius."""
        low, high = self.lowest - self.lead, self.highest + self.lead
        return (low, high) if direction == "up" else (high, low)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        span = self.highest - self.lowest
        if span < 0.0:
            raise ValueError(f"highest {self.highest:g} °C is below lowest {self.lowest:g} °C")
        if abs(span / self.every - round(span / self.every)) > 1e-6:
            raise ValueError(
                f"every {self.every:g} K does not divide the {span:g} K from lowest to highest into whole steps"
            )
        if len(set(self.legs)) != len(self.legs):
            raise ValueError(f"legs {list(self.legs)} name a leg twice")
        if self.tolerance > 0.4 * self.every:
            raise ValueError(
                f"tolerance {self.tolerance:g} K is more than 0.4 of every ({self.every:g} K): a sweep could "
                "then be taken for its neighbour's"
            )
        moved = self.poll_interval * self.ramp_rate / 60.0
        if moved > 0.5 * self.tolerance:
            raise ValueError(
                f"poll_interval {self.poll_interval:g} s: at {self.ramp_rate:g} K/min the temperature moves by "
                f"{moved:.3g} K between two readings, more than half of tolerance ({self.tolerance:g} K); "
                f"at most {30.0 * self.tolerance / self.ramp_rate:.3g} s"
            )
        return self


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


@dataclass(frozen=True)
class AcquisitionProtocol:
    """What is measured when.

    Attributes
    ----------
    sweep : SweepSettings
    programme : Programme
    limits : Limits
    measured_force : bool
        Whether what is recorded of the drive is the force on the plate, not the generator's own voltage.
    settling : float
        Silence before every repeat, in which sensors settle, s.
    responses : tuple of str
        What messages call the responses: sensor and terminal. Empty where they are numbered.
    thermocouples : tuple of str
        Their terminals, for messages. Empty where the sensors on the plate are numbered.
    """

    sweep: SweepSettings
    programme: Programme
    limits: Limits
    measured_force: bool = False
    settling: float = 0.0
    responses: tuple[str, ...] = ()
    thermocouples: tuple[str, ...] = ()

    @property
    def legs(self) -> tuple[Leg, ...]:
        """Every sweep asked for."""
        return legs(self.programme, self.sweep)

    def response(self, number: int) -> str:
        """Name a response, from 0, for people."""
        return f"response {self.responses[number] if self.responses else number + 1}"

    def plate_sensors(self, count: int) -> tuple[str, ...]:
        """Name `count` sensors on the plate for people."""
        if len(self.thermocouples) == count:
            return tuple(f"the plate's thermocouple {terminal}" for terminal in self.thermocouples)
        if count == 1:
            return ("the plate's sensor",)
        return tuple(f"the plate's sensor {number + 1}" for number in range(count))

    @property
    def count(self) -> int:
        """How many sweeps that is."""
        return len(self.programme.temperatures) * len(self.programme.legs) * len(self.sweep.levels)

    @property
    def sweep_seconds(self) -> float:
        """How long one sweep with all its repeats takes, s."""
        return self.sweep.repeats * (self.sweep.record + OVERHEAD + self.settling)

    @property
    def sweep_travel(self) -> float:
        """How far the ramp goes meanwhile, K."""
        return self.sweep_seconds * self.programme.ramp_rate / 60.0

    def seconds(
        self, temperature: float, leg: int = 0, *, ramping: bool = False, start: float | None = None
    ) -> float:
        """Estimate the time to the end, s, lags of oven and plate left aside.

        Parameters
        ----------
        temperature : float
            Now, degrees Celsius.
        leg : int
            The leg under way.
        ramping : bool
            Whether its ramp has begun; otherwise the way to its start and the soak come first.
        start : float, optional
            Where the ramp of the leg under way is begun again, degrees Celsius; else at the leg's start.

        Returns
        -------
        float
            s.
        """
        programme, total, here = self.programme, 0.0, temperature
        for one in self.legs[leg:]:
            if not (ramping and one.number == leg):
                begin = start if start is not None and one.number == leg else one.start
                total += 60.0 * abs(begin - here) / programme.to_start
                total += max(programme.soak_before, programme.settling.lasting)
                here = begin
            total += 60.0 * abs(one.end - here) / programme.ramp_rate
            here = one.end
        return total + programme.soak_after

    def recorded(self) -> experiment.Protocol:
        """Return what a recorded campaign declares of the same sweeps."""
        sweep, programme = self.sweep, self.programme
        return experiment.Protocol(
            sweep=sweep.kind,
            band=sweep.band,
            sweep_duration=sweep.duration,
            taper=sweep.taper,
            tail=sweep.tail,
            repeats=sweep.repeats,
            ramp_rate=programme.ramp_rate,
            temperatures=programme.temperatures,
            directions=programme.legs,
            levels=sweep.levels,
        )
