"""The temperature programme, and the oven's set-point, as lines over time."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.protocol.protocol import AcquisitionProtocol


@dataclass(frozen=True)
class Course:
    """The part of a temperature programme that is still to come.

    Attributes
    ----------
    time, temperature : (C,) ndarray
        Corners, s from its beginning and degrees Celsius.
    asked_at, asked : (P,) ndarray
        When it meets each set-point, s, and its temperature, degrees Celsius.
    """

    time: Real
    temperature: Real
    asked_at: Real
    asked: Real


def course(
    protocol: AcquisitionProtocol,
    start: float,
    done: Collection[int] = (),
    begun: Collection[int] = (),
    ramping: int | None = None,
) -> Course:
    """Return the programme as `AcquisitionProtocol.seconds` reckons it and a campaign that is continued runs it.

    Parameters
    ----------
    start : float
        Temperature at its beginning, degrees Celsius.
    done : collection of int
        Steps that are finished or given up: a leg without others is left out.
    begun : collection of int
        Legs whose ramp was begun before: it begins anew one lead before the next set-point.
    ramping : int, optional
        Leg in whose ramp the oven still is.
    """
    programme = protocol.programme
    time, temperature = [0.0], [start]
    asked_at: list[float] = []
    asked: list[float] = []

    def then(duration: float, here: float) -> None:
        time.append(time[-1] + duration)
        temperature.append(here)

    for leg in protocol.legs:
        todo = [point for point in leg.set_points if point.step not in done]
        if not todo:
            continue
        if leg.number != ramping:
            along = (
                leg.sign * todo[0].temperature - programme.lead if leg.number in begun else leg.sign * leg.start
            )
            from_here = leg.sign * max(along, leg.sign * leg.start)
            then(60.0 * abs(from_here - temperature[-1]) / programme.to_start, from_here)
            then(max(programme.soak_before, programme.settling.lasting), from_here)
        asked_at += [
            time[-1] + 60.0 * max(leg.sign * (point.temperature - temperature[-1]), 0.0) / programme.ramp_rate
            for point in todo
        ]
        asked += [point.temperature for point in todo]
        then(60.0 * abs(leg.end - temperature[-1]) / programme.ramp_rate, leg.end)
    then(programme.soak_after, temperature[-1])
    return Course(*(np.array(values) for values in (time, temperature, asked_at, asked)))


def set_point_line(
    commands: Sequence[Mapping[str, Any]], when: Sequence[float], at: Real, air: Real, now: float
) -> tuple[Real, Real]:
    """Set-point that follows from the commands sent to the oven; NaN while it is at rest.

    Parameters
    ----------
    commands : sequence of mapping
        Events of the kind ``oven``.
    when : sequence of float
        Their times, s.
    at, air : (R,) ndarray
        Times, s, and temperatures read, degrees Celsius: a ramp begins where the air is.
    now : float
        Time up to which the last command counts, s.

    Returns
    -------
    time, value : (n,) ndarray
        Corners of the line, s and degrees Celsius.
    """
    time: list[float] = []
    value: list[float] = []
    for command, begun, ended in zip(commands, when, [*when[1:], now], strict=False):
        here = float(np.interp(begun, at, air)) if at.size else math.nan
        if command["command"] == "safe":
            time, value = [*time, begun], [*value, math.nan]
            continue
        target = float(command["target"]) if command["command"] == "ramp" else here
        rate = float(command.get("rate", 1.0)) / 60.0
        arrives = min(begun + abs(target - here) / rate, ended) if math.isfinite(here) else begun
        reached = here + math.copysign(rate * (arrives - begun), target - here)
        time += [begun, arrives, ended]
        value += [here, reached, reached]
    return np.array(time), np.array(value)
