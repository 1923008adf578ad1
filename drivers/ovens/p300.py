"""The command language of Espec P-300 and SCP-220 controllers: lines of text ended by CR LF."""

import re
from dataclasses import dataclass

from drivers.ovens.error import Fault, OvenError

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
