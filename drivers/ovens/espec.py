"""Espec chambers with a P-300 or SCP-220 controller."""

import math
from collections.abc import Callable
from typing import TypeVar

from drivers.ovens import p300
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, up_to
from drivers.ovens.oven import OvenLimits, SetPoint

T = TypeVar("T")

RESTING = ("OFF", "STANDBY")
LONGEST_PROGRAM = 99 * 60 + 59
"""Minutes."""


class Espec:
    """A chamber that ramps by a remote program of one step. Safe state: standby.

    The controller has no ramp in its constant mode, so a ramp is the program "from here to there in
    so many minutes", which the chamber runs by itself and at whose end it stays. The time is in whole
    minutes, rounded up: the ramp is never steeper than asked.

    Some of these chambers stop when nobody has asked them anything for 30 s.

    Parameters
    ----------
    line : Line
    limits : OvenLimits
    """

    poll_within = 30.0

    def __init__(self, line: Line, limits: OvenLimits) -> None:
        self.limits = limits
        self._line = line
        self._commanded = False

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if one stands or the chamber has stopped by itself."""
        seen = self._ask("MON?", p300.decode_monitored)
        if seen.alarms:
            raise OvenError(
                Fault.ALARM,
                f"{seen.alarms} alarm(s) stand at {seen.temperature:g} °C",
                "Read them on the chamber's panel, remove their cause and reset them there.",
                self._ask("ALARM?", p300.decode),
            )
        if self._commanded and seen.mode in RESTING:
            raise OvenError(
                Fault.ALARM,
                f"the chamber has stopped by itself at {seen.temperature:g} °C",
                f"Was it stopped on its panel, or not asked for {self.poll_within:g} s? Start the ramp again.",
                seen.mode,
            )
        return seen.temperature

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Run the program from the present temperature to the target.

        Raises
        ------
        ValueError
            For a ramp longer than the 99 h 59 min a program can last.
        """
        wanted = self.limits.clamp(target, rate)
        end = round(wanted.target, 1)
        with self._line.reserved():
            start = self.limits.clamp_target(self._ask("TEMP?", p300.decode_temperatures).actual)
            minutes = math.ceil(abs(end - start) / wanted.rate - 1e-9)
            if minutes > LONGEST_PROGRAM:
                raise ValueError(
                    f"a ramp from {start:g} to {end:g} °C at {wanted.rate:g} K/min takes {minutes} min; "
                    f"this controller's programs last at most {LONGEST_PROGRAM} min"
                )
            if minutes == 0:
                return SetPoint(self._keep(end), wanted.rate)
            program = p300.Program(round(start, 1), end, minutes)
            self._tell(program.encode())
            taken = self._ask("RUN PRGM?", p300.decode_program)
            self._check("program", program, taken)
            self._check_mode("RUN")
            self._commanded = True
            return SetPoint(taken.end, abs(taken.end - taken.start) / taken.minutes)

    def hold(self) -> float:
        """Leave the program for the constant mode at the set-point it has reached."""
        with self._line.reserved():
            seen = self._ask("TEMP?", p300.decode_temperatures)
            resting = self._ask("MODE?", p300.decode) in RESTING
            return self._keep(self.limits.clamp_target(seen.actual if resting else seen.set_point))

    def safe(self) -> None:
        """Standby: fan, heater and cooler off, controller awake."""
        with self._line.reserved():
            self._commanded = False
            self._tell(p300.command("MODE, STANDBY"))
            self._check_mode("STANDBY")

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()

    def _keep(self, temperature: float) -> float:
        self._tell(p300.set_temperature(temperature))
        self._tell(p300.command("MODE, CONSTANT"))
        self._check_mode("CONSTANT")
        taken = self._ask("TEMP?", p300.decode_temperatures).set_point
        self._check("set-point in °C", round(temperature, 1), taken)
        self._commanded = True
        return taken

    def _check_mode(self, wanted: str) -> None:
        self._check("mode", wanted, self._ask("MODE?", p300.decode), same=str.startswith)

    def _check(self, name: str, wanted: T, held: T, same: Callable[[T, T], bool] | None = None) -> None:
        if not (same(held, wanted) if same is not None else held == wanted):
            raise OvenError(
                Fault.NOT_TAKEN,
                f"{name} was set to {wanted} and reads back {held}",
                "Check the chamber's own limits, its panel's lock, and whether somebody uses the panel.",
            )

    def _ask(self, question: str, decode: Callable[[bytes], T]) -> T:
        return self._line.attempt(lambda: decode(self._line.exchange(p300.command(question), up_to(p300.CRLF))))

    def _tell(self, request: bytes) -> None:
        self._line.attempt(lambda: p300.decode_done(self._line.exchange(request, up_to(p300.CRLF))), writes=True)
