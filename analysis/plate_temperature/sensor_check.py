"""One sensor on a plate over time: what it reads, held against what air and earlier readings make likely.

A thermocouple on a plate is predicted from the air in the oven, the time constant being learnt.

A bank of time constants tau_k, each with the plate that the measured air u gives it,

    dp/dt = (u - p) / tau_k,   exact between two readings for an air that moves on a straight line.

The reading y of a sensor differs from p by what is linear in six unknowns, each with a prior:

    y - p = b (1 - e) + c e + a (u - p) + g (p - T0) + d (t - t0) + s dp/d(ln tau),   e = exp(-(t - t0) / tau_k)

b is the offset of plate and oven sensor, c the error of the first reading, from which p begins; a the share of the
air in the reading (a sensor half loose), g an error of scale (another type), d a drift; s refines tau_k. A Kalman
filter of constant states estimates them for every tau_k; the evidence of its innovations weighs the tau_k
(multiple models: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking, 11.6.2).
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from analysis.arrays import Real

JUMP = 1.0
"""Largest difference of one reading from the prediction, K: ten times the noise of a usual thermocouple."""
LAG_SHARE = 0.15
"""On top of it, of the lag: how far tau changes with the fan's flow and with natural convection."""
DOUBTED = 0.3
"""Mean difference over `MEMORY` from which on a label is doubted, K: below the 0.5 K that labels are good for, and
seven times the scatter of that mean."""
ONE_DOUBTED = 0.65
"""Difference of a single reading from which on it is doubted, K: six times the noise."""
MEMORY, LEAST_READINGS = 30.0, 3.0
"""s of readings that a mean difference stands for, or so many readings."""
SURE = 3.0
"""Standard deviations beyond which a difference is none of chance."""
SHOWN = math.log(1e4)
"""Evidence, see `LagModel.evidence_of_error`, from which on a sensor is slowly wrong. Of a sound sensor it exceeds
ln c at any time, however often it is looked at, with a probability of at most 1 / c (Ville's inequality)."""
MISLABELLED = 0.35
"""Estimated error of a label from which on it is told, K: with its uncertainty, below 0.5 K."""
GOOD_FOR = 0.5
"""What labels are good for, K: told where a sensor is wrong, and its error may be larger."""
OPEN = (-120.0, 400.0)
"""Beyond, no intact sensor in an oven reads, degrees Celsius: an open input is at the end of its range."""
FROZEN_READINGS, FROZEN_AIR = 20, 2.0
"""Readings equal to the millikelvin while the air moves by this much, K: a real sensor has noise."""
EQUAL_READINGS = 5
"""From so many equal readings on, a sensor that is found wrong is called frozen."""
YOUNG = 60.0
"""A model that has learnt for less, s, is begun anew where a reading does not fit: its first one may be wrong."""
IN_AIR = 25.0
"""Time constant below which a sensor hangs in the air, s: a steel sheet of 0.5 mm has 30 s in a fan's wind."""
MOSTLY = 0.7
"""Share of the air in a reading from which on the sensor hangs in it."""
UNNOTICED, UNNOTICED_SIGMA = 0.03, 0.5
"""Part of a difference that every sound sensor has, K and standard deviations of the prediction. What is beyond,
summed over time, tells a sensor that comes loose so slowly that the model follows it."""
SLIPS = 20.0
"""Such a sum, K s, from which on the sensor is doubted, unless all readings together are likelier of a sound one:
noise alone reached 20 in 1 of 650 sound campaigns, with evidence of exp(-7). One that came loose within an hour,
whose labels were 0.8 K wrong in the end, had 29."""
OFFSET = 0.8
"""Difference of plate and air at rest from which on it is told, K: a controller's sensor is good for 0.5 K."""


def share_of_last(step: float) -> float:
    """Return the weight of a reading in a running mean, `step` s after the one before."""
    return 1.0 - math.exp(-step / max(MEMORY, LEAST_READINGS * step, 1e-3)) if math.isfinite(step) else 1.0


class Trust(IntEnum):
    """How far a reading is to be trusted."""

    REFUSED = 0
    DOUBTED = 1
    BELIEVED = 2


@dataclass(frozen=True)
class Verdict:
    """Judgement of one reading.

    Attributes
    ----------
    trust : Trust
    why : str
        What is wrong, with values; empty for a reading that is believed.
    """

    trust: Trust
    why: str = ""


BELIEVED = Verdict(Trust.BELIEVED)


SPACING = 0.12
"""Of the bank, in ln tau: s then stays within half of it, where the derivative is exact to 0.4 % of the lag."""
FASTEST, SLOWEST = 8.0, 4500.0
"""Ends of the bank, s: a thermocouple hanging in the air, and a plate of 30 mm aluminium."""
PRIOR = np.array([0.4, 0.2, 0.5, 0.05, 3.0 / 3600.0, 0.5 * SPACING])
"""Standard deviations of b [K], c [K], a, g, d [K/s], s. Two classes of tolerance of a type K thermocouple are 1.5
and 2.5 K, an oven's sensor has 0.3 to 0.5 K; other types give up to 10 % more or less; old ones drift 1 K/h."""
NOISE = 0.1
"""Of one reading, K."""
INDEPENDENT = 15.0
"""Time between two readings that count as independent, s: regulators and fans swing for about as long."""
FAULTS = slice(2, 5)
"""Of the six, those that only a wrong sensor has: a, g, d."""
LEAST_EVIDENCE = 30.0
"""In ln; a tau_k that is less likely by this is left out: 1e-13."""


class LagModel:
    """Learns how one sensor follows the air.

    Parameters
    ----------
    now : float
        Of the first reading, s.
    air, reading : float
        Degrees Celsius.
    """

    _rows: Real
    _expected: Real
    _spread: Real
    _variance: Real
    _predicted: tuple[float, float]

    def __init__(self, now: float, air: float, reading: float) -> None:
        count = int(np.ceil(np.log(SLOWEST / FASTEST) / SPACING)) + 1
        self._log_tau = np.log(FASTEST) + SPACING * np.arange(count)
        self._tau = np.exp(self._log_tau)
        self._start, self._now, self._air, self._slope = (now, reading), now, air, 0.0
        self._plate = np.full(count, reading)
        self._blur = np.zeros(count)
        self._state = np.zeros((count, PRIOR.size))
        self._covariance = np.tile(np.diag(PRIOR**2), (count, 1, 1))
        self._evidence = np.zeros(count)
        self._weight = np.full(count, 1.0 / count)
        self._inside = slice(0, count)
        self._renew()

    def advance(self, now: float, air: float) -> None:
        """Let the plates of the bank follow the air up to `now` (s)."""
        step = now - self._now
        if step <= 0.0:
            return
        tau = self._tau
        decay = np.exp(-step / tau)
        slope = (air - self._air) / step
        # p behind the straight line u(t) by slope * tau, but for what is left of the start
        self._plate = air - slope * tau + decay * (self._plate - self._air + slope * tau)
        # An air that turned between two readings, as when a door is opened, may have done so at either of them.
        turned = (slope - self._slope) * step * step / (4.0 * tau)
        self._blur = self._blur * decay**2 + turned**2
        self._now, self._air, self._slope = now, air, slope
        self._renew()

    def prediction(self) -> tuple[float, float]:
        """Return the reading expected now and its standard deviation without the noise of a reading, °C and K."""
        return self._predicted

    def learn(self, reading: float, step: float) -> None:
        """Take a reading that is believed, made `step` s after the one before, into the estimates."""
        inside, rows, spread = self._inside, self._rows, self._spread
        variance = NOISE**2 * max(1.0, INDEPENDENT / max(step, 1e-3)) + self._blur[inside]
        innovation = reading - self._expected
        total = self._variance + variance
        self._state[inside] += spread * (innovation / total)[:, None]
        self._covariance[inside] -= spread[:, :, None] * (spread / total[:, None])[:, None, :]
        self._evidence[inside] -= 0.5 * (innovation**2 / total + np.log(total / variance))
        evidence = self._evidence[inside]
        likely = np.flatnonzero(evidence > evidence.max() - LEAST_EVIDENCE)
        first, last, begin = int(likely[0]), int(likely[-1]) + 1, inside.start
        self._inside, self._rows = slice(begin + first, begin + last), rows[first:last]
        weight = np.exp(evidence[first:last] - evidence.max())
        self._weight = weight / weight.sum()

    @property
    def tau(self) -> tuple[float, float]:
        """Time constant and the standard deviation of its logarithm, s and 1."""
        weight, inside = self._weight, self._inside
        log_tau = self._log_tau[inside] + self._state[inside, 5]
        mean = float(weight @ log_tau)
        variance = weight @ (self._covariance[inside, 5, 5] + (log_tau - mean) ** 2)
        return float(np.exp(mean)), float(np.sqrt(variance))

    def air_share(self, fastest: float) -> float:
        """Return which share of the reading follows the air at once, or faster than `fastest` (s).

        A sensor in the air is one with a short time constant, or one on any plate whose share of the air, a, is 1:
        readings alone do not tell one from the other.
        """
        share = np.where(self._tau[self._inside] < fastest, 1.0, self._state[self._inside, 2])
        return float(self._weight @ share)

    def offset(self) -> tuple[float, float]:
        """Return reading less air at rest, and its standard deviation, K."""
        row = np.zeros(PRIOR.size)
        row[0] = 1.0
        return self._combined(np.tile(row, (self._evidence[self._inside].size, 1)))

    def moment(self) -> tuple[Real, Real, float]:
        """Return what `error` needs to judge this moment's reading later: air less plates, plates, time."""
        return self._air - self._plate, self._plate - self._start[1], self._now - self._start[0]

    def error(self, moment: tuple[Real, Real, float]) -> tuple[float, float]:
        """Return by how much a reading was too high for a, g and d, and the standard deviation, K.

        Parameters
        ----------
        moment : tuple
            Of `moment`, when it was made.

        Returns
        -------
        error, sigma : float
        """
        ahead, above, seconds = moment
        inside = self._inside
        rows = np.zeros((ahead[inside].size, PRIOR.size))
        rows[:, 2], rows[:, 3], rows[:, 4] = ahead[inside], above[inside], seconds
        return self._combined(rows)

    def evidence_of_error(self) -> float:
        """Return ln of how much likelier all readings are if a, g and d are free than if they are zero.

        Each tau_k has its own a: soon after the start, a slow plate with a share of the air in its reading and a
        faster one without are both likely, and mean and standard deviation over both say little. With zero, each
        tau_k is as likely as before times the density of (a, g, d) there, after the readings over before (Savage's
        ratio: Dickey, Annals of Mathematical Statistics 42, 1971).
        """
        inside, prior = self._inside, PRIOR[FAULTS]
        found = self._state[inside, FAULTS] / prior
        covariance = self._covariance[inside, FAULTS, FAULTS] / np.outer(prior, prior)
        distance = (found * np.linalg.solve(covariance, found[:, :, None])[:, :, 0]).sum(1)
        at_zero = np.log(self._weight) - 0.5 * (distance + np.linalg.slogdet(covariance)[1])
        largest = float(at_zero.max())
        return -largest - float(np.log(np.exp(at_zero - largest).sum()))

    def parts(self, moment: tuple[Real, Real, float]) -> dict[str, float]:
        """Return the three parts of `error`, K: ``air``, ``scale`` and ``drift``."""
        weight, inside = self._weight, self._inside
        ahead, above, seconds = moment
        state = self._state[inside]
        return {
            "air": float(weight @ (state[:, 2] * ahead[inside])),
            "scale": float(weight @ (state[:, 3] * above[inside])),
            "drift": float(weight @ state[:, 4]) * seconds,
        }

    def _combined(self, rows: Real) -> tuple[float, float]:
        weight, inside = self._weight, self._inside
        values = (rows * self._state[inside]).sum(1)
        mean = float(weight @ values)
        variance = np.einsum("ki,kij,kj->k", rows, self._covariance[inside], rows)
        return mean, float(np.sqrt(weight @ (variance + (values - mean) ** 2)))

    def _renew(self) -> None:
        """Predict the reading of this moment by every time constant."""
        inside, seconds = self._inside, self._now - self._start[0]
        plate = self._plate[inside]
        rows = np.empty((plate.size, PRIOR.size))
        rows[:, 1] = np.exp(-seconds / self._tau[inside])
        rows[:, 0] = 1.0 - rows[:, 1]
        rows[:, 2], rows[:, 3], rows[:, 4] = self._air - plate, plate - self._start[1], seconds
        rows[:, 5] = self._by_log_tau()
        self._rows = rows
        self._expected = plate + (rows * self._state[inside]).sum(1)
        self._spread = np.matmul(self._covariance[inside], rows[:, :, None])[:, :, 0]
        self._variance = (rows * self._spread).sum(1)
        mean = float(self._weight @ self._expected)
        variance = self._variance + self._blur[inside] + (self._expected - mean) ** 2
        self._predicted = mean, float(self._weight @ variance) ** 0.5

    def _by_log_tau(self) -> Real:
        """Return the derivative of the plates by ln tau, K."""
        inside, last = self._inside, self._plate.size - 1
        number = np.arange(inside.start, inside.stop)
        below, above = np.maximum(number - 1, 0), np.minimum(number + 1, last)
        return np.asarray((self._plate[above] - self._plate[below]) / (SPACING * (above - below)))


class SensorCheck:
    """Judges the readings of one sensor, in their order.

    A reading is doubted or refused for as long as it does not fit; nothing is learnt from it meanwhile, so that a
    lie does not become the truth by lasting.

    Parameters
    ----------
    name : str
        Of the sensor, for messages.

    Attributes
    ----------
    name : str
    mean_difference : float
        Mean of what the last readings were above the prediction, K.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.mean_difference = 0.0
        self._model: LagModel | None = None
        self._began = self._last = -math.inf
        self._equal = 0
        self._equal_since = (math.nan, math.nan)
        self._slipped = {1.0: 0.0, -1.0: 0.0}
        self._slips = ""

    def fits(self, now: float, air: float, reading: float) -> bool:
        """Whether a reading is no jump; changes nothing but time, so that the sensor can be read again.

        Parameters
        ----------
        now : float
            s.
        air, reading : float
            Degrees Celsius.
        """
        if not OPEN[0] < reading < OPEN[1]:
            return False
        if self._model is None:
            return True
        self._model.advance(now, air)
        return abs(reading - self._model.prediction()[0]) <= self._largest_jump(air)

    def judge(self, now: float, air: float, reading: float) -> Verdict:
        """Judge a reading and learn from it if it is believed.

        Parameters
        ----------
        now : float
            s.
        air, reading : float
            Degrees Celsius.
        """
        if not OPEN[0] < reading < OPEN[1]:  # also NaN
            return Verdict(Trust.REFUSED, f"{self.name} reads {reading:g} °C: open or shorted")
        if self._frozen(air, reading):
            since = self._equal_since[1]
            moved = f"while the air moved from {since:.1f} to {air:.1f} °C"
            return Verdict(
                Trust.REFUSED, f"{self.name} is stuck at {reading:g} °C: {self._equal} equal readings, {moved}"
            )
        if self._model is None:
            self._begin(now, air, reading)
            return BELIEVED
        self._model.advance(now, air)
        expected, sigma = self._model.prediction()
        difference = reading - expected
        if abs(difference) > self._largest_jump(air) and now - self._began < YOUNG:
            self._begin(now, air, reading)
            return BELIEVED
        share = share_of_last(now - self._last)
        self.mean_difference += share * (difference - self.mean_difference)
        step, self._last = now - self._last, now
        lasting = abs(self.mean_difference) - SURE * sigma
        if abs(difference) > self._largest_jump(air) or lasting > JUMP + LAG_SHARE * abs(air - expected):
            return Verdict(Trust.REFUSED, self._told(reading, expected))
        if lasting > DOUBTED or abs(difference) - SURE * sigma > ONE_DOUBTED:
            return Verdict(Trust.DOUBTED, self._told(reading, expected))
        if step > 0.0:
            self._add(difference, UNNOTICED + UNNOTICED_SIGMA * sigma, step)
            self._model.learn(reading, step)
        return BELIEVED

    def _add(self, difference: float, usual: float, step: float) -> None:
        """Add a small difference to the sums of both signs (Page, Biometrika 41, 1954: cumulative sums)."""
        for sign in self._slipped:
            beyond = (sign * difference - usual) * min(step, MEMORY)
            self._slipped[sign] = max(self._slipped[sign] + beyond, 0.0)
            if self._slipped[sign] > SLIPS and not self._slips:
                way = "above" if sign > 0.0 else "below"
                self._slips = (
                    f"{self.name} has for long been a little {way} what the air and its readings before made "
                    "likely: it comes loose, or drifts"
                )

    @property
    def moment(self) -> tuple[Real, Real, float] | None:
        """What `error` needs to judge the last reading later; None before the first."""
        return None if self._model is None else self._model.moment()

    def error(self, moment: tuple[Real, Real, float] | None = None) -> float:
        """Return by how much a reading was too high, K; 0 where that is not sure.

        Parameters
        ----------
        moment : tuple, optional
            Of the reading, see `moment`; the last one by default.
        """
        if self._model is None:
            return 0.0
        value, sigma = self._model.error(self._model.moment() if moment is None else moment)
        return value if abs(value) > SURE * sigma and self._model.evidence_of_error() > SHOWN else 0.0

    def largest_error(self, moment: tuple[Real, Real, float]) -> float:
        """Return how large the error of a reading may be, K; 0 unless the evidence says that the sensor is wrong.

        Causes are taken as constant. Of a sensor that comes loose they can cancel: it is known to be wrong, and
        its estimated errors stay small.

        Parameters
        ----------
        moment : tuple
            Of the reading, see `moment`.
        """
        if self._model is None or self._model.evidence_of_error() <= SHOWN:
            return 0.0
        value, sigma = self._model.error(moment)
        return abs(value) + SURE * sigma

    def cause(self, moment: tuple[Real, Real, float] | None = None) -> str:
        """Say what the error of a reading, see `error`, looks like."""
        if self._model is None:
            return ""
        parts = self._model.parts(self._model.moment() if moment is None else moment)
        words = {
            "air": "it follows the air: half loose, or the air's sensor is slow",
            "scale": "its error grows with temperature: another type of thermocouple, or a poor contact",
            "drift": "its error grows with time: it drifts",
        }
        return words[max(parts, key=lambda name: abs(parts[name]))]

    @property
    def in_air(self) -> bool:
        """Whether it follows the air so fast that it cannot be on a plate."""
        return self._model is not None and self._model.air_share(IN_AIR) > MOSTLY

    def lasting_doubt(self) -> str:
        """Say what is wrong with the sensor by all that was learnt; empty if nothing."""
        if self._model is None:
            return ""
        if self.in_air:
            return f"{self.name} follows the air at once: it hangs in the air, not on the plate"
        if self._slips and self._model.evidence_of_error() > 0.0:
            return self._slips
        offset, sigma = self._model.offset()
        if abs(offset) - SURE * sigma > OFFSET:
            than = "above" if offset > 0.0 else "below"
            return f"{self.name} is {abs(offset):.1f} K {than} the air's sensor at rest: one of them is wrong"
        return ""

    def _begin(self, now: float, air: float, reading: float) -> None:
        self._model = LagModel(now, air, reading)
        self._began = self._last = now
        self.mean_difference = 0.0
        self._slipped = {1.0: 0.0, -1.0: 0.0}

    def _largest_jump(self, air: float) -> float:
        if self._model is None:
            return math.inf
        expected, sigma = self._model.prediction()
        return JUMP + LAG_SHARE * abs(air - expected) + SURE * sigma

    def _frozen(self, air: float, reading: float) -> bool:
        if not self._equal or reading != self._equal_since[0]:
            self._equal, self._equal_since = 1, (reading, air)
            return False
        self._equal += 1
        return self._equal >= FROZEN_READINGS and abs(air - self._equal_since[1]) >= FROZEN_AIR

    def _told(self, reading: float, expected: float) -> str:
        likely = f"by the air and its readings so far {expected:.1f} °C is likely"
        if self._equal >= EQUAL_READINGS:
            return f"{self.name} is stuck at {reading:g} °C; {likely}"
        return f"{self.name} reads {reading:.2f} °C; {likely}"
