"""A simulated Espec chamber with a P-300 controller."""

import math
import re

from drivers.clock import Clock
from drivers.ovens.simulated.controller import Delivery, LineController
from drivers.ovens.simulated.regulated_oven import RegulatedOven

TIMER = re.compile(r"TIMER WRITE,\s*NO0,\s*(\d+):(\d+),\s*(STANDBY|OFF|CONSTANT)")
PROGRAM = re.compile(r"RUN PRGM, TEMP(-?[\d.]+) GOTEMP(-?[\d.]+) TIME(\d+):(\d+)")


class SimulatedEspec(LineController):
    """A chamber with a constant mode, remote programs of one step, and a quick timer.

    Parameters
    ----------
    oven : RegulatedOven
    clock : Clock
        The oven's.
    low, high : float
        Its own limits, degrees Celsius: beyond them it refuses.
    patience : float
        Seconds without a command after which it stops.

    Attributes
    ----------
    locked : bool
        Acknowledges writes without effect.
    protected : bool
        Refuses writes.
    alarms : tuple of int
    """

    def __init__(
        self, oven: RegulatedOven, clock: Clock, low: float = -40.0, high: float = 150.0, patience: float = 30.0
    ) -> None:
        super().__init__(b"\r\n")
        self._oven = oven
        self._clock = clock
        self._low, self._high = low, high
        self._patience = patience
        self._constant = oven.working
        self._mode = "STANDBY"
        self._program = ""
        self._timer, self._timer_ends = (0, "STANDBY"), math.inf
        self.locked = False
        self.protected = False
        self.alarms: tuple[int, ...] = ()

    def receive(self, data: bytes) -> list[Delivery]:
        """Answer, and start waiting for the next command anew."""
        if not self._oven.regulating:
            self._mode = "STANDBY" if self._mode in ("CONSTANT", "RUN") else self._mode
        if self._clock.now() >= self._timer_ends:
            self._timer_ends = math.inf
        answers = super().receive(data)
        self._oven.stop_at = min(self._clock.now() + self._patience, self._timer_ends)
        return answers

    def answer(self, command: str) -> str:
        """Serve the questions and commands of the driver, and refuse others as the real one does."""
        words = command.strip().upper()
        if "?" in words:
            return self._question(words)
        if self.protected:
            return "NA:PROTECT ON"
        return self._command(words)

    def _question(self, words: str) -> str:
        oven = self._oven
        match words:
            case "TEMP?":
                set_point = oven.working if self._mode == "RUN" else self._constant
                return f"{oven.measured:.1f},{set_point:.1f},{self._high:.1f},{self._low:.1f}"
            case "MON?":
                return f"{oven.measured:.1f},{self._mode},{len(self.alarms)}"
            case "MODE?":
                return self._mode
            case "ALARM?":
                return ",".join(str(number) for number in (len(self.alarms), *self.alarms))
            case "TIMER ON?":
                return "1,0" if self._timer_ends < math.inf else "0"
            case "TIMER LIST?, 0":
                minutes, mode = self._timer
                return f"{mode},{minutes // 60}:{minutes % 60:02d}"
            case "RUN PRGM?":
                return self._program or "NA:CHB NOT READY"
        return "NA:CMD ERR"

    def _command(self, words: str) -> str:
        if program := PROGRAM.fullmatch(words):
            start, end = float(program[1]), float(program[2])
            minutes = 60 * int(program[3]) + int(program[4])
            if not (self._low <= start <= self._high and self._low <= end <= self._high and minutes):
                return "NA:DATA OUT OF RANGE"
            if not self.locked:
                self._mode, self._program = "RUN", words.removeprefix("RUN PRGM, ") + " REF9"
                self._oven.go(end, abs(end - start) / minutes, start)
        elif constant := re.fullmatch(r"TEMP,\s*S(-?[\d.]+)", words):
            value = float(constant[1])
            if not self._low <= value <= self._high:
                return "NA:DATA OUT OF RANGE"
            if not self.locked:
                self._constant = value
                if self._mode == "CONSTANT":
                    self._oven.go(value, math.inf)
        elif mode := re.fullmatch(r"MODE,\s*(CONSTANT|STANDBY|OFF)", words):
            if not self.locked:
                self._change(mode[1])
        elif timer := TIMER.fullmatch(words):
            if not self.locked:
                self._timer = (60 * int(timer[1]) + int(timer[2]), timer[3])
        elif words in ("TIMER, ON, 0", "TIMER, OFF, 0"):
            if not self.locked:
                self._timer_ends = self._clock.now() + 60.0 * self._timer[0] if "ON" in words else math.inf
        else:
            return "NA:CMD ERR"
        return f"OK:{words}"

    def _change(self, mode: str) -> None:
        self._mode = mode
        if mode == "CONSTANT":
            self._oven.go(self._constant, math.inf)
        else:
            self._oven.stop()
