"""The controllers of four makers as kinds of oven: their settings, their drivers, their simulated counterparts."""

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from drivers.clock import Clock
from drivers.ovens.espec import Espec
from drivers.ovens.eurotherm import MODEL_2400, MODEL_3500, Eurotherm, EurothermProgram, Registers
from drivers.ovens.expiry import LONGEST, SHORTEST
from drivers.ovens.f4t import F4T, F4TProfile
from drivers.ovens.line import Line, Transport
from drivers.ovens.line_settings import LineSettings
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import Oven
from drivers.ovens.settings import OvenSettings
from drivers.ovens.votsch import Votsch

if TYPE_CHECKING:  # simulated ovens need numpy, which the watchdog's process does without
    from drivers.ovens.simulated.controller import Controller
    from drivers.ovens.simulated.regulated_oven import RegulatedOven


class ControllerSettings(LineSettings, OvenSettings):
    """An oven whose controller is on a line: `on_line` returns its driver."""

    address: Annotated[int, Field(ge=1, le=247, description="Modbus unit, or ASCII-2 address")] = 1
    decimals: Annotated[
        int, Field(ge=0, le=2, description="digits after the point on a Eurotherm's display; others ignore it")
    ] = 1

    def open(self, clock: Clock, transport: Transport | None = None) -> Oven:
        """Open the line and the driver on it."""
        line = self.line(clock, transport)
        try:
            return self.on_line(line)
        except BaseException:
            line.close()
            raise

    def on_line(self, line: Line) -> Oven:
        """Return the driver, after a first exchange."""
        raise NotImplementedError


class ExpiringSettings(ControllerSettings):
    """A controller that can bring the oven to rest by itself if the program ends or loses it."""

    rest_after: Annotated[
        float,
        Field(
            ge=0.0,
            le=LONGEST,
            description="s that the controller continues without a connection to the program; 0: without limit",
        ),
    ] = 1800.0

    @model_validator(mode="after")
    def _lasting(self) -> Self:
        if 0.0 < self.rest_after < SHORTEST:
            raise ValueError(f"rest_after {self.rest_after:g} s: 0 (never) or {SHORTEST:g} to {LONGEST:g} allowed")
        return self

    @property
    def expires(self) -> bool:
        """Whether it does."""
        return self.rest_after > 0.0


class ProgrammedSettings(ExpiringSettings):
    """A controller that needs one of its programs for it."""

    programs: ClassVar[int]
    """How many it has."""

    program: Annotated[
        int | None, Field(ge=1, description="program of the controller that is overwritten with every ramp")
    ] = None

    @model_validator(mode="after")
    def _has_program(self) -> Self:
        if self.program is not None and self.program > self.programs:
            raise ValueError(f"program {self.program} of a {self.kind}: 1 to {self.programs} allowed")
        return self

    @property
    def expires(self) -> bool:
        """Whether it does."""
        return self.rest_after > 0.0 and self.program is not None


class EurothermSettings(ProgrammedSettings):
    """Eurotherm 2400 and 3500."""

    programs: ClassVar[int] = 20

    kind: Annotated[Literal["eurotherm-2400", "eurotherm-3500"], Field(description="the series on its label")]

    @model_validator(mode="after")
    def _known_programs(self) -> Self:
        if self.program is not None and self.kind == "eurotherm-3500":
            raise ValueError("program of a eurotherm-3500: none can be written, no map of them is published")
        return self

    @property
    def _registers(self) -> Registers:
        return MODEL_2400 if self.kind == "eurotherm-2400" else MODEL_3500

    def on_line(self, line: Line) -> Oven:
        """Return the driver."""
        unit, program = ModbusUnit(line, self.address), None
        if self.program is not None and self.expires:
            program = EurothermProgram(unit, self.program, self.rest_after, self.decimals)
        return Eurotherm(unit, self.limits(), self._registers, self.decimals, program)

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller":
        """Return its simulated counterpart."""
        from drivers.ovens.simulated.eurotherm import SimulatedEurotherm

        return SimulatedEurotherm(body, self._registers, self.address, self.decimals)


class VotschSettings(ControllerSettings):
    """Vötsch and Weiss chambers over ASCII-2."""

    gaps: ClassVar[tuple[float, float]] = (0.1, 1.0)

    @model_validator(mode="after")
    def _addressed(self) -> Self:
        if self.address > 32:
            raise ValueError(f"address {self.address}: ASCII-2 allows 1 to 32")
        return self

    def on_line(self, line: Line) -> Oven:
        """Return the driver."""
        return Votsch(line, self.address, self.limits())

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller":
        """Return its simulated counterpart."""
        from drivers.ovens.simulated.votsch import SimulatedVotsch

        return SimulatedVotsch(body, self.address)


class EspecSettings(ExpiringSettings):
    """Espec chambers with a P-300 or SCP-220."""

    gaps: ClassVar[tuple[float, float]] = (0.3, 1.0)

    def on_line(self, line: Line) -> Oven:
        """Return the driver."""
        return Espec(line, self.limits(), self.rest_after)

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller":
        """Return its simulated counterpart."""
        from drivers.ovens.simulated.espec import SimulatedEspec

        return SimulatedEspec(body, clock)


class WatlowSettings(ProgrammedSettings):
    """Watlow F4T."""

    programs: ClassVar[int] = 40

    def on_line(self, line: Line) -> Oven:
        """Return the driver."""
        unit, profile = ModbusUnit(line, self.address, "low word first"), None
        if self.program is not None and self.expires:
            profile = F4TProfile(unit, self.program, self.rest_after)
        return F4T(unit, self.limits(), profile)

    def simulated(self, body: "RegulatedOven", clock: Clock) -> "Controller":
        """Return its simulated counterpart."""
        from drivers.ovens.simulated.f4t import SimulatedF4T

        return SimulatedF4T(body, self.address)
