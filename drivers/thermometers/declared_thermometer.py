"""Thermometers whose registers or queries an experiment's file declares: kinds ``modbus-map`` and ``scpi``."""

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from drivers.clock import Clock
from drivers.ovens.error import OvenError
from drivers.ovens.line import Line, Transport
from drivers.ovens.modbus import WordOrder
from drivers.ovens.points import Value
from drivers.ovens.registers import ModbusLine, Register, TemperatureRegister
from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.declared_oven import SimulatedQueries, simulated_registers
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.ovens.text_protocol import TemperatureQuery, TextLine, TextValue
from drivers.thermometers.thermometer import Thermometer, ThermometerError, ThermometerSettings


class PointThermometer:
    """Asks one value after the other.

    Parameters
    ----------
    line : Line
        The values are on it; closed where one of them cannot be read now.
    values : sequence of Value

    Raises
    ------
    OvenError
        If a value cannot be read.
    """

    def __init__(self, line: Line, values: Sequence[Value]) -> None:
        self._line = line
        self._values = tuple(values)
        try:
            self.temperatures()
        except BaseException:
            line.close()
            raise

    def temperatures(self) -> NDArray[np.float64]:
        """Return all readings, degrees Celsius."""
        try:
            with self._line.reserved():
                return np.array([value.read() for value in self._values])
        except OvenError as error:  # said of whatever is on the line
            raise ThermometerError(error.fault, error.what, error.advice, error.code) from error

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()


class ModbusMapThermometer(ModbusLine, ThermometerSettings):
    """A transmitter with its registers, one for each sensor on the plate."""

    sensors: Annotated[
        tuple[TemperatureRegister, ...], Field(min_length=1, max_length=16, description="registers, one a sensor")
    ]

    def open(self, clock: Clock, transport: Transport | None = None) -> Thermometer:
        """Open the line, and read every register once."""
        unit = self.unit(clock, transport)
        order: WordOrder = self.word_order
        values = [Register(f"sensors[{n}]", unit, sensor, order) for n, sensor in enumerate(self.sensors)]
        return PointThermometer(unit.line, values)

    def simulated(self, body: RegulatedOven, clock: Clock) -> Controller:
        """Return a transmitter with these registers, on the plate."""
        return simulated_registers(self, self.sensors, lambda: body.plate)


class ScpiThermometer(TextLine, ThermometerSettings):
    """A meter with its queries, one for each sensor on the plate."""

    sensors: Annotated[
        tuple[TemperatureQuery, ...], Field(min_length=1, max_length=16, description="queries, one a sensor")
    ]

    def open(self, clock: Clock, transport: Transport | None = None) -> Thermometer:
        """Open the line, and send every query once."""
        connection = self.connection(clock, transport)
        values = [TextValue(f"sensors[{n}]", connection, sensor) for n, sensor in enumerate(self.sensors)]
        return PointThermometer(connection.line, values)

    def simulated(self, body: RegulatedOven, clock: Clock) -> Controller:
        """Return a meter on the plate that answers these queries."""
        return SimulatedQueries(self.terminator, self.sensors, lambda: body.plate)
