"""Simulated controllers with the registers, or the queries and commands, that an experiment's file declares."""

import math
import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from drivers.ovens.simulated.controller import READ_COIL, Controller, LineController, ModbusServer, ModbusTcp
from drivers.ovens.simulated.regulated_oven import RegulatedOven

if TYPE_CHECKING:
    from drivers.ovens.declared_oven import ModbusMapOven, ScpiOven
    from drivers.ovens.registers import ModbusLine, Number
    from drivers.ovens.text_protocol import Phrase, Query


class DeclaredOven:
    """Set-point, rate and switch of a controller without a program, and the oven that follows them.

    Parameters
    ----------
    declared : ModbusMapOven or ScpiOven
    oven : RegulatedOven

    Attributes
    ----------
    target, rate : float
        Degrees Celsius, K/min; the rate counts where one is declared, and 0 is none.
    on : bool
        Whether it regulates; a controller without a switch does from the beginning.
    """

    def __init__(self, declared: "ModbusMapOven | ScpiOven", oven: RegulatedOven) -> None:
        self._has_rate = declared.rate is not None
        self._oven = oven
        self.target = oven.working
        self.rate = 0.0
        self.on = declared.run is None
        if self.on:
            self.drive()

    @property
    def running(self) -> bool:
        """Whether it says that it regulates."""
        return self.on and self._oven.regulating

    def drive(self) -> None:
        """Have the oven follow."""
        if self.on:
            self._oven.go(self.target, self.rate or math.inf if self._has_rate else math.inf)
        else:
            self._oven.stop()


FORMATS = {"int16": ">h", "uint16": ">H", "int32": ">i", "uint32": ">I", "float32": ">f"}
CELSIUS = {"degC": (1.0, 0.0), "degF": (1.8, 32.0), "K": (1.0, 273.15)}
PER_MINUTE = {"K/min": 1.0, "K/s": 1.0 / 60.0, "K/h": 60.0, "degF/min": 1.8, "degF/h": 108.0}


def simulated_modbus_map(declared: "ModbusMapOven", oven: RegulatedOven) -> Controller:
    """Return the controller, in the envelope declared."""
    server = SimulatedModbusMap(declared, oven)
    return ModbusTcp(server) if declared.framing == "tcp" else server


def simulated_registers(
    declared: "ModbusLine", sensors: Sequence["Number"], value: Callable[[], float]
) -> Controller:
    """Return a unit that has one temperature in the registers of several sensors.

    Parameters
    ----------
    declared : ModbusLine
        Address, word order and framing.
    sensors : sequence of Number
        Each with its own place, type, scale and unit.
    value : callable
        Returns the temperature, degrees Celsius.

    Returns
    -------
    Controller
        Refuses every other register.
    """
    server = SimulatedRegisters(declared.address, declared.word_order, sensors, value)
    return ModbusTcp(server) if declared.framing == "tcp" else server


class SimulatedRegisters(ModbusServer):
    """A transmitter; parameters as of `simulated_registers`."""

    def __init__(self, address: int, order: str, sensors: Sequence["Number"], value: Callable[[], float]) -> None:
        super().__init__(address)
        self._order, self._sensors, self._value = order, tuple(sensors), value

    def read_word(self, register: int) -> int:
        """Return a holding register."""
        return self._word("holding", register)

    def read_input(self, register: int) -> int:
        """Return an input register."""
        return self._word("input", register)

    def _word(self, table: str, register: int) -> int:
        for sensor in self._sensors:
            if sensor.table == table and register in sensor.places:
                return _words(sensor, self._value(), self._order)[register - sensor.at]
        raise LookupError(register)


class SimulatedModbusMap(ModbusServer):
    """Holds set-point, rate and switch, returns temperatures, and refuses every other register.

    Scales, units and words are worked out apart from the driver, so that each checks the other.

    Parameters
    ----------
    declared : ModbusMapOven
    oven : RegulatedOven

    Attributes
    ----------
    locked : bool
        Acknowledges writes without effect.
    alarm : bool
        Its status is no good one.
    """

    def __init__(self, declared: "ModbusMapOven", oven: RegulatedOven) -> None:
        super().__init__(declared.address)
        self._declared = declared
        self._oven = oven
        self._held = DeclaredOven(declared, oven)
        self.locked = False
        self.alarm = False

    def read_word(self, register: int) -> int:
        """Return a holding register."""
        return self._word("holding", register)

    def read_input(self, register: int) -> int:
        """Return an input register."""
        return self._word("input", register)

    def read_bit(self, register: int, function: int) -> int:
        """Return the switch or the status, where it is a bit."""
        return self._single("coil" if function == READ_COIL else "discrete", register) & 1

    def write_bit(self, register: int, bit: int) -> None:
        """Switch."""
        self._switch("coil", register, bit)

    def write_words(self, register: int, words: tuple[int, ...]) -> None:
        """Store set-point or rate, or switch."""
        declared = self._declared
        for name, number in (("target", declared.set_point), ("rate", declared.rate)):
            if number is not None and register == number.at:
                if len(words) != len(number.places):
                    raise ValueError(f"{len(words)} registers for a {number.type}")
                if not self.locked:
                    setattr(self._held, name, _meaning(number, words, declared.word_order))
                    self._held.drive()
                return
        self._switch("holding", register, words[0])

    def _word(self, table: str, register: int) -> int:
        declared, oven = self._declared, self._oven
        for number, value in (
            (declared.temperature, oven.measured),
            (declared.set_point, self._held.target),
            (declared.working_set_point, oven.working),
            (declared.rate, self._held.rate),
        ):
            if number is not None and number.table == table and register in number.places:
                return _words(number, value, declared.word_order)[register - number.at]
        return self._single(table, register)

    def _single(self, table: str, register: int) -> int:
        run, status = self._declared.run, self._declared.status
        if run is not None and (run.table, run.at) == (table, register):
            return run.on if self._held.running else run.off
        if status is not None and (status.table, status.at) == (table, register):
            bad = next(one for one in range(0x10000) if one & status.mask not in status.good)
            return bad if self.alarm else status.good[0]
        raise LookupError(register)

    def _switch(self, table: str, register: int, content: int) -> None:
        run = self._declared.run
        if run is None or (run.table, run.at) != (table, register):
            raise LookupError(register)
        if content not in (run.on, run.off):
            raise ValueError(content)
        if not self.locked:
            self._held.on = content == run.on
            self._held.drive()


def _per_unit(value: "Number | Query | Phrase") -> tuple[float, float]:
    unit = getattr(value, "unit", "degC")
    return CELSIUS[unit] if unit in CELSIUS else (PER_MINUTE[unit], 0.0)


def _words(number: "Number", value: float, order: str) -> tuple[int, ...]:
    by, plus = _per_unit(number)
    content = (by * value + plus - number.offset) / number.scale
    raw = struct.pack(FORMATS[number.type], content if number.type == "float32" else round(content))
    words = struct.unpack(f">{len(raw) // 2}H", raw)
    return words if order == "high word first" else words[::-1]


def _meaning(number: "Number", words: tuple[int, ...], order: str) -> float:
    raw = struct.pack(f">{len(words)}H", *(words if order == "high word first" else words[::-1]))
    by, plus = _per_unit(number)
    content = float(struct.unpack(FORMATS[number.type], raw)[0])
    return (number.scale * content + number.offset - plus) / by


class SimulatedScpi(LineController):
    """Holds set-point, rate and switch, returns temperatures, and does not answer anything else, as SCPI requires.

    Parameters
    ----------
    declared : ScpiOven
    oven : RegulatedOven

    Attributes
    ----------
    locked : bool
        Forgets commands.
    alarm : bool
        Its status is no good one.
    """

    def __init__(self, declared: "ScpiOven", oven: RegulatedOven) -> None:
        super().__init__(declared.terminator.encode("ascii"))
        self._declared = declared
        self._oven = oven
        self._held = DeclaredOven(declared, oven)
        self.locked = False
        self.alarm = False

    def answer(self, command: str) -> str:
        """Answer a query, or take a command."""
        declared, oven, words = self._declared, self._oven, command.strip()
        for query, value in (
            (declared.temperature, oven.measured),
            (declared.set_point, self._held.target),
            (declared.working_set_point, oven.working),
            (declared.rate, self._held.rate),
        ):
            if query is not None and words == query.query:
                return _answer(query, value)
        if declared.run is not None and words == declared.run.query:
            return declared.run.is_on[0] if self._held.running else declared.run.is_off[0]
        if declared.status is not None and words == declared.status.query:
            return "TROUBLE" if self.alarm else declared.status.good[0]
        return declared.acknowledge if self._take(words) else ""

    def _take(self, words: str) -> bool:
        """Whether these words are a command; obeyed unless it is locked."""
        declared, held = self._declared, self._held
        target, rate, on = held.target, held.rate, held.on
        if declared.run is not None and words in (declared.run.on, declared.run.off):
            on = words == declared.run.on
        elif (value := _number(declared.set_point, words)) is not None:
            target = value
        elif declared.rate is not None and (value := _number(declared.rate, words)) is not None:
            rate = value
        else:
            return False
        if not self.locked:
            held.target, held.rate, held.on = target, rate, on
            held.drive()
        return True


class SimulatedQueries(LineController):
    """A meter that answers every query of `sensors` with one temperature, and nothing else.

    Parameters
    ----------
    terminator : str
    sensors : sequence of Query
    value : callable
        degrees Celsius.
    """

    def __init__(self, terminator: str, sensors: Sequence["Query"], value: Callable[[], float]) -> None:
        super().__init__(terminator.encode("ascii"))
        self._sensors, self._value = tuple(sensors), value

    def answer(self, command: str) -> str:
        """Answer a query."""
        asked = [sensor for sensor in self._sensors if sensor.query == command.strip()]
        return _answer(asked[0], self._value()) if asked else ""


def _answer(query: "Query", value: float) -> str:
    by, plus = _per_unit(query)
    number = (by * value + plus - query.offset) / query.scale
    fields = ["0"] * (query.field - 1)
    return ",".join([*fields, query.answer.replace("{value}", f"{number:.3f}")])


def _number(phrase: "Phrase", words: str) -> float | None:
    """Return what a command sets, degrees Celsius or K/min; None for any other command."""
    before, after = phrase.command.split("{value}")
    if not (words.startswith(before) and words.endswith(after)):
        return None
    try:
        number = float(words[len(before) : len(words) - len(after)])
    except ValueError:
        return None
    by, plus = _per_unit(phrase)
    return (phrase.scale * number + phrase.offset - plus) / by
