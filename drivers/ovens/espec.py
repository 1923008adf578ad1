"""Espec chambers with a P-300 or SCP-220 controller, and its command language: lines of text ended by CR LF."""

import logging
import math
import operator
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

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


CRLF = b"\r\n"

_NUMBER = r"[-+]?\d{1,3}(?:\.\d{1,2})?"

ADVICE = {
    "CMD ERR": "This firmware does not have the command: check that kind names the controller.",
    "ADDR ERR": "Check the controller's communication settings.",
    "CONT NOT READY": "Wait until the controller is ready, or look at its panel.",
    "CHB NOT READY": "The chamber is not ready: look at its panel for an alarm or an ended program.",
    "DATA NOT READY": "Wait, and try again.",
    "DATA OUT OF RANGE": "The value is beyond the chamber's own limits: correct minimum, maximum or max_rate.",
    "PROTECT ON": "Take the protection off on the panel (or with KEYPROTECT, OFF).",
    "PARA ERR": "This firmware does not have the parameter: check that kind names the controller.",
}


@dataclass(frozen=True)
class Temperatures:
    """Answer to ``TEMP?``, degrees Celsius."""

    actual: float
    set_point: float
    high_alarm: float
    low_alarm: float


@dataclass(frozen=True)
class Monitored:
    """Answer to ``MON?``.

    Attributes
    ----------
    temperature : float
        degrees Celsius.
    mode : str
        ``OFF``, ``STANDBY``, ``CONSTANT`` or ``RUN`` with what follows it.
    alarms : int
        How many stand.
    """

    temperature: float
    mode: str
    alarms: int


@dataclass(frozen=True)
class Program:
    """A remote program of one step: from one temperature to another in whole minutes.

    Attributes
    ----------
    start, end : float
        degrees Celsius.
    minutes : int
    """

    start: float
    end: float
    minutes: int

    def encode(self) -> bytes:
        """Return the command that starts it."""
        hours, minutes = divmod(self.minutes, 60)
        return command(f"RUN PRGM, TEMP{self.start:.1f} GOTEMP{self.end:.1f} TIME{hours}:{minutes:02d}")


@dataclass(frozen=True)
class QuickTimer:
    """The timer that counts down once, whatever the chamber does meanwhile.

    Attributes
    ----------
    minutes : int
    mode : str
        What the chamber is put into then.
    """

    minutes: int
    mode: str = "STANDBY"

    def encode(self) -> bytes:
        """Return the command that sets it; it does not run yet."""
        return command(f"TIMER WRITE, NO0, {self.minutes // 60}:{self.minutes % 60:02d}, {self.mode}")


def command(words: str) -> bytes:
    """Return a command or question as sent."""
    return words.encode("ascii") + CRLF


def set_temperature(value: float) -> bytes:
    """Return the command that sets the constant temperature (degrees Celsius)."""
    return command(f"TEMP, S{value:.1f}")


def decode(answer: bytes) -> str:
    """Return the words of an answer, or raise what the controller says instead."""
    if not answer:
        raise OvenError(
            Fault.SILENT,
            "the chamber does not answer",
            "Is it switched on and wired? Check port and baud rate, and that its delimiter is CR LF.",
        )
    # printable characters and one end of line: everything else is noise on a line without checksums
    match = re.fullmatch(rb"([ -~]+)\r\n", answer)
    if match is None:
        raise garbled(answer, "a line of text")
    words = match[1].decode("ascii").strip()
    if words.startswith("NA:"):
        said = words[3:].strip()
        cause = next(
            (text for known, text in ADVICE.items() if said.startswith(known)), "Look at the chamber's panel."
        )
        if re.match("(?:CONT|CHB|DATA) NOT READY", said):
            raise OvenError(Fault.BUSY, "the chamber is not ready for the command", cause, words)
        raise OvenError(Fault.REFUSED, "the chamber refuses the command", cause, words)
    return words


def decode_done(answer: bytes) -> None:
    """Take an ``OK``, with or without the command repeated after it."""
    words = decode(answer)
    if not re.fullmatch(r"OK(?:\s*:.*)?", words):
        raise garbled(answer, "OK")


def decode_temperatures(answer: bytes) -> Temperatures:
    """Return what ``TEMP?`` answered."""
    match = re.fullmatch(r"\s*,\s*".join([f"({_NUMBER})"] * 4), decode(answer))
    if match is None:
        raise garbled(answer, "four temperatures")
    actual, set_point, high, low = (float(word) for word in match.groups())
    return Temperatures(actual, set_point, high, low)


def decode_monitored(answer: bytes) -> Monitored:
    """Return what ``MON?`` answered; a humidity between temperature and mode is passed over."""
    match = re.fullmatch(
        rf"({_NUMBER})\s*,(?:\s*{_NUMBER}\s*,)?\s*((?:OFF|STANDBY|CONSTANT|RUN)[\w ]*)\s*,\s*(\d{{1,2}})",
        decode(answer),
    )
    if match is None:
        raise garbled(answer, "temperature, mode and number of alarms")
    return Monitored(float(match[1]), match[2].strip(), int(match[3]))


def decode_program(answer: bytes) -> Program:
    """Return what ``RUN PRGM?`` answered."""
    match = re.match(
        rf"TEMP({_NUMBER})[\s,]+GOTEMP({_NUMBER})[\s,]+(?:HUMI\S+\s+GOHUMI\S+\s+)?TIME(\d{{1,3}}):(\d\d?)\b",
        decode(answer),
    )
    if match is None:
        raise garbled(answer, "a remote program")
    return Program(float(match[1]), float(match[2]), 60 * int(match[3]) + int(match[4]))


def decode_quick_timer(answer: bytes) -> QuickTimer:
    """Return what ``TIMER LIST?, 0`` answered."""
    match = re.fullmatch(r"(?:0\s*,\s*)?([A-Z]+)\s*,\s*(\d{1,2}):(\d\d?)", decode(answer))
    if match is None:
        raise garbled(answer, "a quick timer")
    return QuickTimer(60 * int(match[2]) + int(match[3]), match[1])


def decode_timers_on(answer: bytes) -> tuple[int, ...]:
    """Return the numbers of the timers that run, from ``TIMER ON?``; their count comes first."""
    match = re.fullmatch(r"(\d)((?:\s*,\s*[0-2])*)", decode(answer))
    numbers = tuple(int(number) for number in re.findall(r"\d", match[2])) if match else ()
    if match is None or len(numbers) != int(match[1]):
        raise garbled(answer, "numbers of timers")
    return numbers


def garbled(answer: bytes, wanted: str) -> OvenError:
    """Return the error for an answer that is not what it should be."""
    return OvenError(
        Fault.GARBLED,
        f"{answer[:60]!r} instead of {wanted}",
        "Check baud rate and parity, the cable's shield and ground, and that nobody else uses this port.",
    )


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
        self._running: Program | None = None

    def temperature(self) -> float:
        """Air temperature, degrees Celsius; alarm if one stands or the chamber has stopped by itself."""
        seen = self._ask("MON?", decode_monitored)
        if seen.alarms:
            raise OvenError(
                Fault.ALARM,
                f"{seen.alarms} alarm(s) active at {seen.temperature:g} °C",
                "Read them on the chamber's panel, remove their cause and reset them there.",
                self._ask("ALARM?", decode),
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
        seen = self._ask("TEMP?", decode_temperatures)
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
            if before is not None and before[0] == wanted and self._ask("MODE?", decode).startswith("RUN"):
                self._under_way = before
                return before[1]
            start = self.limits.clamp_target(self._ask("TEMP?", decode_temperatures).actual)
            minutes = math.ceil(abs(end - start) / wanted.rate - 1e-9)
            if minutes > LONGEST_PROGRAM:
                raise ValueError(
                    f"a ramp from {start:g} to {end:g} °C at {wanted.rate:g} K/min takes {minutes} min; "
                    f"this controller's programs last at most {LONGEST_PROGRAM} min"
                )
            if minutes == 0:
                return SetPoint(self._keep(end), wanted.rate)
            self._set_timer()
            program = Program(round(start, 1), end, minutes)
            self._tell(program.encode())
            taken = self._check("program", program, lambda: self._ask("RUN PRGM?", decode_program))
            self._check_mode("RUN")
            self._commanded = True
            self._kept, self._running = None, taken
            ramp = SetPoint(taken.end, abs(taken.end - taken.start) / taken.minutes)
            self._under_way = wanted, ramp
            return ramp

    def hold(self) -> float:
        """Leave the program for the constant mode at the set-point it has reached."""
        with self._line.reserved():
            seen = self._ask("TEMP?", decode_temperatures)
            resting = self._ask("MODE?", decode) in RESTING
            return self._keep(self.limits.clamp_target(seen.actual if resting else seen.set_point))

    def changed(self) -> str:
        """Say whether the set-point is another than commanded: while a program runs, beyond its two ends."""
        if self._kept is None and self._running is None:
            return ""
        held = self._ask("TEMP?", decode_temperatures).set_point
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
            standby = command("MODE, STANDBY")
            self._line.blind(lambda: self._tell(standby))
            if not self._ask("MODE?", decode).startswith("STANDBY"):
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
        self._tell(set_temperature(temperature))
        self._tell(command("MODE, CONSTANT"))
        self._check_mode("CONSTANT")
        taken = self._check(
            "set-point in °C",
            round(temperature, 1),
            lambda: self._ask("TEMP?", decode_temperatures).set_point,
        )
        self._commanded = True
        self._kept, self._running = taken, None
        return taken

    def _set_timer(self) -> None:
        if self._expiry is None:
            return
        wanted = QuickTimer(math.ceil(self._expiry.rest_after / 60.0))
        with self._line.reserved():
            try:
                self._tell(wanted.encode())
                self._tell(command("TIMER, ON, 0"))
                self._check("it, and whether it runs,", (wanted, True), self._timer, same=_same_timer)
            except OvenError as error:
                if error.fault not in (Fault.REFUSED, Fault.NOT_TAKEN):
                    raise
                what, advice = f"quick timer: {error.what}", f"{error.advice} {GO_WITHOUT}"
                raise OvenError(error.fault, what, advice, error.code) from error
            self._expiry.begin(self._line.now)

    def _timer(self) -> tuple[QuickTimer, bool]:
        taken = self._ask("TIMER LIST?, 0", decode_quick_timer)
        return taken, 0 in self._ask("TIMER ON?", decode_timers_on)

    def _stop_timer(self) -> None:
        """Switch the timer off, so that it cannot stop a chamber that another program uses."""
        try:
            self._tell(command("TIMER, OFF, 0"))
        except OvenError as error:
            log.warning("the chamber is at rest; its quick timer could not be stopped: %s", error)

    def _check_mode(self, wanted: str) -> None:
        self._check("mode", wanted, lambda: self._ask("MODE?", decode), same=str.startswith)

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
            lambda: decode(self._line.exchange(command(question), up_to(CRLF))), checksum=False
        )

    def _tell(self, request: bytes) -> None:
        self._line.attempt(lambda: self._once(request), writes=True, checksum=False)

    def _once(self, request: bytes) -> None:
        decode_done(self._line.exchange(request, up_to(CRLF)))


def _same_timer(held: tuple[QuickTimer, bool], wanted: tuple[QuickTimer, bool]) -> bool:
    """Whether it runs, and has not counted down by more than the minute it was asked in."""
    minutes = wanted[0].minutes
    return held[1] and held[0].mode == wanted[0].mode and minutes - 1 <= held[0].minutes <= minutes
