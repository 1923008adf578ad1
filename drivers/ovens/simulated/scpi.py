"""A simulated controller that answers the queries and commands declared in an experiment's file."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from drivers.ovens.simulated.controller import LineController
from drivers.ovens.simulated.declared_oven import DeclaredOven
from drivers.ovens.simulated.modbus_map import CELSIUS, PER_MINUTE
from drivers.ovens.simulated.regulated_oven import RegulatedOven

if TYPE_CHECKING:
    from drivers.ovens.scpi import ScpiOven
    from drivers.ovens.text_protocol import Phrase, Query


class SimulatedScpi(LineController):
    """Holds set-point, rate and switch, returns temperatures, and does not answer anything else, as SCPI requires.

    Parameters
    ----------
    declared : ScpiOven
    oven : RegulatedOven

    Attributes
    ----------
    locked : bool
        Forgets commands.
    alarm : bool
        Its status is no good one.
    """

    def __init__(self, declared: "ScpiOven", oven: RegulatedOven) -> None:
        super().__init__(declared.terminator.encode("ascii"))
        self._declared = declared
        self._oven = oven
        self._held = DeclaredOven(declared, oven)
        self.locked = False
        self.alarm = False

    def answer(self, command: str) -> str:
        """Answer a query, or take a command."""
        declared, oven, words = self._declared, self._oven, command.strip()
        for query, value in (
            (declared.temperature, oven.measured),
            (declared.set_point, self._held.target),
            (declared.working_set_point, oven.working),
            (declared.rate, self._held.rate),
        ):
            if query is not None and words == query.query:
                return _answer(query, value)
        if declared.run is not None and words == declared.run.query:
            return declared.run.is_on[0] if self._held.running else declared.run.is_off[0]
        if declared.status is not None and words == declared.status.query:
            return "TROUBLE" if self.alarm else declared.status.good[0]
        return declared.acknowledge if self._take(words) else ""

    def _take(self, words: str) -> bool:
        """Whether these words are a command; obeyed unless it is locked."""
        declared, held = self._declared, self._held
        target, rate, on = held.target, held.rate, held.on
        if declared.run is not None and words in (declared.run.on, declared.run.off):
            on = words == declared.run.on
        elif (value := _number(declared.set_point, words)) is not None:
            target = value
        elif declared.rate is not None and (value := _number(declared.rate, words)) is not None:
            rate = value
        else:
            return False
        if not self.locked:
            held.target, held.rate, held.on = target, rate, on
            held.drive()
        return True


class SimulatedQueries(LineController):
    """A meter that answers every query of `sensors` with one temperature, and nothing else.

    Parameters
    ----------
    terminator : str
    sensors : sequence of Query
    value : callable
        degrees Celsius.
    """

    def __init__(self, terminator: str, sensors: Sequence["Query"], value: Callable[[], float]) -> None:
        super().__init__(terminator.encode("ascii"))
        self._sensors, self._value = tuple(sensors), value

    def answer(self, command: str) -> str:
        """Answer a query."""
        asked = [sensor for sensor in self._sensors if sensor.query == command.strip()]
        return _answer(asked[0], self._value()) if asked else ""


def _per_unit(query: "Query") -> tuple[float, float]:
    unit = getattr(query, "unit", "degC")
    return CELSIUS[unit] if unit in CELSIUS else (PER_MINUTE[unit], 0.0)


def _answer(query: "Query", value: float) -> str:
    by, plus = _per_unit(query)
    number = (by * value + plus - query.offset) / query.scale
    fields = ["0"] * (query.field - 1)
    return ",".join([*fields, query.answer.replace("{value}", f"{number:.3f}")])


def _number(phrase: "Phrase", words: str) -> float | None:
    """Return what a command sets, degrees Celsius or K/min; None for any other command."""
    before, after = phrase.command.split("{value}")
    if not (words.startswith(before) and words.endswith(after)):
        return None
    try:
        number = float(words[len(before) : len(words) - len(after)])
    except ValueError:
        return None
    by, plus = _per_unit(phrase)
    return (phrase.scale * number + phrase.offset - plus) / by
