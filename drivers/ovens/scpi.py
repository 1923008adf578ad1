"""Kind ``scpi``: an oven whose queries and commands stand in the experiment's file."""

from functools import partial
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from analysis.declared import Temperature
from drivers.clock import Clock
from drivers.ovens.line import Transport
from drivers.ovens.mapped_oven import COARSEST, MappedOven, require_rest
from drivers.ovens.oven import Oven
from drivers.ovens.points import Points, no_status
from drivers.ovens.settings import OvenSettings
from drivers.ovens.text_protocol import (
    RatePhrase,
    RunPhrase,
    StatusPhrase,
    TemperaturePhrase,
    TemperatureQuery,
    TextLine,
    TextSetting,
    TextSwitch,
    TextValue,
    require_good,
)

if TYPE_CHECKING:  # simulated ovens need numpy, which the watchdog's process does without
    from drivers.ovens.simulated.controller import Controller
    from drivers.ovens.simulated.regulated_oven import RegulatedOven


class ScpiOven(TextLine, OvenSettings):
    """Queries and commands of a controller without a driver of its own."""

    temperature: Annotated[TemperatureQuery, Field(description="of the air, as measured")]
    set_point: Annotated[TemperaturePhrase, Field(description="of the controller, at the end of a ramp")]
    working_set_point: Annotated[
        TemperatureQuery | None, Field(description="where the controller's ramp is; needed to hold it exactly")
    ] = None
    rate: Annotated[
        RatePhrase | None, Field(description="of the controller's ramp; without it, the set-point moves in steps")
    ] = None
    run: Annotated[RunPhrase | None, Field(description="starts and stops it; this or rest_at")] = None
    rest_at: Annotated[Temperature | None, Field(description="degrees Celsius, set where nothing stops it")] = None
    status: Annotated[StatusPhrase | None, Field(description="asked before each temperature")] = None
    step: Annotated[float, Field(ge=0.01, le=5.0, description="K, of a ramp in steps")] = 0.2

    @model_validator(mode="after")
    def _usable(self) -> Self:
        require_rest(self.run is not None, self.rest_at, self.limits())
        if self.run is not None and (both := set(self.run.is_on) & set(self.run.is_off)):
            raise ValueError(f"run: {', '.join(sorted(both))} is in is_on and in is_off")
        if self.set_point.resolution > COARSEST:
            raise ValueError(
                f"set_point moves in steps of {self.set_point.resolution:g} K; at most {COARSEST:g}; see decimals"
            )
        if self.rate is not None and self.rate.resolution > self.max_rate:
            raise ValueError(
                f"rate moves in steps of {self.rate.resolution:g} K/min, above max_rate: check decimals"
            )
        return self

    def open(self, clock: Clock, transport: Transport | None = None) -> Oven:
        """Open the line."""
        connection = self.connection(clock, transport)
        try:
            working = self.working_set_point
            points = Points(
                temperature=TextValue("temperature", connection, self.temperature),
                set_point=TextSetting("set_point", connection, self.set_point),
                working=TextValue("working_set_point", connection, working) if working else None,
                rate=TextSetting("rate", connection, self.rate) if self.rate else None,
                run=TextSwitch(connection, self.run) if self.run else None,
                rest_at=self.rest_at,
                require_good=partial(require_good, connection, self.status) if self.status else no_status,
            )
            return MappedOven(connection.line, points, self.limits(), clock, self.step)
        except BaseException:
            connection.line.close()
            raise

    def rest_temperature(self, room: float) -> float:
        """Return `rest_at`, of an oven that nothing stops."""
        return room if self.rest_at is None else self.rest_at

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller":
        """Return a controller that answers these queries and commands."""
        from drivers.ovens.simulated.scpi import SimulatedScpi  # which reads this declaration

        return SimulatedScpi(self, body)
