"""Eurotherm 2400 and 3500: scaled integers, and floats of the same registers at 0x8000 + 2 x address.

Register numbers: Eurotherm 2000 series communications handbook, and those of the 3500.
"""

import math
from dataclasses import dataclass
from functools import partial

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.eurotherm_program import AUTOMATIC, EurothermProgram, as_float
from drivers.ovens.expiry import HARMLESS, refused_is_none
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import OvenLimits, SetPoint, beyond_ramp, other_set_point

MANUAL = 1


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
    unit: int | None = None


MODEL_2400 = Registers(temperature=1, sensor_break=258, unit=516)
MODEL_3500 = Registers(temperature=289, rate_disable=78, alarms=10213)
UNITS = {1: "degrees Fahrenheit", 2: "kelvin"}
"""Other values are degrees Celsius, 0, and none declared."""


class Eurotherm:
    """A Eurotherm that ramps its own working set-point.

    Target and rate are written once per ramp, and only where they differ from what the instrument
    holds. The rate goes through the float registers, whose scale cannot be mistaken: an integer rate
    of 4 is 0.4 K/min on one instrument and 4 K/min on the next.

    A 2400 with a programmer can be given a program instead, which ends with its output off if it is not renewed.

    Safe state: manual, output 0 %.

    Parameters
    ----------
    unit : ModbusUnit
    limits : OvenLimits
    registers : Registers
    decimals : int
        Of the temperatures, as configured in the instrument.
    program : EurothermProgram, optional
        To be overwritten with every ramp.
    """

    poll_within = math.inf

    def __init__(
        self,
        unit: ModbusUnit,
        limits: OvenLimits,
        registers: Registers = MODEL_2400,
        decimals: int = 1,
        program: EurothermProgram | None = None,
    ) -> None:
        self.limits = limits
        self._unit = unit
        self._at = registers
        self._decimals = decimals
        self._program = program
        self._usable = False
        self._told: float | None = None
        self._ends: tuple[float, float] | None = None

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if the sensor is broken or an alarm stands.

        This, or the first command, refuses where the instrument's own float shows that `decimals` is wrong, or its
        unit is another.
        """
        with self._unit.line.reserved():
            if self._at.sensor_break is not None and self._unit.read(self._at.sensor_break):
                raise OvenError(
                    Fault.ALARM, "the controller reports a broken sensor", "Check thermocouple and wiring.", "Sbr"
                )
            if self._at.alarms is not None and (alarms := int(self._unit.read(self._at.alarms, signed=False))):
                raise OvenError(
                    Fault.ALARM,
                    f"alarms are active on the controller (summary {alarms:#06x})",
                    "Read them on its front panel, remove their cause and acknowledge them there.",
                    f"{alarms:#06x}",
                )
            self._require_usable()
            return self._unit.read(self._at.temperature, self._decimals)

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Set rate, then target, then automatic: the working set-point never sees a target without its rate."""
        wanted = self.limits.clamp(target, rate)
        self._require_usable()
        if self._program is not None:
            return self._run(self._program, wanted)
        with self._unit.line.reserved():
            taken_rate = self._put_rate(wanted.rate)
            if self._at.rate_disable is not None:
                self._unit.put(self._at.rate_disable, 0, name="set-point rate disable")
            taken = self._unit.put(self._at.target, wanted.target, self._decimals, name="target set-point")
            self._unit.put(self._at.mode, AUTOMATIC, name="auto/manual")
            self._told = taken
        return SetPoint(taken, taken_rate)

    def hold(self) -> float:
        """Make the working set-point, where the ramp is now, the target."""
        self._require_usable()
        with self._unit.line.reserved():
            # in manual, not every model's working set-point follows the temperature
            here = self._unit.read(
                self._at.temperature if self._resting() else self._at.working_set_point, self._decimals
            )
            if self._program is not None:
                return self._run(self._program, self.limits.clamp(here, self.limits.max_rate)).target
            held = self._unit.put(
                self._at.target, self.limits.clamp_target(here), self._decimals, name="target set-point"
            )
            self._unit.put(self._at.mode, AUTOMATIC, name="auto/manual")
            self._told = held
            return held

    def changed(self) -> str:
        """Say whether mode, target or program are others than commanded."""
        with self._unit.line.reserved():
            if self._program is not None:
                if self._program.expiry.under_way is None or self._program.expiry.starting:
                    return ""
                if self._resting() or not self._program.running:
                    return "its program was stopped"
                return beyond_ramp(self._ends, self._unit.read(self._at.working_set_point, self._decimals))
            if self._told is None:
                return ""
            if self._resting():
                return "it was put into manual"
            return other_set_point(self._told, self._unit.read(self._at.target, self._decimals))

    def safe(self) -> None:
        """Manual with no output."""
        with self._unit.line.reserved():
            self._told = None
            manual, no_output = ((self._at.mode, MANUAL), (self._at.output, 0))
            self._unit.line.blind(partial(self._unit.write, *manual), partial(self._unit.write, *no_output))
            if self._program is not None:
                self._program.expiry.end()
                self._unit.line.blind(self._program.send_reset)
            self._unit.put(self._at.mode, MANUAL, name="auto/manual")
            self._unit.put(self._at.output, 0, name="output")
            if self._program is not None:
                with refused_is_none():
                    self._program.reset()

    def renew(self) -> None:
        """Start the program anew once half of its dwell is over; not one that was stopped at the panel."""
        if self._program is None or not self._program.expiry.due(self._unit.line.now):
            return
        with self._unit.line.reserved():
            if self._resting() or not (self._program.expiry.starting or self._program.running):
                return
            here = self._unit.read(self._at.working_set_point, self._decimals)
            self._program.start(self.limits.clamp_target(here), self.limits.clamp_target(HARMLESS), ramp=0.0)

    def close(self) -> None:
        """Let go of the line."""
        self._unit.line.close()

    def _run(self, program: EurothermProgram, wanted: SetPoint) -> SetPoint:
        with self._unit.line.reserved():
            before = program.expiry.under_way
            if before is not None and before[0] == wanted and not self._resting() and program.running:
                return before[1]
            # what it does for a second while no program runs: go to the harmless set-point, without a jump
            self._put_rate(self.limits.max_rate)
            program.reset()
            taken = program.write(wanted)
            here = self._unit.read(self._at.temperature, self._decimals)
            ramp = 60.0 * abs(taken.target - here) / taken.rate
            program.start(self.limits.clamp_target(here), self.limits.clamp_target(HARMLESS), ramp)
            program.expiry.under_way, self._ends = (wanted, taken), (here, taken.target)
        return taken

    def _put_rate(self, rate: float) -> float:
        # half of the coarsest step a rate is displayed with, but never so much that zero would pass:
        # to these instruments a rate of zero means no ramp at all
        return self._unit.put_float(as_float(self._at.rate), rate, min(0.051, 0.25 * rate), name="set-point rate")

    def _resting(self) -> bool:
        """Whether it is in manual, in which not every model's working set-point follows the temperature."""
        return self._unit.read(self._at.mode) != AUTOMATIC

    def _require_usable(self) -> None:
        """Before the first use, not on opening: an oven in alarm can be opened and brought to rest."""
        if not self._usable:
            self._check_unit()
            self._check_decimals()
            self._usable = True

    def _check_unit(self) -> None:
        if self._at.unit is not None and (other := UNITS.get(int(self._unit.read(self._at.unit)))):
            raise OvenError(
                Fault.REFUSED,
                f"the instrument is set to {other}",
                "Set its unit to degrees Celsius: all limits and set-points here are.",
            )

    def _check_decimals(self) -> None:
        scaled = self._unit.read(self._at.temperature, self._decimals)
        exact = self._unit.read_float(as_float(self._at.temperature))
        if abs(scaled - exact) > 1.0 + 0.1 * abs(exact):
            raise OvenError(
                Fault.REFUSED,
                f"with decimals = {self._decimals} the integer temperature is {scaled:g} °C, "
                f"but the instrument's float says {exact:g} °C",
                "Set decimals to the digits after the point on the instrument's display (0, 1 or 2).",
            )
