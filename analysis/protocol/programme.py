"""The temperature programme as declared."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from analysis.declared import Declared, Temperature

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
