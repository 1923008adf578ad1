"""Ovens of which only declared points are known, their registers or commands: ``modbus-map`` and ``scpi``."""

import logging
import math
from collections.abc import Callable
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Temperature
from drivers.clock import Clock, Stop
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import PASSING, Line, Transport
from drivers.ovens.oven import Oven, OvenLimits, SetPoint, other_set_point
from drivers.ovens.points import PLAUSIBLE, Points, no_status
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

if TYPE_CHECKING:
    from drivers.ovens.simulated.controller import Controller
    from drivers.ovens.simulated.regulated_oven import RegulatedOven

PERIOD = 1.0
"""Between two looks at whether a ramp in steps is due for its next, s."""
LAG = 5.0
"""The air may be so far from the set-point of an oven that follows its ramp, K."""
COARSEST = 1.0
"""A set-point in coarser steps is of no use here, K."""
log = logging.getLogger(__name__)


class MappedOven:
    """Ramps by the controller where that has a rate, in steps of the set-point where it has none.

    The steps are made by a thread of this program: where that dies, the oven stays at the last of them. Safe
    state: switched off, or, of a controller that cannot be, the set-point `Points.rest_at`.

    Parameters
    ----------
    line : Line
        The points are on it.
    points : Points
    limits : OvenLimits
    clock : Clock
        Carries the steps.
    step : float
        Of a ramp in steps, K: many controllers keep their set-point in a memory that wears out.
    """

    poll_within = math.inf

    def __init__(self, line: Line, points: Points, limits: OvenLimits, clock: Clock, step: float) -> None:
        self.limits = limits
        self._line = line
        self._points = points
        self._clock = clock
        self._step = step
        self._usable = self._commanded = False
        self._ramp: tuple[float, float, float, float] | None = None
        self._failed: OvenError | None = None
        self._told: float | None = None
        self._stop_stepping: Stop = lambda: None

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; OvenError for an alarm, or for a fault of the last step.

        The first time, of kind refused where it is none, or another point cannot be read.
        """
        points = self._points
        with self._line.reserved():
            if self._failed is not None:
                raise self._failed
            points.require_good()
            value = points.temperature.read()
            if self._commanded and points.run is not None and not (points.run.on() or points.run.on()):
                raise OvenError(
                    Fault.ALARM,
                    f"the oven has stopped by itself at {value:g} °C",
                    "Was it stopped on its panel, or by its limiter? Look at it, then start the ramp again.",
                )
        if not math.isfinite(value):
            raise OvenError(
                Fault.ALARM,
                f"the controller has no valid temperature ({value})",
                "Check the sensor and its wiring.",
            )
        if not self._usable:
            self._require_declared(value)
            self._usable = True
        return value

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Let the controller ramp, or begin to step.

        Raises
        ------
        ValueError
            For a rate that is less than the controller's smallest.
        """
        wanted = self.limits.clamp(target, rate)
        self._require_usable()
        points = self._points
        with self._line.reserved():
            self._end_steps()
            if points.rate is None:
                return self._begin_steps(wanted)
            if wanted.rate < points.rate.resolution:
                raise ValueError(
                    f"rate {rate:g} K/min: this controller's rate has steps of {points.rate.resolution:g} K/min"
                )
            taken_rate = points.rate.put(wanted.rate)
            taken = points.set_point.put(wanted.target)
            self._switch_on()
            self._told = taken
        return SetPoint(taken, taken_rate)

    def hold(self) -> float:
        """Make the set-point where the ramp is; the measured temperature if the controller does not report it."""
        self._require_usable()
        points = self._points
        with self._line.reserved():
            stepped = self._working()
            self._end_steps()
            if stepped is not None:
                here = stepped
            elif points.working is not None and self._running():
                here = points.working.read()
            else:
                here = points.temperature.read()
            held = points.set_point.put(self.limits.clamp_target(here))
            self._switch_on()
            self._told = held
            return held

    def changed(self) -> str:
        """Say whether the set-point is another than the one written last."""
        with self._line.reserved():
            return "" if self._told is None else other_set_point(self._told, self._points.set_point.read())

    def safe(self) -> None:
        """Switch off; or go to `rest_at`."""
        points = self._points
        with self._line.reserved():
            self._told = None
            self._end_steps()
            self._commanded = False
            commands: list[Callable[[], None]] = []
            if points.run is not None:
                commands.append(partial(points.run.send, False))
            if points.rest_at is not None:
                commands.append(partial(points.set_point.send, points.rest_at))
            self._line.blind(*commands)
            if points.run is not None:
                points.run.put(False)
            if points.rest_at is not None:
                points.set_point.put(points.rest_at)

    def close(self) -> None:
        """Step no more, and let go of the line."""
        self._end_steps()
        self._line.close()

    def _switch_on(self) -> None:
        if self._points.run is not None:
            self._points.run.put(True)
        self._commanded = True

    def _running(self) -> bool:
        return self._commanded if self._points.run is None else self._points.run.on()

    def _begin_steps(self, wanted: SetPoint) -> SetPoint:
        """Start where the oven is: at its temperature, or, while it regulates, at a set-point near that."""
        points = self._points
        start = air = points.temperature.read()
        if self._running():
            start = min(max(points.set_point.read(), air - LAG), air + LAG)
        start = self.limits.clamp_target(start)
        self._told = points.set_point.put(start)
        self._switch_on()
        self._ramp = (self._clock.now(), start, wanted.target, wanted.rate / 60.0)
        self._written = start
        self._stop_stepping = self._clock.every(PERIOD, self._look)
        return wanted

    def _working(self) -> float | None:
        """Return where a ramp in steps ought to be now, degrees Celsius; None where none is under way."""
        if self._ramp is None:
            return None
        begun, start, target, rate = self._ramp
        moved = rate * (self._clock.now() - begun)
        return min(start + moved, target) if target >= start else max(start - moved, target)

    def _look(self) -> None:
        """Make the next step where it is due; one that the line lost is due again at the next look."""
        try:
            with self._line.reserved():
                due = self._working()
                if due is None or self._ramp is None:
                    return
                end = due == self._ramp[2]
                if abs(due - self._written) >= self._step or end:
                    self._told = self._points.set_point.put(due)
                    self._written = due
                if end:
                    self._end_steps()
        except OvenError as error:
            log.debug("a step of the oven's ramp failed: %s", error)
            if error.fault not in {*PASSING, Fault.LOST}:  # the next temperature reading reports these
                self._end_steps()
                self._failed = error

    def _end_steps(self) -> None:
        self._stop_stepping()
        self._ramp = self._failed = None

    def _require_usable(self) -> None:
        """Before the first command, not on opening: an oven in alarm can be opened and brought to rest."""
        if not self._usable:
            self.temperature()

    def _require_declared(self, value: float) -> None:
        points, (low, high) = self._points, PLAUSIBLE
        with self._line.reserved():
            for point in (points.set_point, points.working, points.rate):
                if point is not None:
                    point.read()
            if points.run is not None:
                points.run.on()
        if not low <= value <= high:
            raise OvenError(
                Fault.REFUSED,
                f"the temperature reads {value:g} °C; {low:g} to {high:g} °C can be true",
                "Correct what the experiment declares of it: place, type, scale, offset, unit, order of words.",
            )


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


def require_rest(switch: bool, rest_at: float | None, limits: OvenLimits) -> None:
    """Raise unless a declaration says, in one way, how the oven comes to rest.

    Parameters
    ----------
    switch : bool
        Whether a register or command that switches the oven off is declared.
    rest_at : float or None
        Temperature at which the oven is left instead, degrees Celsius.

    Raises
    ------
    ValueError
        If both or neither is declared, or `rest_at` lies outside the limits.
    """
    if switch == (rest_at is not None):
        raise ValueError(
            f"{'both run and rest_at' if switch else 'neither run nor rest_at'} declared to bring it to rest; "
            "declare run (how it is switched off) or, for a controller that cannot be, rest_at (a temperature)"
        )
    if rest_at is not None and not limits.minimum <= rest_at <= limits.maximum:
        raise ValueError(
            f"rest_at {rest_at:g} °C; minimum to maximum allowed, {limits.minimum:g} to {limits.maximum:g}"
        )
