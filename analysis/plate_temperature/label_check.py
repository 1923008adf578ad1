"""Sweeps of a recorded campaign whose temperature cannot be true: by the air, and by their stiffness; in words.

The modulus of a plate is a smooth function of temperature. A sweep with a wrong temperature has the modulus of its
true one, and its neighbours tell which that is: T as a function of ln E, interpolated between them.

In air on a ramp of constant rate the plate is rate * tau behind the air: within one leg the difference of both is
the same in all sweeps, from the second on; before, it grows from zero. Up and down it has the opposite sign, and
half of the sum is the difference of the two sensors, which is the same at all temperatures.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.recordings.campaign import Sweep

MOST_NAMED = 6
"""That are named one by one; of more, their number is given."""
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
NEIGHBOURS = 4
"""Sweeps from which the temperature of one is interpolated, by a parabola."""
LEAST = 5
"""Sweeps of one leg that are needed: one to be judged, and its neighbours."""
WRONG, WRONG_AT_END = 1.0, 2.5
"""K that a temperature may be off its neighbours' before it is told, between them and at the ends of a leg."""
OF_SPACING = 0.35
"""Or this share of the distance of sweeps: by as much a glass transition bends a parabola through four points."""
OF_SCATTER = 6.0
"""Or so many times the median of all of the leg: estimates that scatter do not tell one from the others."""
REST_FITS = 0.5
"""Share of all deviations that may remain without the wrong sweep: of many that scatter none is wrong."""
HYSTERESIS = 1.0
"""Difference of up and down at equal modulus from which on it is told, K: half of it is in each label."""


def misplaced(temperature: Real, log_modulus: Real) -> dict[int, float]:
    """Return the temperature that the modulus of some sweeps of one leg stands for, by their place.

    Parameters
    ----------
    temperature : (T,) ndarray
        Labels, degrees Celsius.
    log_modulus : (T,) ndarray
        ln E.

    Returns
    -------
    dict of int to float
        Degrees Celsius; empty where all fit, or fewer than `LEAST` are given.
    """
    left, found = list(range(len(temperature))), dict[int, float]()
    while len(left) >= LEAST:
        before = np.abs(_interpolated(temperature[left], log_modulus[left]) - temperature[left])
        if before.max() <= WRONG:
            break
        # One wrong sweep spoils what is interpolated for its neighbours: without it the rest fits best.
        rest = [np.delete(left, one) for one in range(len(left))]
        off = [np.abs(_interpolated(temperature[of], log_modulus[of]) - temperature[of]) for of in rest]
        worst = int(np.argmin([one.sum() for one in off]))
        likely = _at_neighbours(temperature, log_modulus, rest[worst], left[worst])
        allowed = _allowed(temperature[left], worst, float(np.median(off[worst])))
        if abs(likely - temperature[left[worst]]) <= allowed or off[worst].sum() > REST_FITS * before.sum():
            break
        found[left[worst]] = likely
        del left[worst]
    return found


def hysteresis(up: tuple[Real, Real], down: tuple[Real, Real]) -> float | None:
    """Return by how much labels on the way up exceed those on the way down at equal modulus, K.

    Parameters
    ----------
    up, down : ((T,) ndarray, (T,) ndarray)
        Labels, degrees Celsius, and ln E.

    Returns
    -------
    float or None
        Median over the moduli of both legs; None where they share fewer than three, or it is small.
    """
    order = np.argsort(down[1])
    modulus, label = down[1][order], down[0][order]
    if modulus.size < LEAST:
        return None
    inside = (up[1] >= modulus[0]) & (up[1] <= modulus[-1])
    if inside.sum() < 3:
        return None
    found = float(np.median(up[0][inside] - np.interp(up[1][inside], modulus, label)))
    return found if abs(found) > HYSTERESIS else None


def _interpolated(temperature: Real, log_modulus: Real) -> Real:
    """Temperature of each sweep by the moduli of its neighbours."""
    every = range(len(temperature))
    return np.array([_at_neighbours(temperature, log_modulus, np.delete(every, one), one) for one in every])


def _at_neighbours(temperature: Real, log_modulus: Real, others: NDArray[np.int_], one: int) -> float:
    near = others[np.argsort(np.abs(temperature[others] - temperature[one]), kind="stable")[:NEIGHBOURS]]
    return _parabola(log_modulus[near], temperature[near], float(log_modulus[one]))


def _parabola(x: Real, y: Real, at: float) -> float:
    """Value at a point of the parabola through points, by least squares."""
    middle, width = float(x.mean()), float(np.ptp(x)) or 1.0
    return float(np.polyval(np.polyfit((x - middle) / width, y, 2), (at - middle) / width))


def _allowed(temperature: Real, one: int, scatter: float) -> float:
    spacing = float(np.median(np.diff(np.sort(temperature))))
    allowed = max(WRONG, OF_SPACING * spacing, OF_SCATTER * scatter)
    at_end = temperature[one] in (temperature.min(), temperature.max())
    return max(allowed, WRONG_AT_END, spacing) if at_end else allowed


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


def said_of_doubts(doubts: Mapping[str, str], many: str) -> list[str]:
    """Return a note for each of the first, and one for the others.

    Parameters
    ----------
    doubts : mapping of str to str
        Why, by the name that people know it by.
    many : str
        What they are: ``sweeps``, ``hits``.
    """
    notes = [f"the temperature of {name} is in doubt: {why}" for name, why in doubts.items()]
    if len(notes) > MOST_NAMED:
        notes = [*notes[:MOST_NAMED], f"and the temperature of {len(notes) - MOST_NAMED} more {many} is in doubt"]
    return notes
