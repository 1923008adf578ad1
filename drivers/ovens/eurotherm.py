"""Eurotherm 2400 and 3500: scaled integers, and floats of the same registers at 0x8000 + 2 x address.

Register numbers: Eurotherm 2000 series communications handbook, and those of the 3500.
"""

import math
from dataclasses import dataclass

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import OvenLimits, SetPoint

AUTOMATIC, MANUAL = 0, 1


@dataclass(frozen=True)
class Registers:
    """Where a model keeps what the driver needs; None for what it does not have."""

    temperature: int
    target: int = 2
    output: int = 3
    working_set_point: int = 5
    rate: int = 35
    mode: int = 273
    rate_disable: int | None = None
    sensor_break: int | None = None
    alarms: int | None = None


MODEL_2400 = Registers(temperature=1, sensor_break=258)
MODEL_3500 = Registers(temperature=289, rate_disable=78, alarms=10213)


class Eurotherm:
    """A Eurotherm that ramps its own working set-point.

    Target and rate are written once per ramp, and only where they differ from what the instrument
    holds. The rate goes through the float registers, whose scale cannot be mistaken: an integer rate
    of 4 is 0.4 K/min on one instrument and 4 K/min on the next.

    Safe state: manual, output 0 %.

    Parameters
    ----------
    unit : ModbusUnit
    limits : OvenLimits
    registers : Registers
    decimals : int
        Of the temperatures, as configured in the instrument.

    Raises
    ------
    OvenError
        Of kind refused, if the instrument's own float shows that `decimals` is wrong.
    """

    poll_within = math.inf

    def __init__(
        self, unit: ModbusUnit, limits: OvenLimits, registers: Registers = MODEL_2400, decimals: int = 1
    ) -> None:
        self.limits = limits
        self._unit = unit
        self._at = registers
        self._decimals = decimals
        self._check_decimals()

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if the sensor is broken or an alarm stands."""
        with self._unit.line.reserved():
            if self._at.sensor_break is not None and self._unit.read(self._at.sensor_break):
                raise OvenError(
                    Fault.ALARM, "the controller reports a broken sensor", "Check thermocouple and wiring.", "Sbr"
                )
            if self._at.alarms is not None and (alarms := int(self._unit.read(self._at.alarms, signed=False))):
                raise OvenError(
                    Fault.ALARM,
                    f"alarms stand on the controller (summary {alarms:#06x})",
                    "Read them on its front panel, remove their cause and acknowledge them there.",
                    f"{alarms:#06x}",
                )
            return self._unit.read(self._at.temperature, self._decimals)

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Set rate, then target, then automatic: the working set-point never sees a target without its rate."""
        wanted = self.limits.clamp(target, rate)
        with self._unit.line.reserved():
            # half of the coarsest step a rate is displayed with, but never so much that zero would pass:
            # to these instruments a rate of zero means no ramp at all
            tolerance = min(0.051, 0.25 * wanted.rate)
            taken_rate = self._unit.put_float(
                _as_float(self._at.rate), wanted.rate, tolerance, name="set-point rate"
            )
            if self._at.rate_disable is not None:
                self._unit.put(self._at.rate_disable, 0, name="set-point rate disable")
            taken = self._unit.put(self._at.target, wanted.target, self._decimals, name="target set-point")
            self._unit.put(self._at.mode, AUTOMATIC, name="auto/manual")
        return SetPoint(taken, taken_rate)

    def hold(self) -> float:
        """Make the working set-point, where the ramp is now, the target."""
        with self._unit.line.reserved():
            # in manual, not every model's working set-point follows the temperature
            resting = self._unit.read(self._at.mode) != AUTOMATIC
            here = self._unit.read(self._at.temperature if resting else self._at.working_set_point, self._decimals)
            held = self._unit.put(
                self._at.target, self.limits.clamp_target(here), self._decimals, name="target set-point"
            )
            self._unit.put(self._at.mode, AUTOMATIC, name="auto/manual")
            return held

    def safe(self) -> None:
        """Manual with no output."""
        with self._unit.line.reserved():
            self._unit.put(self._at.mode, MANUAL, name="auto/manual")
            self._unit.put(self._at.output, 0, name="output")

    def close(self) -> None:
        """Let go of the line."""
        self._unit.line.close()

    def _check_decimals(self) -> None:
        scaled = self._unit.read(self._at.temperature, self._decimals)
        exact = self._unit.read_float(_as_float(self._at.temperature))
        if abs(scaled - exact) > 1.0 + 0.1 * abs(exact):
            raise OvenError(
                Fault.REFUSED,
                f"with decimals = {self._decimals} the integer temperature is {scaled:g} °C, "
                f"but the instrument's float says {exact:g} °C",
                "Set decimals to the digits after the point on the instrument's display (0, 1 or 2).",
            )


def _as_float(register: int) -> int:
    return 0x8000 + 2 * register
