"""The ``[oven]`` of a rig file, and the oven made from it."""

import re
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from analysis.declared import Declared
from analysis.experiment import Temperature
from drivers.clock import Clock, SystemClock
from drivers.ovens.espec import Espec
from drivers.ovens.eurotherm import MODEL_2400, MODEL_3500, Eurotherm
from drivers.ovens.eurotherm_program import EurothermProgram
from drivers.ovens.expiry import LONGEST, SHORTEST
from drivers.ovens.f4t import F4T
from drivers.ovens.f4t_profile import F4TProfile
from drivers.ovens.line import Line, Timing, Transport
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import Oven, OvenLimits
from drivers.ovens.serial_port import SerialPort
from drivers.ovens.votsch import Votsch

Kind = Literal["eurotherm-2400", "eurotherm-3500", "votsch-ascii2", "espec-p300", "watlow-f4t"]

GAPS: dict[Kind, tuple[float, float]] = {
    "eurotherm-2400": (0.02, 0.1),
    "eurotherm-3500": (0.02, 0.1),
    "votsch-ascii2": (0.1, 1.0),
    "espec-p300": (0.3, 1.0),
    "watlow-f4t": (0.02, 0.1),
}
"""Seconds of silence each kind wants after a question and after a command."""

PROGRAMS: dict[Kind, int] = {"eurotherm-2400": 20, "watlow-f4t": 40}
"""How many programs a kind has that can be written through its line, and that end with the oven at rest."""

_GATEWAY = re.compile(r"socket://(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9.-]+):[0-9]{1,5}")
"""Others of pyserial's addresses write files (spy://), or take options that do."""


class OvenSettings(Declared):
    """How to reach an oven and what it may be asked for."""

    kind: Annotated[Kind, Field(description="maker and protocol of the controller")]
    port: Annotated[
        str,
        Field(min_length=1, description="serial port (COM3, /dev/ttyUSB0) or socket://host:port of a gateway"),
    ]
    address: Annotated[int, Field(ge=1, le=247, description="Modbus unit, or ASCII-2 address")] = 1
    baud_rate: Annotated[int, Field(ge=300, le=921_600, description="bit/s")] = 9600
    parity: Annotated[Literal["N", "E", "O"], Field(description="none, even or odd")] = "N"
    stop_bits: Annotated[Literal[1, 2], Field(description="per character")] = 1
    decimals: Annotated[
        int, Field(ge=0, le=2, description="digits after the point on a Eurotherm's display; others ignore it")
    ] = 1
    minimum: Annotated[Temperature, Field(description="degrees Celsius, lowest set-point sent")]
    maximum: Annotated[Temperature, Field(description="degrees Celsius, highest set-point sent")]
    max_rate: Annotated[float, Field(gt=0.0, le=60.0, description="K/min, steepest ramp sent")]
    timeout: Annotated[float, Field(ge=0.02, le=30.0, description="s, for one whole answer")] = 1.0
    retries: Annotated[int, Field(ge=0, le=10, description="further attempts after a failed one")] = 2
    gap_after_read: Annotated[
        float | None,
        Field(ge=0.0, le=10.0, description="s of silence after a question; unset: what the kind wants"),
    ] = None
    gap_after_write: Annotated[
        float | None,
        Field(ge=0.0, le=10.0, description="s of silence after a command; unset: what the kind wants"),
    ] = None
    lost_after: Annotated[
        float,
        Field(ge=1.0, le=3600.0, description="s without a usable answer after which the oven counts as lost"),
    ] = 60.0
    rest_after: Annotated[
        float,
        Field(
            ge=0.0,
            le=LONGEST,
            description="s that the controller goes on by itself after its ramp once nobody watches it any more, "
            "0 for ever; Eurotherm 2400 and Watlow F4T need a program for it",
        ),
    ] = 1800.0
    program: Annotated[
        int | None,
        Field(ge=1, le=40, description="program of the controller that is overwritten with every ramp"),
    ] = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        self.limits()
        self.timing()
        if "://" in self.port and not _GATEWAY.fullmatch(self.port):
            raise ValueError(
                f"port {self.port!r}: a serial port's name (COM3, /dev/ttyUSB0) or socket://HOST:PORT allowed, "
                "and no other address"
            )
        if 0.0 < self.rest_after < SHORTEST:
            raise ValueError(f"rest_after {self.rest_after:g} s: 0 (never) or {SHORTEST:g} to {LONGEST:g} allowed")
        if self.program is not None and self.program > PROGRAMS.get(self.kind, 0):
            allowed = ", ".join(f"1 to {most} of {kind}" for kind, most in PROGRAMS.items())
            raise ValueError(f"program {self.program} of a {self.kind}: {allowed} can be written")
        if self.kind == "votsch-ascii2" and self.address > 32:
            raise ValueError(f"address {self.address}: ASCII-2 allows 1 to 32")
        return self

    @property
    def expires(self) -> bool:
        """Whether the oven comes to rest by itself once nobody watches it any more."""
        return self.rest_after > 0.0 and (self.kind == "espec-p300" or self.program is not None)

    def limits(self) -> OvenLimits:
        """Return what set-points are clamped to."""
        return OvenLimits(self.minimum, self.maximum, self.max_rate)

    def timing(self) -> Timing:
        """Return how patient the line is."""
        after_read, after_write = GAPS[self.kind]
        return Timing(
            timeout=self.timeout,
            retries=self.retries,
            gap_after_read=after_read if self.gap_after_read is None else self.gap_after_read,
            gap_after_write=after_write if self.gap_after_write is None else self.gap_after_write,
            lost_after=self.lost_after,
        )


def open_oven(settings: OvenSettings, clock: Clock | None = None, transport: Transport | None = None) -> Oven:
    """Return the oven that `settings` describe, after a first exchange with it.

    Parameters
    ----------
    settings : OvenSettings
    clock : Clock, optional
        The machine's own by default.
    transport : Transport, optional
        Instead of the port named in the settings: a simulated controller in memory, say.

    Raises
    ------
    OvenError
        If the port cannot be opened or the controller does not answer as its kind should.
    """
    clock = clock or SystemClock()
    transport = transport or SerialPort(settings.port, settings.baud_rate, settings.parity, settings.stop_bits)
    line = Line(transport, clock, settings.timing())
    try:
        return _oven(settings, line)
    except BaseException:
        line.close()
        raise


def _oven(settings: OvenSettings, line: Line) -> Oven:
    limits, after = settings.limits(), settings.rest_after
    number = settings.program if settings.expires else None
    match settings.kind:
        case "eurotherm-2400" | "eurotherm-3500":
            registers = MODEL_2400 if settings.kind == "eurotherm-2400" else MODEL_3500
            unit = ModbusUnit(line, settings.address)
            program = EurothermProgram(unit, number, after, settings.decimals) if number else None
            return Eurotherm(unit, limits, registers, settings.decimals, program)
        case "votsch-ascii2":
            return Votsch(line, settings.address, limits)
        case "espec-p300":
            return Espec(line, limits, after)
        case "watlow-f4t":
            unit = ModbusUnit(line, settings.address, "low word first")
            return F4T(unit, limits, F4TProfile(unit, number, after) if number else None)
