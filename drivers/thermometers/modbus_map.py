"""Kind ``modbus-map``: a thermometer whose Modbus registers stand in the experiment's file."""

from typing import Annotated

from pydantic import Field

from drivers.clock import Clock
from drivers.ovens.line import Transport
from drivers.ovens.modbus import WordOrder
from drivers.ovens.registers import ModbusLine, Register, TemperatureRegister
from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.modbus_map import simulated_registers
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.thermometers.points import PointThermometer
from drivers.thermometers.settings import ThermometerSettings
from drivers.thermometers.thermometer import Thermometer


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
