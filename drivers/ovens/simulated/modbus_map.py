"""A simulated controller with the registers that an experiment's file declares."""

import struct
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.declared_oven import DeclaredOven
from drivers.ovens.simulated.modbus_server import READ_COIL, ModbusServer, ModbusTcp
from drivers.ovens.simulated.regulated_oven import RegulatedOven

if TYPE_CHECKING:
    from drivers.ovens.modbus_map import ModbusMapOven
    from drivers.ovens.registers import ModbusLine, Number

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


def _per_unit(number: "Number") -> tuple[float, float]:
    unit = getattr(number, "unit", "degC")
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
