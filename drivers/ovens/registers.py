"""Modbus registers as an experiment's file declares them: what they mean, and how they are read and set."""

import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from analysis.declaration.strict import Declared
from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Transport
from drivers.ovens.line_settings import LineSettings
from drivers.ovens.modbus import Framing, ModbusUnit, WordOrder
from drivers.ovens.points import RateUnit, TemperatureUnit, factors, not_taken

T = TypeVar("T")

Address = Annotated[
    int, Field(ge=0, le=65_535, description="register as sent on the line: 40001 or 30001 of a manual is 0")
]

TYPES = {"int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "float32": "f"}
FUNCTIONS = {"coil": 1, "discrete": 2, "holding": 3, "input": 4}
FLOAT_RESOLUTION = 1e-3
"""Of a 32-bit float, in the register's unit: beyond what a controller keeps of one."""
ROUNDED = 0.051
"""By so much a float may read back different, K or K/min: controllers round to the digit they display."""


class Number(Declared):
    """A number in one register or in two: value in `unit` = scale x content + offset."""

    at: Address
    table: Annotated[Literal["holding", "input"], Field(description="kind of register")] = "holding"
    type: Annotated[
        Literal["int16", "uint16", "int32", "uint32", "float32"], Field(description="those of 32 bits take two")
    ] = "int16"
    scale: Annotated[float, Field(ge=1e-6, le=1e6, description="unit per count: 0.1 where 235 means 23.5")] = 1.0
    offset: Annotated[float, Field(ge=-1e6, le=1e6, description="added after scaling, in the unit")] = 0.0

    @property
    def places(self) -> range:
        """The registers it takes."""
        return range(self.at, self.at + (1 if self.type.endswith("16") else 2))

    def slope(self) -> tuple[float, float]:
        """Return slope and intercept from the register's content to degrees Celsius, or to K/min."""
        by, plus = factors(getattr(self, "unit"))  # noqa: B009 (the two kinds below have different ones)
        return by * self.scale, by * self.offset + plus

    @property
    def resolution(self) -> float:
        """Smallest difference it can hold, K or K/min."""
        return self.slope()[0] * (FLOAT_RESOLUTION if self.type == "float32" else 1.0)

    def decoded(self, words: tuple[int, ...], order: WordOrder) -> float:
        """Return what registers mean, degrees Celsius or K/min."""
        raw = struct.pack(f">{len(words)}H", *(words if order == "high word first" else words[::-1]))
        content: float = struct.unpack(f">{TYPES[self.type]}", raw)[0]
        slope, intercept = self.slope()
        return slope * content + intercept

    def encoded(self, value: float, order: WordOrder) -> tuple[int, ...]:
        """Return the registers that mean `value`; ValueError where its type cannot hold it."""
        slope, intercept = self.slope()
        content = (value - intercept) / slope
        try:
            raw = struct.pack(f">{TYPES[self.type]}", content if self.type == "float32" else round(content))
        except (struct.error, OverflowError) as error:
            raise ValueError(f"{value:g} is {content:g} counts, which {self.type} cannot hold") from error
        words = struct.unpack(f">{len(raw) // 2}H", raw)
        return words if order == "high word first" else words[::-1]


class TemperatureRegister(Number):
    """A temperature."""

    unit: Annotated[TemperatureUnit, Field(description="of the controller")] = "degC"


class RateRegister(Number):
    """A rate."""

    unit: Annotated[RateUnit, Field(description="in which the controller takes it")] = "K/min"


class RunRegister(Declared):
    """A register or coil that starts and stops the controller."""

    at: Address
    table: Annotated[Literal["holding", "coil"], Field(description="kind of register")] = "holding"
    on: Annotated[int, Field(ge=0, le=65_535, description="content while it regulates")] = 1
    off: Annotated[int, Field(ge=0, le=65_535, description="content while it does not")] = 0


class StatusRegister(Declared):
    """A register or bit that signals an alarm."""

    at: Address
    table: Annotated[Literal["holding", "input", "coil", "discrete"], Field(description="kind of register")] = (
        "holding"
    )
    mask: Annotated[int, Field(ge=1, le=65_535, description="bits that count")] = 0xFFFF
    good: Annotated[tuple[int, ...], Field(min_length=1, description="contents, masked, without an alarm")] = (0,)


class ModbusLine(LineSettings):
    """A unit on a Modbus line."""

    address: Annotated[int, Field(ge=1, le=247, description="unit on the line")] = 1
    framing: Annotated[Framing, Field(description="rtu: serial line, gateway; tcp: Modbus TCP")] = "rtu"
    word_order: Annotated[WordOrder, Field(description="of numbers of 32 bits")] = "high word first"

    def unit(self, clock: Clock, transport: Transport | None) -> ModbusUnit:
        """Open the line."""
        line = self.line(clock, transport)
        return ModbusUnit(line, self.address, self.word_order, self.framing)


@dataclass(frozen=True)
class Register:
    """A declared number of a unit, read and set.

    Attributes
    ----------
    name : str
        For messages: the key it is declared under.
    """

    name: str
    unit: ModbusUnit
    declared: Number
    order: WordOrder

    @property
    def resolution(self) -> float:
        """Smallest difference it can hold, K or K/min."""
        return self.declared.resolution

    def read(self) -> float:
        """Ask for it."""
        places = self.declared.places
        words = _named(
            self.name,
            lambda: self.unit.read_words(places.start, len(places), FUNCTIONS[self.declared.table]),
        )
        return float(f"{self.declared.decoded(words, self.order):.7g}")

    def send(self, value: float) -> None:
        """Write it."""
        words = self.declared.encoded(value, self.order)
        _named(self.name, lambda: self.unit.write_words(self.declared.at, words))

    def put(self, value: float) -> float:
        """Make it hold `value`: written where it does not yet, and read back."""
        tolerance = 0.5001 * self.resolution + 1e-6 * abs(value)
        rounded = ROUNDED if self.declared.type == "float32" else 0.0
        if isinstance(self.declared, RateRegister):
            rounded = min(rounded, 0.25 * abs(value))  # a rate of 0 may mean no ramp at all
        with self.unit.line.reserved():
            held = self.read()
            if not abs(held - value) <= tolerance:
                self.send(value)
                held = self.read()
        if not abs(held - value) <= max(tolerance, rounded):
            raise not_taken(f"{self.name} (register {self.declared.at})", f"{value:g}", f"{held:g}")
        return held


@dataclass(frozen=True)
class RunSwitch:
    """The declared switch of a unit."""

    unit: ModbusUnit
    declared: RunRegister

    def on(self) -> bool:
        """Ask whether it is on, or in a third state: only `off` is known to be at rest."""
        return read_content(self.unit, "run", self.declared.at, self.declared.table) != self.declared.off

    def send(self, on: bool) -> None:
        """Write its register or coil."""
        wanted, at = self.declared.on if on else self.declared.off, self.declared.at
        if self.declared.table == "coil":
            _named("run", lambda: self.unit.write_bit(at, wanted))
        else:
            _named("run", lambda: self.unit.write_words(at, (wanted,)))

    def put(self, on: bool) -> None:
        """Switch, and read back."""
        wanted = self.declared.on if on else self.declared.off
        at, table = self.declared.at, self.declared.table
        with self.unit.line.reserved():
            if read_content(self.unit, "run", at, table) == wanted:
                return
            self.send(on)
            held = read_content(self.unit, "run", at, table)
        if held != wanted:
            raise not_taken(f"run (register {at})", str(wanted), str(held))


def read_content(unit: ModbusUnit, name: str, at: int, table: str) -> int:
    """Return a register or bit as it is.

    Parameters
    ----------
    name : str
        The declared key, for messages.
    at : int
        Its address.
    table : str
        ``coil``, ``discrete``, ``holding`` or ``input``.

    Returns
    -------
    int
        0 or 1 of a bit, 0 to 65535 of a register.
    """
    function = FUNCTIONS[table]
    if function <= 2:
        return _named(name, lambda: unit.read_bit(at, function))
    return _named(name, lambda: unit.read_words(at, 1, function))[0]


def require_good_register(unit: ModbusUnit, declared: StatusRegister) -> None:
    """Raise OvenError of kind alarm unless the status is a good one."""
    held = read_content(unit, "status", declared.at, declared.table)
    if held & declared.mask not in declared.good:
        raise OvenError(
            Fault.ALARM,
            f"status (register {declared.at}) reads {held:#06x}, masked {held & declared.mask:#06x}; "
            f"good: {', '.join(f'{good:#06x}' for good in declared.good)}",
            "Look at the controller's panel, remove the cause and acknowledge it there.",
            f"{held:#06x}",
        )


def _named(name: str, action: Callable[[], T]) -> T:
    """Say which declared key a controller refuses."""
    try:
        return action()
    except OvenError as error:
        if error.fault is not Fault.REFUSED:
            raise
        advice = f"Correct {name} in the experiment's file: at, table and type; or the value is beyond its limits."
        raise OvenError(error.fault, f"{name}: {error.what}", advice, error.code) from error
