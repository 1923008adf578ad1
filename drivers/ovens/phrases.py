"""Queries and commands of text as an experiment's file declares them, and what is taken out of the answers.

Nothing declared is run: ``{value}`` is replaced by a number in a command; in an answer, what stands before and
after it is compared letter by letter, and the rest has to be one number of `NUMBER`.
"""

import math
import re
from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field

from analysis.declared import Declared
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.points import PLAUSIBLE
from drivers.ovens.units import RateUnit, TemperatureUnit, factors

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
