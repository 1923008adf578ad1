"""Eurotherm 2400 and 3500: scaled integers, and floats of the same registers at 0x8000 + 2 x address.

Register numbers: Eurotherm 2000 series communications handbook, and those of the 3500.

A 2400 with its programmer runs a program of limited time: ramp, dwell, output off. Programs lie from register 8192
on, 136 registers each, eight for what they have in general and eight for every segment; times are milliseconds in
two registers at 0x8000 + 2 x address (2000 series communications handbook).
"""

import math
from dataclasses import dataclass
from functools import partial

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.expiry import HARMLESS, Expiry, of, refused_is_none
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


NUMBER, STATUS, SELECTED, LOCAL, MODE = 22, 23, 15, 24, 273
AUTOMATIC = 0
RESET, RUN, COMPLETE = 1, 2, 16
PROGRAMS, PROGRAM, SEGMENT = 8192, 136, 8
HOLDBACK, RAMP_UNITS, CYCLES = 0, 2, 4
"""Of the program in general; no holdback is 0, minutes are 1."""
KIND, TARGET, RATE_OR_TIME, END_TYPE = 0, 1, 2, 3
"""Of a segment. The end's power stands where other segments have their target."""
RAMP, DWELL, END = 1, 3, 0
OUTPUT_OFF = 2
"""End type: the output goes to the end's power."""
WITHOUT = "Is a programmer fitted? Without oven.program the controller ramps by itself, without an end."


def as_float(register: int) -> int:
    """Return where the float, or the time, of a register stands."""
    return 0x8000 + 2 * register


class EurothermProgram:
    """One of the instrument's programs, overwritten with every ramp.

    Parameters
    ----------
    unit : ModbusUnit
    number : int
        From 1.
    rest_after : float
        How long the target is held before the output goes off, s.
    decimals : int
        Of temperatures.

    Attributes
    ----------
    expiry : Expiry
        Of its dwell.
    """

    def __init__(self, unit: ModbusUnit, number: int, rest_after: float, decimals: int) -> None:
        self._unit = unit
        self._number = number
        self._decimals = decimals
        self._base = PROGRAMS + PROGRAM * number
        self.expiry = Expiry(rest_after)

    @property
    def running(self) -> bool:
        """Whether it ramps or dwells."""
        return self._unit.read(STATUS) == RUN

    def write(self, wanted: SetPoint) -> SetPoint:
        """Write a ramp, the dwell and the end, as far as they do not stand there; return the ramp as taken."""
        put, put_float = self._unit.put, self._unit.put_float
        ramp, dwell, end = (self._base + SEGMENT * segment for segment in (1, 2, 3))
        with of(f"program {self._number}", WITHOUT):
            put(self._base + HOLDBACK, 0, name="holdback type")
            put(self._base + RAMP_UNITS, 1, name="ramp units")
            put(self._base + CYCLES, 1, name="program cycles")
            put(ramp + KIND, RAMP, name="type of segment 1")
            target = put_float(as_float(ramp + TARGET), wanted.target, 0.051, name="target of segment 1")
            tolerance = min(0.051, 0.25 * wanted.rate)  # a rate of zero must not pass
            rate = put_float(as_float(ramp + RATE_OR_TIME), wanted.rate, tolerance, name="rate of segment 1")
            put(dwell + KIND, DWELL, name="type of segment 2")
            milliseconds = round(1e3 * self.expiry.rest_after)
            self._unit.put_long(as_float(dwell + RATE_OR_TIME), milliseconds, name="time of segment 2")
            put(end + KIND, END, name="type of segment 3")
            put_float(as_float(end + TARGET), 0.0, 0.051, name="power at the end")
            put(end + END_TYPE, OUTPUT_OFF, name="end type")
        return SetPoint(target, rate)

    def start(self, here: float, harmless: float, ramp: float) -> None:
        """Start it, or start it anew; reset, it returns to a harmless set-point.

        The set-point it may start from is the temperature only while the program before still runs, and in the
        moment between its reset and the new start: nothing else would end by itself.

        Parameters
        ----------
        here : float
            Temperature it starts from, degrees Celsius.
        harmless : float
            Set-point after a reset, degrees Celsius.
        ramp : float
            How long the ramp takes, s.

        Raises
        ------
        OvenError
            Of kind not taken, if the program does not run or a register reads back different; of another kind if
            the line fails.
        """
        self.expiry.starting = True
        put = self._unit.put
        put(SELECTED, 0, name="set-point select")
        put(LOCAL, here, self._decimals, name="set-point 1")
        put(STATUS, RESET, name="program status")
        put(NUMBER, self._number, name="program number")
        put(MODE, AUTOMATIC, name="auto/manual")
        self._unit.write(STATUS, RUN)
        status = self._unit.read(STATUS)
        put(LOCAL, harmless, self._decimals, name="set-point 1")
        if status not in (RUN, COMPLETE):
            raise OvenError(
                Fault.NOT_TAKEN,
                f"program {self._number} was started and its status reads back {status:g}",
                WITHOUT,
            )
        self.expiry.begin(self._unit.line.now, ramp)

    def send_reset(self) -> None:
        """Command its stop, without reading anything."""
        self._unit.write(STATUS, RESET)

    def reset(self) -> None:
        """Stop it: in automatic, the instrument goes to set-point 1."""
        self.expiry.end()
        with of(f"program {self._number}", WITHOUT):
            self._unit.put(STATUS, RESET, name="program status")


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
