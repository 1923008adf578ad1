"""Watlow F4T, control loop 1: floats over two registers, low word first (data map 1).

Registers: Watlow F4T user's guide, and the ramp registers of chambers built around it. The
controller's communication units must be set to degrees Celsius.
"""

import math

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import OvenLimits, SetPoint

MODE, LOW_LIMIT, HIGH_LIMIT, SET_POINT = 2730, 2774, 2776, 2782
RAMP_ACTION, RAMP_SCALE, RAMP_RATE = 2794, 2796, 2798
WORKING_SET_POINT, TEMPERATURE = 2810, 2820

OFF, AUTO = 62, 10
RAMP_ON_SET_POINT, PER_MINUTE = 85, 57


class F4T:
    """A Watlow F4T whose loop ramps to a new set-point by itself. Safe state: control mode off.

    Parameters
    ----------
    unit : ModbusUnit
        With low word first.
    limits : OvenLimits

    Raises
    ------
    OvenError
        Of kind refused, if the controller's own set-point limits leave nothing of `limits`.
    """

    poll_within = math.inf

    def __init__(self, unit: ModbusUnit, limits: OvenLimits) -> None:
        self.limits = limits
        self._unit = unit
        low, high = unit.read_float(LOW_LIMIT), unit.read_float(HIGH_LIMIT)
        if not (low < limits.maximum and limits.minimum < high):
            raise OvenError(
                Fault.REFUSED,
                f"the controller's set-points end at {low:g} and {high:g} °C, "
                f"the limits asked for at {limits.minimum:g} and {limits.maximum:g} °C",
                "Correct minimum and maximum, or the controller's; are its communication units °C?",
            )

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if the controller has no valid one."""
        value = self._unit.read_float(TEMPERATURE)
        if not math.isfinite(value):
            raise OvenError(
                Fault.ALARM,
                f"the controller has no valid temperature ({value})",
                "Check the sensor and its wiring.",
            )
        return value

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Set how to ramp, then the set-point, then automatic control."""
        wanted = self.limits.clamp(target, rate)
        with self._unit.line.reserved():
            self._unit.put(RAMP_SCALE, PER_MINUTE, name="ramp scale")
            taken_rate = self._unit.put_float(RAMP_RATE, wanted.rate, 1e-3 * wanted.rate, name="ramp rate")
            self._unit.put(RAMP_ACTION, RAMP_ON_SET_POINT, name="ramp action")
            taken = self._unit.put_float(SET_POINT, wanted.target, 0.05, name="set-point")
            self._unit.put(MODE, AUTO, name="control mode")
        return SetPoint(taken, taken_rate)

    def hold(self) -> float:
        """Make the working set-point, where the ramp is now, the set-point."""
        with self._unit.line.reserved():
            resting = self._unit.read(MODE) != AUTO
            here = self.temperature() if resting else self._unit.read_float(WORKING_SET_POINT)
            held = self._unit.put_float(SET_POINT, self.limits.clamp_target(here), 0.05, name="set-point")
            self._unit.put(MODE, AUTO, name="control mode")
            return held

    def safe(self) -> None:
        """Switch the loop off."""
        self._unit.put(MODE, OFF, name="control mode")

    def close(self) -> None:
        """Let go of the line."""
        self._unit.line.close()
