"""A line of text, and the declared numbers and switches that are asked and told on it."""

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
    """A controller that takes lines of text."""

    terminator: Annotated[Literal["\n", "\r", "\r\n"], Field(description="ends each line")] = "\n"
    acknowledge: Annotated[str, Field(max_length=200, description="answer to a command; empty: none")] = ""

    def speaker(self, clock: Clock, transport: Transport | None) -> "Speaker":
        """Open the line."""
        return Speaker(self.line(clock, transport), self.terminator.encode(), self.acknowledge, self.retries)


@dataclass(frozen=True)
class Speaker:
    """A line of text, ready for use."""

    line: Line
    terminator: bytes
    acknowledge: str
    retries: int

    def ask(self, query: str, take: Callable[[str], float] | Callable[[str], str]) -> float | str:
        """Return what `take` makes of the answer; asked again where that is garbled."""

        def once() -> float | str:
            answer = self.line.exchange(query.encode("ascii") + self.terminator, up_to(self.terminator))
            return take(self._words(answer, query))

        return self.line.attempt(once)

    def tell(self, command: str) -> None:
        """Send a command; wait for the acknowledgement where there is one."""

        def once() -> None:
            if not self.acknowledge:
                self.line.send(command.encode("ascii") + self.terminator)
                return
            answer = self.line.exchange(command.encode("ascii") + self.terminator, up_to(self.terminator))
            words = self._words(answer, command)
            if words != self.acknowledge:
                raise garbled(words, repr(self.acknowledge))

        self.line.attempt(once, writes=True)

    def _words(self, answer: bytes, asked: str) -> str:
        if not answer:
            raise OvenError(
                Fault.SILENT,
                f"no answer to {asked!r}",
                "Is it switched on and wired? Check port, baud rate, terminator, and the words declared.",
            )
        text = answer.decode("latin-1")
        words = text.strip()
        if not text.endswith(self.terminator.decode()) or not re.fullmatch(r"[ -~]*", words):
            raise garbled(text, "a line of text")
        return words


@dataclass(frozen=True)
class Told:
    """A declared number that is told, and, where it is a `Phrase`, set."""

    name: str
    speaker: Speaker
    declared: Query

    def read(self) -> float:
        """Ask for it."""
        return float(self.speaker.ask(self.declared.query, self.declared.decoded))


@dataclass(frozen=True)
class Spoken(Told):
    """A declared number that is told and set."""

    declared: Phrase

    @property
    def resolution(self) -> float:
        """Smallest difference it can hold, K or K/min."""
        return self.declared.resolution

    def put(self, value: float) -> float:
        """Make it hold `value`: told again where it reads back otherwise, for no checksum guards the command."""
        tolerance = 0.5001 * self.resolution
        with self.speaker.line.reserved():
            held = self.read()
            for _ in range(self.speaker.retries + 1):
                if abs(held - value) <= tolerance:
                    return held
                self.speaker.tell(self.declared.encoded(value))
                held = self.read()
        if not abs(held - value) <= tolerance:
            raise not_taken(self.name, f"{value:g}", f"{held:g}")
        return held


@dataclass(frozen=True)
class RunSpoken:
    """The declared switch of a controller."""

    speaker: Speaker
    declared: RunPhrase

    def on(self) -> bool:
        """Ask whether it regulates."""
        return self.speaker.ask(self.declared.query, self._known) in self.declared.is_on

    def put(self, on: bool) -> None:
        """Switch, and read back: told again where it reads back otherwise."""
        with self.speaker.line.reserved():
            held = self.on()
            for _ in range(self.speaker.retries + 1):
                if held == on:
                    return
                self.speaker.tell(self.declared.on if on else self.declared.off)
                held = self.on()
        if held != on:
            raise not_taken("run", "on" if on else "off", "on" if held else "off")

    def _known(self, words: str) -> str:
        if words not in self.declared.is_on + self.declared.is_off:
            raise garbled(words, f"one of {', '.join(self.declared.is_on + self.declared.is_off)}")
        return words


def require_good(speaker: Speaker, declared: StatusPhrase) -> None:
    """Raise OvenError of kind alarm where the status is, twice, no good one: it carries no checksum."""

    def same(words: str) -> str:
        return words

    for _ in range(2):
        words = str(speaker.ask(declared.query, same))
        if words in declared.good:
            return
    raise OvenError(
        Fault.ALARM,
        f"{declared.query!r} answers {words!r}; good: {', '.join(declared.good)}",
        "Look at the controller's panel, remove the cause and acknowledge it there.",
        words,
    )
