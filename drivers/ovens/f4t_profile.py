"""A profile of limited time in a Watlow F4T: ramp, hold, end with the loop off.

Registers of one profile at a time, of loop 1, as chambers built around the controller use them; 170 for each step.
"""

import math

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.expiry import Expiry, of
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.oven import SetPoint

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
