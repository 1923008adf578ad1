"""Watlow F4T, control loop 1: floats over two registers, low word first (data map 1).

Registers: Watlow F4T user's guide, and the ramp registers of chambers built around it.

A profile of limited time ramps, holds and ends with the loop off: registers of one profile at a time, of loop 1,
as chambers built around the controller use them; 170 for each step.
"""

import math
from functools import partial

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.expiry import HARMLESS, Expiry, of, refused_is_none
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import OvenLimits, SetPoint, beyond_ramp, other_set_point

MODE, LOW_LIMIT, HIGH_LIMIT, SET_POINT = 2730, 2774, 2776, 2782
RAMP_ACTION, RAMP_SCALE, RAMP_RATE = 2794, 2796, 2798
WORKING_SET_POINT, TEMPERATURE = 2810, 2820

OFF, AUTO = 62, 10
RAMP_ON_SET_POINT, PER_MINUTE = 85, 57
UNIT, FAHRENHEIT = 14080, 30
"""Of the values on the serial line, whatever the display shows."""


EDITED, EDIT, STEPS = 18888, 18890, 18920
ADD, DELETE = 1375, 1772
STEP, KIND, HOURS, MINUTES, SECONDS, TARGET, END_MODE = 170, 19094, 19096, 19098, 19100, 19114, 19170
RAMP, HOLD, END = 1928, 1927, 27
"""A step that ramps for a time, one that jumps to a target and holds it for a time, and the end."""
LOOP_OFF = 62
NUMBER, FIRST_STEP, START, STOP, STATE = 16558, 16560, 16562, 16566, 16568
BEGIN, TERMINATE, RUNNING = 1782, 148, 149
WITHOUT = "Has the controller profiles? Without oven.program it ramps by itself, without an end."


class F4TProfile:
    """One of the controller's profiles, overwritten with every ramp.

    Parameters
    ----------
    unit : ModbusUnit
        With low word first.
    number : int
        1 to 40.
    rest_after : float
        How long the target is held before the loop goes off, s.

    Attributes
    ----------
    expiry : Expiry
        Of its hold.
    """

    def __init__(self, unit: ModbusUnit, number: int, rest_after: float) -> None:
        self._unit = unit
        self._number = number
        self.expiry = Expiry(rest_after)

    @property
    def running(self) -> bool:
        """Whether any profile runs."""
        return self._unit.read(STATE) == RUNNING

    def write(self, start: float, wanted: SetPoint) -> SetPoint:
        """Write ramp, hold and end, as far as they do not stand there; return the ramp as taken.

        A ramp lasts whole seconds, at least one, and is never steeper than asked for.
        """
        seconds = max(math.ceil(60.0 * abs(wanted.target - start) / wanted.rate - 1e-6), 1)
        put = self._unit.put
        with of(f"profile {self._number}", WITHOUT):
            put(EDITED, self._number, name="profile to edit")
            kinds = (RAMP, HOLD, END)
            if [self._unit.read(KIND + STEP * i) for i in range(round(self._unit.read(STEPS)))] != list(kinds):
                self._begin_anew()
            for step, kind in enumerate(kinds):
                put(KIND + STEP * step, kind, name=f"type of step {step + 1}")
            for step, duration in enumerate((seconds, math.ceil(self.expiry.rest_after))):
                target = self._unit.put_float(TARGET + STEP * step, wanted.target, 0.05, name="step's target")
                for register, value in zip((HOURS, MINUTES, SECONDS), _clock(duration), strict=True):
                    put(register + STEP * step, value, name="step's duration")
            put(END_MODE + STEP * 2, LOOP_OFF, name="end of loop 1")
        return SetPoint(target, max(60.0 * abs(target - start) / seconds, 1e-6))

    def start(self, step: int, ramp: float) -> None:
        """Start it at a step, counted from 1; its ramp takes so long from there, s."""
        self._unit.put(NUMBER, self._number, name="profile to start")
        self._unit.put(FIRST_STEP, step, name="step to start")
        self._unit.write(START, BEGIN)
        if not self.running:
            raise OvenError(
                Fault.NOT_TAKEN, f"profile {self._number} was started and reads back as not running", WITHOUT
            )
        self.expiry.begin(self._unit.line.now, ramp)

    def send_stop(self) -> None:
        """Command the end of whatever profile runs, without reading anything."""
        self._unit.write(STOP, TERMINATE)

    def stop(self) -> None:
        """Terminate whatever profile runs: the loop goes back to its own set-point and mode."""
        with of(f"profile {self._number}", WITHOUT):
            if self.running:
                self._unit.write(STOP, TERMINATE)
                if self.running:
                    raise OvenError(Fault.NOT_TAKEN, "it was terminated and reads back as running", WITHOUT)

    def _begin_anew(self) -> None:
        if self._unit.read(STEPS):
            self._unit.write(EDIT, DELETE)
            self._unit.put(EDITED, self._number, name="profile to edit")
        self._unit.write(EDIT, ADD)


def _clock(seconds: int) -> tuple[int, int, int]:
    return seconds // 3600, seconds // 60 % 60, seconds % 60


class F4T:
    """A Watlow F4T whose loop ramps to a new set-point by itself. Safe state: control mode off.

    One with profiles can be given a profile instead, which ends with its loop off if it is not renewed.

    Parameters
    ----------
    unit : ModbusUnit
        With low word first.
    limits : OvenLimits
    profile : F4TProfile, optional
        To be overwritten with every ramp.
    """

    poll_within = math.inf

    def __init__(self, unit: ModbusUnit, limits: OvenLimits, profile: F4TProfile | None = None) -> None:
        self.limits = limits
        self._unit = unit
        self._profile = profile
        self._usable = False
        self._told: float | None = None
        self._ends: tuple[float, float] | None = None

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if the controller has no valid one.

        This, or the first command, refuses where the controller's own set-point limits leave nothing of `limits`,
        or it speaks in degrees Fahrenheit.
        """
        self._require_usable()
        value = self._unit.read_float(TEMPERATURE)
        if not math.isfinite(value):
            raise OvenError(
                Fault.ALARM,
                f"the controller has no valid temperature ({value})",
                "Check the sensor and its wiring.",
            )
        return value

    def bounds(self) -> tuple[float, float]:
        """Set-point limits of the loop, degrees Celsius."""
        return self._unit.read_float(LOW_LIMIT), self._unit.read_float(HIGH_LIMIT)

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Set how to ramp, then the set-point, then automatic control."""
        wanted = self.limits.clamp(target, rate)
        self._require_usable()
        if self._profile is not None:
            return self._run(self._profile, wanted)
        with self._unit.line.reserved():
            taken_rate = self._put_rate(wanted.rate)
            taken = self._unit.put_float(SET_POINT, wanted.target, 0.05, name="set-point")
            self._unit.put(MODE, AUTO, name="control mode")
            self._told = taken
        return SetPoint(taken, taken_rate)

    def hold(self) -> float:
        """Make the working set-point, where the ramp is now, the set-point."""
        self._require_usable()
        with self._unit.line.reserved():
            here = self._set_point()
            if self._profile is not None:
                return self._run(self._profile, self.limits.clamp(here, self.limits.max_rate)).target
            held = self._unit.put_float(SET_POINT, self.limits.clamp_target(here), 0.05, name="set-point")
            self._unit.put(MODE, AUTO, name="control mode")
            self._told = held
            return held

    def changed(self) -> str:
        """Say whether loop, set-point or profile are others than commanded."""
        with self._unit.line.reserved():
            if self._profile is not None:
                if self._profile.expiry.under_way is None or self._profile.expiry.starting:
                    return ""
                if not self._runs(self._profile):
                    return "its profile was stopped"
                return beyond_ramp(self._ends, self._unit.read_float(WORKING_SET_POINT))
            if self._told is None:
                return ""
            if self._unit.read(MODE) != AUTO:
                return "its loop was switched off"
            return other_set_point(self._told, self._unit.read_float(SET_POINT))

    def safe(self) -> None:
        """Switch the loop off."""
        with self._unit.line.reserved():
            self._told = None
            off = partial(self._unit.write, MODE, OFF)
            if self._profile is None:
                self._unit.line.blind(off)
            else:
                self._profile.expiry.end()
                self._unit.line.blind(off, self._profile.send_stop, off)
            self._unit.put(MODE, OFF, name="control mode")
            if self._profile is not None:
                with refused_is_none():
                    self._profile.stop()
                self._unit.put(MODE, OFF, name="control mode")

    def renew(self) -> None:
        """Start the profile's hold anew once half of it is over; not one that was stopped at the panel."""
        if self._profile is None or not self._profile.expiry.due(self._unit.line.now):
            return
        with self._unit.line.reserved():
            if self._unit.read(MODE) == AUTO and (self._profile.expiry.starting or self._profile.running):
                self._start(self._profile, self._set_point(), step=2, ramp=0.0)

    def _require_usable(self) -> None:
        """Before the first use, not on opening: an oven in alarm can be opened and brought to rest."""
        if self._usable:
            return
        if self._unit.read(UNIT) == FAHRENHEIT:
            raise OvenError(
                Fault.REFUSED,
                "the controller's communication units are degrees Fahrenheit",
                "Set them to degrees Celsius: all limits and set-points here are.",
            )
        limits, (low, high) = self.limits, self.bounds()
        if not (low < limits.maximum and limits.minimum < high):
            raise OvenError(
                Fault.REFUSED,
                f"the controller's set-points end at {low:g} and {high:g} °C, "
                f"the limits asked for at {limits.minimum:g} and {limits.maximum:g} °C",
                "Correct minimum and maximum, or the controller's.",
            )
        self._usable = True

    def _run(self, profile: F4TProfile, wanted: SetPoint) -> SetPoint:
        with self._unit.line.reserved():
            before = profile.expiry.under_way
            if before is not None and before[0] == wanted and self._runs(profile):
                return before[1]
            start = self._set_point()
            profile.expiry.end()
            self._put_rate(self.limits.max_rate)
            self._unit.put_float(SET_POINT, self.limits.clamp_target(HARMLESS), 0.05, name="set-point")
            profile.stop()
            taken = profile.write(start, wanted)
            self._start(profile, start, step=1, ramp=60.0 * abs(taken.target - start) / taken.rate)
            profile.expiry.under_way, self._ends = (wanted, taken), (start, taken.target)
        return taken

    def _start(self, profile: F4TProfile, here: float, step: int, ramp: float) -> None:
        """Start the profile from `here`; stopped, the loop ramps to a set-point that is harmless.

        Its own set-point, from which a profile may start, is the temperature only in the moment between the end of
        one profile and the beginning of the next: nothing else would end by itself.
        """
        profile.expiry.starting = True
        profile.stop()
        self._unit.put_float(SET_POINT, self.limits.clamp_target(here), 0.05, name="set-point")
        profile.start(step, ramp)
        self._unit.put(MODE, AUTO, name="control mode")
        self._unit.put_float(SET_POINT, self.limits.clamp_target(HARMLESS), 0.05, name="set-point")

    def _runs(self, profile: F4TProfile) -> bool:
        return self._unit.read(MODE) == AUTO and profile.running

    def _set_point(self) -> float:
        """Return where the loop is: its working set-point, the temperature where it is off."""
        resting = self._unit.read(MODE) != AUTO
        return self.temperature() if resting else self._unit.read_float(WORKING_SET_POINT)

    def _put_rate(self, rate: float) -> float:
        self._unit.put(RAMP_SCALE, PER_MINUTE, name="ramp scale")
        taken = self._unit.put_float(RAMP_RATE, rate, 1e-3 * rate, name="ramp rate")
        self._unit.put(RAMP_ACTION, RAMP_ON_SET_POINT, name="ramp action")
        return taken

    def close(self) -> None:
        """Let go of the line."""
        self._unit.line.close()
