"""Prediction of a thermocouple on a plate from the air in the oven, the time constant being learnt.

A bank of time constants tau_k, each with the plate that the measured air u gives it,

    dp/dt = (u - p) / tau_k,   exact between two readings for an air that moves on a straight line.

The reading y of a sensor differs from p by what is linear in six unknowns, each with a prior:

    y - p = b (1 - e) + c e + a (u - p) + g (p - T0) + d (t - t0) + s dp/d(ln tau),   e = exp(-(t - t0) / tau_k)

b is the offset of plate and oven sensor, c the error of the first reading, from which p begins; a the share of the
air in the reading (a sensor half loose), g an error of scale (another type), d a drift; s refines tau_k. A Kalman
filter of constant states estimates them for every tau_k; the evidence of its innovations weighs the tau_k
(multiple models: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking, 11.6.2).
"""

import numpy as np

from analysis.arrays import Real

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
