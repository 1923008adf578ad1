"""The sweeps a protocol asks for, held against those that are there."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, product

from analysis.experiment import Protocol
from analysis.recordings.campaign import Sweep
from app.files.campaign_error import Problem

MOST_SWEEPS = 10_000
"""Sweeps in one campaign: steps are numbered with four digits."""
LARGEST_OVEN_DEVIATION = 2.0
"""Largest distance of an oven reading from its nominal temperature, K."""


@dataclass(frozen=True)
class Place:
    """Where in the protocol a sweep belongs; `unit` is that of the input's levels."""

    temperature: float
    direction: str
    level: float
    source: int = 0
    unit: str = field(default="V", compare=False)

    def __str__(self) -> str:
        driven = f" from input {self.source + 1}" if self.source else ""
        return f"{self.temperature:g} °C {self.direction} {self.level:g} {self.unit}{driven}"


def places(protocol: Protocol) -> tuple[Place, ...]:
    """Every sweep the protocol asks for: up through the temperatures, down in reverse, all levels at each.

    Raises ValueError if there are more than four digits can number.
    """
    count = len(protocol.temperatures) * len(protocol.directions) * len(protocol.levels)
    if count > MOST_SWEEPS:
        raise ValueError(f"temperatures x directions x levels is {count} sweeps; allowed 1 to {MOST_SWEEPS}")
    legs = {"up": protocol.temperatures, "down": protocol.temperatures[::-1]}
    return tuple(
        Place(temperature, direction, level)
        for direction in protocol.directions
        for temperature, level in product(legs[direction], protocol.levels)
    )


def place_of(protocol: Protocol, sweep: Sweep, unit: str = "V") -> Place | None:
    """Find where a sweep belongs; None if its level, direction or temperature fits nowhere.

    The reading must be nearer to its nominal temperature than 0.4 of the way to a neighbour.

    Parameters
    ----------
    unit : str
        Of the input's levels.
    """
    nominal = protocol.temperatures
    nearest = min(range(len(nominal)), key=lambda i: abs(nominal[i] - sweep.temperature))
    gaps = [abs(nominal[i] - nominal[nearest]) for i in (nearest - 1, nearest + 1) if 0 <= i < len(nominal)]
    reach = min([0.4 * gap for gap in gaps] + [LARGEST_OVEN_DEVIATION])
    level = next((v for v in protocol.levels if abs(v - sweep.level) <= 1e-6 * v), None)
    near = abs(nominal[nearest] - sweep.temperature) <= reach
    if level is None or not near or sweep.direction not in protocol.directions:
        return None
    return Place(nominal[nearest], sweep.direction, level, sweep.source, unit)


def coverage_problems(
    protocol: Protocol, sweeps: Mapping[str, Sweep], units: Sequence[str] = ("V",)
) -> Iterator[Problem]:
    """Yield sweeps that fit nowhere, come twice, or were recorded out of order.

    Parameters
    ----------
    sweeps : mapping
        By file name.
    units : sequence of str
        Of each input's levels.
    """
    minutes = protocol.repeats * protocol.record / 60.0
    most_drift = LARGEST_OVEN_DEVIATION + 3.0 * protocol.ramp_rate * minutes
    found: dict[Place, str] = {}
    numbers: dict[int, str] = {}
    for name, sweep in sweeps.items():
        if sweep.step in numbers:
            yield Problem(
                name, "step", f"{sweep.step}", f"a number of its own; {numbers[sweep.step]} has this one"
            )
        numbers.setdefault(sweep.step, name)
        drift = abs(sweep.oven_temperature_end - sweep.oven_temperature_start)
        if drift > most_drift:
            seen = f"{sweep.oven_temperature_end:g} °C, {drift:.3g} K from oven_temperature_start"
            yield Problem(name, "oven_temperature_end", seen, f"0 to {most_drift:.3g} K at protocol.ramp_rate")
        unit = units[sweep.source]
        place = place_of(protocol, sweep, unit)
        if place is None:
            yield _fits_nowhere(protocol, name, sweep, unit)
        elif place in found:
            yield Problem(name, "sweep", str(place), f"one file for it; {found[place]} is another")
        else:
            found[place] = name
    yield from _out_of_order(found, sweeps)


def missing_places(
    protocol: Protocol, sweeps: Mapping[str, Sweep], units: Sequence[str] = ("V",)
) -> tuple[Place, ...]:
    """Return what the protocol asks for and no sweep brings.

    Parameters
    ----------
    sweeps : mapping
        By file name.
    units : sequence of str
        Of the levels of each input; the inputs drive in turn. Of several, each is asked for the levels at which it
        drove anywhere, or at all levels where nowhere: a level in volts is none of a force's.
    """
    there = {place for sweep in sweeps.values() if (place := place_of(protocol, sweep)) is not None}
    used = {(place.source, place.level) for place in there}
    idle = set(range(len(units))) - {source for source, _ in used}
    wanted = (
        replace(place, source=source, unit=unit) for source, unit in enumerate(units) for place in places(protocol)
    )
    return tuple(
        place
        for place in wanted
        if place not in there and (len(units) == 1 or place.source in idle or (place.source, place.level) in used)
    )


def _fits_nowhere(protocol: Protocol, name: str, sweep: Sweep, unit: str) -> Problem:
    if sweep.direction not in protocol.directions:
        return Problem(
            name, "direction", repr(sweep.direction), f"protocol.directions {list(protocol.directions)}"
        )
    if not any(abs(v - sweep.level) <= 1e-6 * v for v in protocol.levels):
        return Problem(name, "level", f"{sweep.level:g} {unit}", f"protocol.levels {list(protocol.levels)}")
    nearest = min(protocol.temperatures, key=lambda t: abs(t - sweep.temperature))
    seen = f"{sweep.oven_temperature_start:g} to {sweep.oven_temperature_end:g} °C"
    allowed = f"near one of protocol.temperatures, of which {nearest:g} °C is the nearest"
    return Problem(name, "oven_temperature_start, _end", seen, allowed, "is the property in °C?")


def _out_of_order(found: Mapping[Place, str], sweeps: Mapping[str, Sweep]) -> Iterator[Problem]:
    """Each leg at each level must climb (or fall) through the temperatures in the order recorded."""
    legs: dict[tuple[str, float, int], list[Place]] = {}
    for place in sorted(found, key=lambda place: sweeps[found[place]].step):
        legs.setdefault((place.direction, place.level, place.source), []).append(place)
    for (direction, *_), leg in legs.items():
        for before, after in pairwise(leg):
            if (after.temperature > before.temperature) != (direction == "up"):
                step = sweeps[found[after]].step
                allowed = (
                    f"{'above' if direction == 'up' else 'below'} the {before.temperature:g} °C of the step before"
                )
                yield Problem(found[after], f"temperature of step {step}", f"{after.temperature:g} °C", allowed)
