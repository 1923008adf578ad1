"""All sensors of a plate: a wrong one is left out where another remains, and labels in doubt are told."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from analysis.arrays import Real
from analysis.plate_temperature.sensor_check import (
    DOUBTED,
    GOOD_FOR,
    MEMORY,
    MISLABELLED,
    SensorCheck,
    Trust,
    Verdict,
    share_of_last,
)

APART = 0.6
"""Mean difference of two sensors from which on one of them is wrong, K: twice the gradient of a thin plate."""
WORSE = 2.0
"""The wrong one of two does not fit the air by so many times as much as the other."""
GIVEN_UP = 30.0
"""A sensor that is worse than another one for so long, s, is not used again: a loose contact comes and goes."""


@dataclass(frozen=True)
class PlateReading:
    """What the sensors say together.

    Attributes
    ----------
    temperature : float or None
        Degrees Celsius; None where no sensor is believed.
    why : str
        What is wrong where there is none.
    doubts : tuple of str
        Why the temperature may be wrong by more than it should.
    left_out : tuple of str
        Sensors that are not used from now on, each with the reason.
    """

    temperature: float | None
    why: str = ""
    doubts: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()


LOOKED_BACK = 8.0 * MEMORY
"""How long before a doubt begins its cause may have begun, s."""

Moments = dict[int, tuple[Real, Real, float]]


class PlateSensors:
    """Judges and combines the readings of all sensors of a plate.

    Parameters
    ----------
    names : sequence of str
        Of the sensors, for messages.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._checks = [SensorCheck(name) for name in names]
        self._used = list(range(len(names)))
        self._unused_since: dict[int, float] = {}
        self._apart: dict[tuple[int, int], float] = {}
        self._last = -math.inf
        self._judged: dict[int, tuple[float, Moments]] = {}
        self._doubted: set[int] = set()
        self._late: dict[int, str] = {}
        self._slow: dict[int, str] = {}

    def fit(self, now: float, air: float, readings: Sequence[float]) -> bool:
        """Whether no sensor in use has jumped; to read again where one has.

        Parameters
        ----------
        now : float
            s.
        air : float
            Degrees Celsius.
        readings : sequence of float
            One of every sensor, degrees Celsius.
        """
        return all(self._checks[one].fits(now, air, readings[one]) for one in self._used)

    def judge(self, now: float, air: float, readings: Sequence[float]) -> PlateReading:
        """Judge one reading of every sensor.

        Parameters
        ----------
        now : float
            s.
        air : float
            Degrees Celsius.
        readings : sequence of float
            One of every sensor, degrees Celsius.
        """
        verdicts = {one: self._checks[one].judge(now, air, readings[one]) for one in self._used}
        trusted = max((verdict.trust for verdict in verdicts.values()), default=Trust.REFUSED)
        believed = [one for one in self._used if verdicts[one].trust is trusted is not Trust.REFUSED]
        self._look_back(now, verdicts)
        self._compare(now, [one for one in self._used if verdicts[one].trust is not Trust.REFUSED], readings)
        wrong = {one: verdicts[one].why for one in self._lasting(now, believed)}
        wrong |= self._worse(believed, {one: verdicts[one].why for one in believed})
        sound = [one for one in believed if one not in wrong]
        left_out: tuple[str, ...] = ()
        if sound and wrong:
            self._used = [one for one in self._used if one not in wrong]
            left_out = tuple(wrong[one] for one in wrong)
            believed = sound
        if not believed:
            return PlateReading(None, "; ".join(verdicts[one].why for one in self._used))
        for one in believed:
            lasting = self._slowly_wrong(one) if self._error(one) else self._checks[one].lasting_doubt()
            if lasting:
                self._slow.setdefault(one, lasting)
        doubts = [verdicts[one].why or self._slow.get(one, "") for one in believed]
        doubts = [why for why in doubts if why]
        doubts += self._disagreements(believed)
        mean = sum(readings[one] for one in believed) / len(believed)
        return PlateReading(mean, "", tuple(doubts), left_out)

    def mark(self, step: int) -> None:
        """Remember the last readings as those of a sweep, to be judged again by all that is learnt later."""
        moments = {one: self._checks[one].moment for one in self._used}
        self._judged[step] = self._last, {one: moment for one, moment in moments.items() if moment is not None}

    def mislabelled(self) -> dict[int, str]:
        """Return why the labels of marked sweeps are in doubt by what was learnt later, by step.

        A sensor that was found slowly wrong at any time puts all labels in doubt to which it contributed: the
        causes that are estimated act throughout, and one that began in between is taken for one of them.
        """
        found = {}
        errors = {step: self._errors(moments) for step, (_, moments) in self._judged.items()}
        means = {step: sum(of.values()) / max(len(of), 1) for step, of in errors.items()}
        wrong = any(abs(mean) > MISLABELLED for mean in means.values())
        unknown = self._not_bounded()
        for step, of in errors.items():
            slow = [self._slow[one] for one in of if one in self._slow]
            if wrong and abs(means[step]) > 0.0:
                worst = max(of, key=lambda one: abs(of[one]))
                check, moment = self._checks[worst], self._judged[step][1][worst]
                than = "high" if means[step] > 0.0 else "low"
                found[step] = f"about {abs(means[step]):.1f} K too {than}; {check.name}: {check.cause(moment)}"
            elif wrong or slow:
                found[step] = "; ".join(slow) or "other labels of this sensor are wrong"
            elif unknown:
                found[step] = unknown
        return {**found, **self._late}

    def _not_bounded(self) -> str:
        """Say which sensors are wrong by an amount that is not known, if a label may be too wrong by it."""
        bounds = [
            {one: self._checks[one].largest_error(moment) / len(moments) for one, moment in moments.items()}
            for _, moments in self._judged.values()
        ]
        if max((sum(of.values()) for of in bounds), default=0.0) <= GOOD_FOR:
            return ""
        names = [self._checks[one].name for one in sorted({one for of in bounds for one in of if of[one] > 0.0})]
        whose = " and ".join(names)
        return f"{whose} does not follow the air as a sensor on a plate does; its errors may exceed {GOOD_FOR:g} K"

    def _errors(self, moments: Moments) -> dict[int, float]:
        return {one: self._checks[one].error(moment) for one, moment in moments.items()}

    def _look_back(self, now: float, verdicts: dict[int, Verdict]) -> None:
        """Doubt sweeps made shortly before a doubt began: it takes minutes until one shows, unlike a jump."""
        for one, verdict in verdicts.items():
            if verdict.trust is Trust.DOUBTED and one not in self._doubted:
                recent = [step for step, (made, _) in self._judged.items() if now - made <= LOOKED_BACK]
                why = f"shortly afterwards, {verdict.why}"
                self._late |= {step: why for step in recent if step not in self._late}
        self._doubted = {one for one, verdict in verdicts.items() if verdict.why}

    def _compare(self, now: float, believed: Sequence[int], readings: Sequence[float]) -> None:
        share = share_of_last(now - self._last)
        self._last = now
        for pair in combinations(believed, 2):
            before = self._apart.get(pair, 0.0)
            self._apart[pair] = before + share * (readings[pair[0]] - readings[pair[1]] - before)

    def _lasting(self, now: float, believed: Sequence[int]) -> list[int]:
        """Sensors not believed for too long, others being believed."""
        for one in self._used:
            if one in believed:
                self._unused_since.pop(one, None)
            else:
                self._unused_since.setdefault(one, now)
        return [one for one, since in self._unused_since.items() if now - since >= GIVEN_UP and one in self._used]

    def _worse(self, believed: Sequence[int], whys: dict[int, str]) -> dict[int, str]:
        """Sensors in doubt although another one, that reads something else, is in none."""
        found = {}
        for first, second in combinations(believed, 2):
            if abs(self._apart[first, second]) <= APART:
                continue
            bad = {one: self._misfit(one) for one in (first, second)}
            worse = max(bad, key=lambda one: bad[one])
            other = first + second - worse
            outvoted = [one for one in (first, second) if self._outvoted(one, believed)]
            if len(outvoted) == 1:
                worse, other = outvoted[0], first + second - outvoted[0]
            elif bad[worse] <= DOUBTED or bad[worse] < WORSE * bad[other]:
                continue
            names = self._checks[worse].name, self._checks[other].name
            apart = abs(self._apart[first, second])
            reason = whys[worse] or (self._slowly_wrong(worse) if self._error(worse) else "")
            hanging = f"{names[0]} follows the air and not the plate" if self._checks[worse].in_air else ""
            said = f"{names[0]} is {apart:.1f} K from {names[1]}"
            found[worse] = "; ".join(filter(None, (said, hanging or reason)))
        return found

    def _outvoted(self, one: int, believed: Sequence[int]) -> bool:
        """Whether it is apart from all others, at least two, that agree among themselves."""
        others = [other for other in believed if other != one]
        return (
            len(others) > 1
            and all(abs(self._apart[min(one, other), max(one, other)]) > APART for other in others)
            and all(abs(self._apart[pair]) <= APART for pair in combinations(others, 2))
        )

    def _misfit(self, one: int) -> float:
        check = self._checks[one]
        return abs(check.mean_difference) + abs(check.error()) + (JUST_AIR if check.in_air else 0.0)

    def _error(self, one: int) -> float:
        """Return the error of its last reading, K; 0 where it is too small to tell."""
        error = self._checks[one].error()
        return error if abs(error) > MISLABELLED else 0.0

    def _slowly_wrong(self, one: int) -> str:
        check, error = self._checks[one], self._error(one)
        return f"{check.name} reads {abs(error):.1f} K too {'high' if error > 0 else 'low'}: {check.cause()}"

    def _disagreements(self, believed: Sequence[int]) -> list[str]:
        name = [check.name for check in self._checks]
        return [
            f"{name[first]} and {name[second]} read {abs(self._apart[first, second]):.1f} K apart, and it is not "
            "clear which is wrong"
            for first, second in combinations(believed, 2)
            if abs(self._apart[first, second]) > APART
        ]


JUST_AIR = 10.0
"""What counts for a sensor that hangs in the air, K: more than any other misfit."""
