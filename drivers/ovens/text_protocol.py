"""A controller's text protocol, one line per message: its declared values, settings and switch."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from drivers.clock import Clock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Transport, up_to
from drivers.ovens.line_settings import LineSettings
from drivers.ovens.phrases import Phrase, Query, RunPhrase, StatusPhrase, garbled
from drivers.ovens.points import not_taken


class TextLine(LineSettings):
    """A controller whose messages are lines of text."""

    terminator: Annotated[Literal["\n", "\r", "\r\n"], Field(description="ends each line")] = "\n"
    acknowledge: Annotated[str, Field(max_length=200, description="answer to a command; empty: none")] = ""

    def connection(self, clock: Clock, transport: Transport | None) -> "TextConnection":
        """Open the line."""
        return TextConnection(
            self.line(clock, transport), self.terminator.encode(), self.acknowledge, self.retries
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


def require_good(connection: TextConnection, declared: StatusPhrase) -> None:
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
