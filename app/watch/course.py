"""The temperature programme, and the oven's set-point, as lines over time."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.protocol.protocol import AcquisitionProtocol


def programme_line(protocol: AcquisitionProtocol, start: float) -> tuple[Real, Real]:
    """Corners of the programme as `AcquisitionProtocol.seconds` reckons it: (C,) s and (C,) degrees Celsius.

    Parameters
    ----------
    protocol : AcquisitionProtocol
    start : float
        Temperature at its beginning, degrees Celsius.
    """
    programme = protocol.programme
    time, temperature = [0.0], [start]

    def then(duration: float, here: float) -> None:
        time.append(time[-1] + duration)
        temperature.append(here)

    for leg in protocol.legs:
        then(60.0 * abs(leg.start - temperature[-1]) / programme.to_start, leg.start)
        then(max(programme.soak_before, programme.settling.lasting), leg.start)
        then(60.0 * abs(leg.end - leg.start) / programme.ramp_rate, leg.end)
    then(programme.soak_after, temperature[-1])
    return np.array(time), np.array(temperature)


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
