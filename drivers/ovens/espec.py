"""Espec chambers with a P-300 or SCP-220 controller."""

import logging
import math
import operator
from collections.abc import Callable
from typing import TypeVar

from drivers.ovens import p300
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.expiry import Expiry
from drivers.ovens.line import Line, up_to
from drivers.ovens.oven import OvenLimits, SetPoint, beyond_ramp, other_set_point

T = TypeVar("T")

RESTING = ("OFF", "STANDBY")
LONGEST_PROGRAM = 99 * 60 + 59
"""Minutes."""
GO_WITHOUT = "With oven.rest_after = 0 no timer is used; the chamber then continues if the computer fails."

log = logging.getLogger(__name__)


class Espec:
    """A chamber that ramps by a remote program of one step. Safe state: standby.

    The controller has no ramp in its constant mode, so a ramp is the program "from here to there in
    so many minutes", which the chamber runs by itself and at whose end it stays. The time is in whole
    minutes, rounded up: the ramp is never steeper than asked.

    Some of these chambers stop if they get no query for 30 s. For the others the quick timer is set
    before anything is started, and again by `renew`: it puts an abandoned chamber into standby.

    Parameters
    ----------
    line : Line
    limits : OvenLimits
    rest_after : float
        Time of the quick timer, s; 0 where it is not to be used.
    """

    poll_within = 30.0

    def __init__(self, line: Line, limits: OvenLimits, rest_after: float = 0.0) -> None:
        self.limits = limits
        self._line = line
        self._expiry = Expiry(rest_after) if rest_after else None
        self._commanded = False
        self._under_way: tuple[SetPoint, SetPoint] | None = None
        self._kept: float | None = None
        self._running: p300.Program | None = None

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if one stands or the chamber has stopped by itself."""
        seen = self._ask("MON?", p300.decode_monitored)
        if seen.alarms:
            raise OvenError(
                Fault.ALARM,
                f"{seen.alarms} alarm(s) active at {seen.temperature:g} °C",
                "Read them on the chamber's panel, remove their cause and reset them there.",
                self._ask("ALARM?", p300.decode),
            )
        if self._commanded and seen.mode in RESTING:
            raise OvenError(
                Fault.ALARM,
                f"the chamber has stopped by itself at {seen.temperature:g} °C",
                f"Was it stopped on its panel, or not asked for {self.poll_within:g} s, or has its quick timer "
                "run out? Start the ramp again.",
                seen.mode,
            )
        return seen.temperature

    def bounds(self) -> tuple[float, float]:
        """Temperatures at which the chamber would stop with an alarm, degrees Celsius."""
        seen = self._ask("TEMP?", p300.decode_temperatures)
        return seen.low_alarm, seen.high_alarm

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
            before, self._under_way = self._under_way, None
            if before is not None and before[0] == wanted and self._ask("MODE?", p300.decode).startswith("RUN"):
                self._under_way = before
                return before[1]
            start = self.limits.clamp_target(self._ask("TEMP?", p300.decode_temperatures).actual)
            minutes = math.ceil(abs(end - start) / wanted.rate - 1e-9)
            if minutes > LONGEST_PROGRAM:
                raise ValueError(
                    f"a ramp from {start:g} to {end:g} °C at {wanted.rate:g} K/min takes {minutes} min; "
                    f"this controller's programs last at most {LONGEST_PROGRAM} min"
                )
            if minutes == 0:
                return SetPoint(self._keep(end), wanted.rate)
            self._set_timer()
            program = p300.Program(round(start, 1), end, minutes)
            self._tell(program.encode())
            taken = self._check("program", program, lambda: self._ask("RUN PRGM?", p300.decode_program))
            self._check_mode("RUN")
            self._commanded = True
            self._kept, self._running = None, taken
            ramp = SetPoint(taken.end, abs(taken.end - taken.start) / taken.minutes)
            self._under_way = wanted, ramp
            return ramp

    def hold(self) -> float:
        """Leave the program for the constant mode at the set-point it has reached."""
        with self._line.reserved():
            seen = self._ask("TEMP?", p300.decode_temperatures)
            resting = self._ask("MODE?", p300.decode) in RESTING
            return self._keep(self.limits.clamp_target(seen.actual if resting else seen.set_point))

    def changed(self) -> str:
        """Say whether the set-point is another than commanded: while a program runs, beyond its two ends."""
        if self._kept is None and self._running is None:
            return ""
        held = self._ask("TEMP?", p300.decode_temperatures).set_point
        if self._running is not None:
            return beyond_ramp((self._running.start, self._running.end), held)
        return other_set_point(self._kept, held)

    def renew(self) -> None:
        """Set the quick timer anew once half of it is over."""
        if self._expiry is not None and self._expiry.due(self._line.now):
            self._set_timer()

    def safe(self) -> None:
        """Standby: fan, heater and cooler off, controller awake."""
        with self._line.reserved():
            self._commanded, self._under_way = False, None
            self._kept = self._running = None
            if self._expiry is not None:
                self._expiry.end()
            standby = p300.command("MODE, STANDBY")
            self._line.blind(lambda: self._tell(standby))
            if not self._ask("MODE?", p300.decode).startswith("STANDBY"):
                self._tell(standby)
                self._check_mode("STANDBY")
            if self._expiry is not None:
                self._stop_timer()

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()

    def _keep(self, temperature: float) -> float:
        self._under_way = None
        self._set_timer()
        self._tell(p300.set_temperature(temperature))
        self._tell(p300.command("MODE, CONSTANT"))
        self._check_mode("CONSTANT")
        taken = self._check(
            "set-point in °C",
            round(temperature, 1),
            lambda: self._ask("TEMP?", p300.decode_temperatures).set_point,
        )
        self._commanded = True
        self._kept, self._running = taken, None
        return taken

    def _set_timer(self) -> None:
        if self._expiry is None:
            return
        wanted = p300.QuickTimer(math.ceil(self._expiry.rest_after / 60.0))
        with self._line.reserved():
            try:
                self._tell(wanted.encode())
                self._tell(p300.command("TIMER, ON, 0"))
                self._check("it, and whether it runs,", (wanted, True), self._timer, same=_same_timer)
            except OvenError as error:
                if error.fault not in (Fault.REFUSED, Fault.NOT_TAKEN):
                    raise
                what, advice = f"quick timer: {error.what}", f"{error.advice} {GO_WITHOUT}"
                raise OvenError(error.fault, what, advice, error.code) from error
            self._expiry.begin(self._line.now)

    def _timer(self) -> tuple[p300.QuickTimer, bool]:
        taken = self._ask("TIMER LIST?, 0", p300.decode_quick_timer)
        return taken, 0 in self._ask("TIMER ON?", p300.decode_timers_on)

    def _stop_timer(self) -> None:
        """Switch the timer off, so that it cannot stop a chamber that another program uses."""
        try:
            self._tell(p300.command("TIMER, OFF, 0"))
        except OvenError as error:
            log.warning("the chamber is at rest; its quick timer could not be stopped: %s", error)

    def _check_mode(self, wanted: str) -> None:
        self._check("mode", wanted, lambda: self._ask("MODE?", p300.decode), same=str.startswith)

    def _check(self, name: str, wanted: T, ask: Callable[[], T], same: Callable[[T, T], bool] = operator.eq) -> T:
        """Return what reads back as it was set; asked twice, for no checksum guards a digit of the answer."""
        for _ in range(2):
            if same(held := ask(), wanted):
                return held
        raise OvenError(
            Fault.NOT_TAKEN,
            f"{name} was set to {wanted} and reads back {held}",
            "Check the chamber's own limits, its panel's lock, and whether somebody uses the panel.",
        )

    def _ask(self, question: str, decode: Callable[[bytes], T]) -> T:
        return self._line.attempt(
            lambda: decode(self._line.exchange(p300.command(question), up_to(p300.CRLF))), checksum=False
        )

    def _tell(self, request: bytes) -> None:
        self._line.attempt(lambda: self._once(request), writes=True, checksum=False)

    def _once(self, request: bytes) -> None:
        p300.decode_done(self._line.exchange(request, up_to(p300.CRLF)))


def _same_timer(held: tuple[p300.QuickTimer, bool], wanted: tuple[p300.QuickTimer, bool]) -> bool:
    """Whether it runs, and has not counted down by more than the minute it was asked in."""
    minutes = wanted[0].minutes
    return held[1] and held[0].mode == wanted[0].mode and minutes - 1 <= held[0].minutes <= minutes
