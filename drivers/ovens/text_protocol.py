"""A controller's text protocol, one line per message: queries and commands as an experiment's file declares them.

Nothing declared is run: ``{value}`` is replaced by a number in a command; in an answer, what stands before and
after it is compared letter by letter, and the rest has to be one number of `NUMBER`.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import AfterValidator, Field

from analysis.declaration.strict import Declared
from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Transport, up_to
from drivers.ovens.line_settings import LineSettings
from drivers.ovens.points import PLAUSIBLE, RateUnit, TemperatureUnit, factors, not_taken


class TextLine(LineSettings):
    """A controller whose messages are lines of text."""

    terminator: Annotated[Literal["\n", "\r", "\r\n"], Field(description="ends each line")] = "\n"
    acknowledge: Annotated[str, Field(max_length=200, description="answer to a command; empty: none")] = ""

    def connection(self, clock: Clock, transport: Transport | None) -> "TextConnection":
        """Open the line."""
        return TextConnection(
            self.line(clock, transport), self.terminator.encode(), self.acknowledge, self.retries
        )


VALUE = "{value}"
NUMBER = re.compile(r"[-+]?[0-9]{1,9}(?:\.[0-9]{0,9})?(?:[eE][-+]?[0-9]{1,3})?")


def _sent(text: str) -> str:
    if not re.fullmatch(r"[ -~]{1,200}", text) or "{" in text or "}" in text:
        raise ValueError(f"{text!r}; 1 to 200 printable ASCII characters without braces allowed")
    return text


def _with_value(text: str) -> str:
    if (
        not re.fullmatch(r"[ -~]{1,200}", text)
        or text.count(VALUE) != 1
        or re.search("[{}]", text.replace(VALUE, ""))
    ):
        raise ValueError(f"{text!r}; printable ASCII with {VALUE} once, and no other braces, allowed")
    return text


Sent = Annotated[str, AfterValidator(_sent)]
WithValue = Annotated[str, AfterValidator(_with_value)]
Answers = Annotated[tuple[Sent, ...], Field(min_length=1)]


class Query(Declared):
    """A question whose answer holds a number."""

    plausible: ClassVar[tuple[float, float]] = (-math.inf, math.inf)
    """What it can mean, degrees Celsius or K/min."""

    query: Annotated[Sent, Field(description="what is asked: MEAS:TEMP?")]
    answer: Annotated[WithValue, Field(description="what is answered: the number is {value}")] = VALUE
    field: Annotated[int, Field(ge=1, le=50, description="which of several answers between commas")] = 1
    scale: Annotated[float, Field(ge=1e-6, le=1e6, description="unit per number in the answer")] = 1.0
    offset: Annotated[float, Field(ge=-1e6, le=1e6, description="added after scaling, in the unit")] = 0.0

    def slope(self) -> tuple[float, float]:
        """Return slope and intercept from the number in the answer to degrees Celsius, or to K/min."""
        by, plus = factors(getattr(self, "unit"))  # noqa: B009 (the two kinds below have different ones)
        return by * self.scale, by * self.offset + plus

    def decoded(self, words: str) -> float:
        """Return what an answer means; OvenError of kind garbled where it is none."""
        before, after = self.answer.split(VALUE)
        fields = words.split(",")
        text = fields[self.field - 1].strip() if self.field <= len(fields) else ""
        inside = text[len(before) : len(text) - len(after)].strip()
        fits = len(text) >= len(before) + len(after) and text.startswith(before) and text.endswith(after)
        if not fits or NUMBER.fullmatch(inside) is None:
            raise garbled(words, f"{self.answer!r} as answer {self.field} to {self.query!r}")
        slope, intercept = self.slope()
        value = slope * float(inside) + intercept
        low, high = self.plausible
        if not low <= value <= high:  # a point lost from a number that no checksum guards
            raise garbled(words, f"{low:g} to {high:g} (it means {value:g}; see scale and unit)")
        return value


class TemperatureQuery(Query):
    """A temperature that is read."""

    plausible: ClassVar[tuple[float, float]] = PLAUSIBLE

    unit: Annotated[TemperatureUnit, Field(description="of the controller")] = "degC"


class Phrase(Query):
    """A number that is read and set."""

    command: Annotated[WithValue, Field(description="what sets it: SOUR:TEMP {value}")]
    decimals: Annotated[int, Field(ge=0, le=6, description="digits sent after the point")] = 1

    @property
    def resolution(self) -> float:
        """Smallest difference it can hold, K or K/min."""
        return self.slope()[0] * 10.0**-self.decimals

    def encoded(self, value: float) -> str:
        """Return the command that sets `value`."""
        slope, intercept = self.slope()
        return self.command.replace(VALUE, f"{(value - intercept) / slope:.{self.decimals}f}")


class TemperaturePhrase(Phrase):
    """A temperature that is read and set."""

    plausible: ClassVar[tuple[float, float]] = PLAUSIBLE

    unit: Annotated[TemperatureUnit, Field(description="in which the controller takes it")] = "degC"


class RatePhrase(Phrase):
    """A rate that is read and set."""

    unit: Annotated[RateUnit, Field(description="in which the controller takes it")] = "K/min"


class RunPhrase(Declared):
    """Starts and stops the controller."""

    on: Annotated[Sent, Field(description="command that starts it")]
    off: Annotated[Sent, Field(description="command that stops it")]
    query: Annotated[Sent, Field(description="asks whether it regulates")]
    is_on: Annotated[Answers, Field(description="answers that mean it does")] = ("1",)
    is_off: Annotated[Answers, Field(description="answers that mean it does not")] = ("0",)


class StatusPhrase(Declared):
    """Query of the alarm status."""

    query: Annotated[Sent, Field(description="queries the alarm status")]
    good: Annotated[Answers, Field(description="answers that mean none")]


def garbled(seen: str, wanted: str) -> OvenError:
    """Return the error for an answer that is not what it should be."""
    return OvenError(
        Fault.GARBLED,
        f"{seen[:60]!r} instead of {wanted}",
        "Check what is declared of the answer, baud rate and parity, the cable's shield and ground.",
    )


@dataclass(frozen=True)
class TextConnection:
    """The open line to such a controller."""

    line: Line
    terminator: bytes
    acknowledge: str
    retries: int

    def query(self, text: str, parse: Callable[[str], float] | Callable[[str], str]) -> float | str:
        """Send a query and return its answer, parsed by `parse`; sent again where the answer is garbled."""

        def once() -> float | str:
            answer = self.line.exchange(text.encode("ascii") + self.terminator, up_to(self.terminator))
            return parse(self._decoded(answer, text))

        return self.line.attempt(once)

    def command(self, text: str) -> None:
        """Send a command; wait for the acknowledgement where there is one."""

        def once() -> None:
            if not self.acknowledge:
                self.line.send(text.encode("ascii") + self.terminator)
                return
            answer = self.line.exchange(
                text.encode("ascii") + self.terminator,
                up_to(self.terminator),
                repeats=text == self.acknowledge,
            )
            reply = self._decoded(answer, text)
            if reply != self.acknowledge:
                raise garbled(reply, repr(self.acknowledge))

        self.line.attempt(once, writes=True)

    def _decoded(self, answer: bytes, sent: str) -> str:
        if not answer:
            raise OvenError(
                Fault.SILENT,
                f"no answer to {sent!r}",
                "Is it switched on and wired? Check port, baud rate, terminator, and the words declared.",
            )
        text = answer.decode("latin-1")
        reply = text.strip()
        if not text.endswith(self.terminator.decode()) or not re.fullmatch(r"[ -~]*", reply):
            raise garbled(text, "a line of text")
        return reply


@dataclass(frozen=True)
class TextValue:
    """A declared number that is read."""

    name: str
    connection: TextConnection
    declared: Query

    def read(self) -> float:
        """Ask for it."""
        return float(self.connection.query(self.declared.query, self.declared.decoded))


@dataclass(frozen=True)
class TextSetting(TextValue):
    """A declared number that is read and set."""

    declared: Phrase

    @property
    def resolution(self) -> float:
        """Smallest difference it can hold, K or K/min."""
        return self.declared.resolution

    def send(self, value: float) -> None:
        """Send its command."""
        self.connection.command(self.declared.encoded(value))

    def put(self, value: float) -> float:
        """Set it to `value`; sent again where it reads back otherwise, because the command carries no checksum."""
        tolerance = 0.5001 * self.resolution
        with self.connection.line.reserved():
            held = self.read()
            for _ in range(self.connection.retries + 1):
                if abs(held - value) <= tolerance:
                    return held
                self.send(value)
                held = self.read()
        if not abs(held - value) <= tolerance:
            raise not_taken(self.name, f"{value:g}", f"{held:g}")
        return held


@dataclass(frozen=True)
class TextSwitch:
    """The declared switch of a controller."""

    connection: TextConnection
    declared: RunPhrase

    def on(self) -> bool:
        """Ask whether it regulates."""
        return self.connection.query(self.declared.query, self._known) in self.declared.is_on

    def send(self, on: bool) -> None:
        """Send its command."""
        self.connection.command(self.declared.on if on else self.declared.off)

    def put(self, on: bool) -> None:
        """Switch, and read back; sent again where it reads back otherwise."""
        with self.connection.line.reserved():
            held = self.on()
            for _ in range(self.connection.retries + 1):
                if held == on:
                    return
                self.send(on)
                held = self.on()
        if held != on:
            raise not_taken("run", "on" if on else "off", "on" if held else "off")

    def _known(self, reply: str) -> str:
        if reply not in self.declared.is_on + self.declared.is_off:
            raise garbled(reply, f"one of {', '.join(self.declared.is_on + self.declared.is_off)}")
        return reply


def require_good_answer(connection: TextConnection, declared: StatusPhrase) -> None:
    """Raise OvenError of kind alarm where the status is not a good one, however often it is asked for.

    An answer carries no checksum, and an error that passes is not told from an alarm by its words.
    """

    def unparsed(reply: str) -> str:
        return reply

    for _ in range(max(connection.retries, 1) + 1):
        reply = str(connection.query(declared.query, unparsed))
        if reply in declared.good:
            return
    raise OvenError(
        Fault.ALARM,
        f"{declared.query!r} answers {reply!r}; good: {', '.join(declared.good)}",
        "Look at the controller's panel, remove the cause and acknowledge it there.",
        reply,
    )
