"""Ovens whose registers or commands an experiment's file declares: kinds ``modbus-map`` and ``scpi``."""

from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Temperature
from drivers.clock import Clock
from drivers.ovens.line import Transport
from drivers.ovens.mapped_oven import COARSEST, MappedOven, require_rest
from drivers.ovens.oven import Oven
from drivers.ovens.points import Points, no_status
from drivers.ovens.registers import (
    ModbusLine,
    Number,
    RateRegister,
    Register,
    RunRegister,
    RunSwitch,
    StatusRegister,
    TemperatureRegister,
    require_good_register,
)
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
    require_good_answer,
)

if TYPE_CHECKING:  # simulated ovens need numpy, which the watchdog's process does without
    from drivers.ovens.simulated.controller import Controller
    from drivers.ovens.simulated.regulated_oven import RegulatedOven


class ModbusMapOven(ModbusLine, OvenSettings):
    """Registers of a controller without a driver of its own."""

    temperature: Annotated[TemperatureRegister, Field(description="of the air, as measured")]
    set_point: Annotated[TemperatureRegister, Field(description="of the controller, at the end of a ramp")]
    working_set_point: Annotated[
        TemperatureRegister | None, Field(description="where the controller's ramp is; needed to hold it exactly")
    ] = None
    rate: Annotated[
        RateRegister | None,
        Field(description="of the controller's ramp; without it, the set-point moves in steps"),
    ] = None
    run: Annotated[RunRegister | None, Field(description="starts and stops it; this or rest_at")] = None
    rest_at: Annotated[Temperature | None, Field(description="degrees Celsius, set where nothing stops it")] = None
    status: Annotated[StatusRegister | None, Field(description="asked before each temperature")] = None
    step: Annotated[float, Field(ge=0.01, le=5.0, description="K, of a ramp in steps")] = 0.2

    @model_validator(mode="after")
    def _usable(self) -> Self:
        require_rest(self.run is not None, self.rest_at, self.limits())
        written: dict[str, Number | RunRegister | None] = {
            "set_point": self.set_point,
            "rate": self.rate,
            "run": self.run,
        }
        for name, one in written.items():
            if one is not None and one.table == "input":
                raise ValueError(f"{name}.table is 'input', which cannot be written; 'holding' allowed")
        taken = {name: _places(one) for name, one in written.items() if one is not None}
        for one_name, other in combinations(taken, 2):
            if taken[one_name] & taken[other]:
                raise ValueError(
                    f"{one_name} and {other} are both at register {min(taken[one_name] & taken[other])[1]}"
                )
        if self.set_point.resolution > COARSEST:
            raise ValueError(
                f"set_point moves in steps of {self.set_point.resolution:g} K; at most {COARSEST:g}: check scale"
            )
        for bound in ("minimum", "maximum"):
            _require_held(self.set_point, "set_point", bound, getattr(self, bound))
        if self.rate is not None:
            _require_held(self.rate, "rate", "max_rate", self.max_rate)
            if self.rate.resolution > self.max_rate:
                raise ValueError(f"rate moves in steps of {self.rate.resolution:g} K/min, above max_rate")
        return self

    def open(self, clock: Clock, transport: Transport | None = None) -> Oven:
        """Open the line."""
        unit = self.unit(clock, transport)
        try:
            order, working = self.word_order, self.working_set_point
            points = Points(
                temperature=Register("temperature", unit, self.temperature, order),
                set_point=Register("set_point", unit, self.set_point, order),
                working=Register("working_set_point", unit, working, order) if working else None,
                rate=Register("rate", unit, self.rate, order) if self.rate else None,
                run=RunSwitch(unit, self.run) if self.run else None,
                rest_at=self.rest_at,
                require_good=partial(require_good_register, unit, self.status) if self.status else no_status,
            )
            return MappedOven(unit.line, points, self.limits(), clock, self.step)
        except BaseException:
            unit.line.close()
            raise

    def rest_temperature(self, room: float) -> float:
        """Return `rest_at`, of an oven that nothing stops."""
        return room if self.rest_at is None else self.rest_at

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller":
        """Return a controller with these registers."""
        from drivers.ovens.simulated.declared_oven import simulated_modbus_map  # which reads this declaration

        return simulated_modbus_map(self, body)


def _places(one: Number | RunRegister) -> set[tuple[str, int]]:
    places = one.places if isinstance(one, Number) else range(one.at, one.at + 1)
    return {(one.table, at) for at in places}


def _require_held(register: Number, name: str, bound: str, value: float) -> None:
    try:
        register.encoded(value, "high word first")
    except ValueError as error:
        raise ValueError(f"{name} cannot hold {bound}: {error}; correct {name}.type, scale or offset") from error


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
                require_good=partial(require_good_answer, connection, self.status) if self.status else no_status,
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
        from drivers.ovens.simulated.declared_oven import SimulatedScpi  # which reads this declaration

        return SimulatedScpi(self, body)
