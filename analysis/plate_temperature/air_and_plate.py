"""Air against plate in the sweeps of a recorded campaign, of which only readings before and after each are known.

On a ramp of constant rate the plate is rate * tau behind the air: within one leg the difference of both is the
same in all sweeps, from the second on; before, it grows from zero. Up and down it has the opposite sign, and half
of the sum is the difference of the two sensors, which is the same at all temperatures.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from analysis.recordings.campaign import Sweep

STEADY, STEADY_SHARE = 1.0, 0.25
"""Deviation from the median of a leg from which on it is told: K, and share of that median. Regulators swing by
some tenths of a kelvin, and time constants change by a tenth over a leg."""
AHEAD = 1.5
"""How far the plate may be ahead of the air, K: the offset of the sensors, and a ramp that has just turned."""
MOVED = 0.6
"""How much more than the air the plate may move within a sweep, K."""
VARIES = 0.8
"""Change of the difference of both sensors over a campaign from which on it is told, K."""
SAME = 1.5
"""Sweeps up and down within it are at the same temperature, K."""


def doubtful_sweeps(sweeps: Sequence[Sweep]) -> dict[int, str]:
    """Return why the plate's temperature cannot be true in some sweeps, by the air's.

    Parameters
    ----------
    sweeps : sequence of Sweep
        In the order recorded; those without a sensor on the plate are not judged.

    Returns
    -------
    dict of int to str
        By the sweep's place in `sweeps`.
    """
    found: dict[int, str] = {}
    for leg in _legs(sweeps):
        sign = 1.0 if sweeps[leg[0]].direction == "up" else -1.0
        ahead = np.array([sign * _difference(sweeps[one]) for one in leg])
        for place, one in enumerate(leg):
            others = np.delete(ahead, place)
            low, high = -AHEAD, np.inf
            if len(others) > 1:
                usual = float(np.median(others))
                reach = STEADY + STEADY_SHARE * abs(usual)
                low, high = usual - reach, usual + reach
                if place == 0:
                    low, high = min(-STEADY, low), max(STEADY, high)
            if not low <= ahead[place] <= high:
                found[one] = f"{_told(sweeps[one])}; {_expected(sign, low, high)}"
    for one, sweep in enumerate(sweeps):
        if sweep.plate_temperature_start is None or sweep.plate_temperature_end is None:
            continue
        moved = sweep.plate_temperature_end - sweep.plate_temperature_start
        if abs(moved) > MOVED + abs(sweep.oven_temperature_end - sweep.oven_temperature_start):
            found.setdefault(one, f"the plate's reading moved by {moved:+.1f} K during the sweep, the oven's less")
    return found


def offset_change(sweeps: Sequence[Sweep], leave_out: Sequence[int] = ()) -> tuple[float, float, float] | None:
    """Return how much the difference of both sensors changes with temperature, if that is too much.

    Parameters
    ----------
    leave_out : sequence of int
        Places of sweeps that are in doubt already.

    Returns
    -------
    (change, coldest, hottest) : (float, float, float) or None
        K of plate over air, and the temperatures it is between, degrees Celsius. None where it is small, or where
        the campaign has no way back, by which the lag cancels.
    """
    both: dict[str, list[tuple[float, float]]] = {"up": [], "down": []}
    for one, sweep in enumerate(sweeps):
        if one not in leave_out and sweep.plate_temperature_start is not None:
            both[sweep.direction].append((sweep.temperature, -_difference(sweep)))
    points = []
    for temperature, offset in both["up"]:
        near = [other for other in both["down"] if abs(other[0] - temperature) <= SAME]
        if near:
            points.append((temperature, 0.5 * (offset + float(np.mean([other[1] for other in near])))))
    if len(points) < 3:
        return None
    temperature, offset = np.array(points).T
    slope = np.polyfit(temperature, offset, 1)[0]
    change = float(slope * np.ptp(temperature))
    return (change, float(temperature.min()), float(temperature.max())) if abs(change) > VARIES else None


def _legs(sweeps: Sequence[Sweep]) -> Iterator[list[int]]:
    """Places of the sweeps of each leg whose plate has a sensor."""
    leg: list[int] = []
    for one, sweep in enumerate(sweeps):
        if sweep.plate_temperature_start is None:
            continue
        before = sweeps[leg[-1]] if leg else sweep
        if leg and (before.direction, before.source) != (sweep.direction, sweep.source):
            yield leg
            leg = []
        leg.append(one)
    if leg:
        yield leg


def _difference(sweep: Sweep) -> float:
    return sweep.oven_temperature - sweep.temperature


def _told(sweep: Sweep) -> str:
    return f"oven {sweep.oven_temperature:.1f} °C, plate {sweep.temperature:.1f} °C"


def _expected(sign: float, low: float, high: float) -> str:
    ends = sorted((sign * low, sign * high))
    if np.isinf(high):
        return f"on this ramp the plate cannot be {-low:g} K ahead of the air"
    return f"by the other sweeps of this leg the oven should be {ends[0]:+.1f} to {ends[1]:+.1f} K from the plate"
