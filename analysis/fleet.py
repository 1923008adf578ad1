"""Mean law of a fleet, scatter between pieces and within each, pieces that are unlike, and the law of another.

Of one constant, on a scale on which differences are alike over temperature (log E, nu, log eta), piece p has at
temperature k

    y_pk = m_k + b_p + w_pk + e_pk,   b ~ N(0, tau^2),   w ~ N(0, omega^2),   e_p ~ N(0, C_p):

the mean law m, the piece's own level b (another batch of granulate, another thickness of the mould), what is left
of its own at each temperature w, and the error of its estimate, whose covariance C_p is known. tau and omega
maximise the restricted likelihood (Patterson and Thompson, Biometrika 58, 1971), which counts the degrees of
freedom that m costs: of balanced data without errors it gives the estimates of the analysis of variance where
those are not negative (Searle, Casella, McCulloch, Variance Components, 1992, sec. 4.8).

Outliers are generalised extreme studentised deviates. A piece is compared with the law that the others predict for
it: the deviation of its level, weighted by the inverse covariance of the prediction, over its standard deviation
is Student's t with P - 2 degrees of freedom if the piece is one of them (with one temperature and no errors it is
the externally studentised residual). Two outliers hide each other, so the most deviating piece is taken out again
and again, and the number of outliers is that of the last step whose deviate is improbable (Rosner, Technometrics
25, 1983).

The fleet is the prior: the law of a piece is normal about the fleet's mean with the covariance of its scatter
(`Scatter.of_a_piece`). The value y_0 measured at temperature 0 with variance s^2 conditions it,

    z | y_0 ~ N(m + S_.0 (y_0 - m_0) / (S_00 + s^2),  S - S_.0 S_0. / (S_00 + s^2)).

As tau and omega are estimates, too, the band uses Student's t with P - 1 degrees of freedom: without the
measurement, and of pieces without errors, it is the exact prediction interval of one more normal value.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_shapes


@dataclass(frozen=True)
class PredictedLaw:
    """Law of one constant of a piece, on the scale of its fleet.

    Attributes
    ----------
    value, low, high : (K,) ndarray
        At the fleet's temperatures, with the band.
    share : float
        Probability of the band.
    """

    value: Real
    low: Real
    high: Real
    share: float

    def __post_init__(self) -> None:
        check_shapes(self, value="K", low="K", high="K")
        check_finite(self, "value", "low", "high")


FEWEST_PIECES = 3
"""Pieces: of two, one that is off cannot be told from the other."""
LEAST_OMEGA_SHARE = 1e-6
"""Least share of the values' spread that omega may have: laws are smooth, so that C_p alone may be singular."""


@dataclass(frozen=True)
class Scatter:
    """What a fleet's pieces have in common, and how far they differ.

    Attributes
    ----------
    mean : (K,) ndarray
    covariance : (K, K) ndarray
        Of the error of `mean`.
    between, within : float
        tau and omega: standard deviations.
    pieces : int
        From which they were estimated.
    """

    mean: Real
    covariance: Real
    between: float
    within: float
    pieces: int

    def __post_init__(self) -> None:
        check_shapes(self, mean="K", covariance="K K")
        check_finite(self, "mean", "covariance", "between", "within")
        if min(self.between, self.within) < 0.0:
            raise ValueError(f"Scatter.between {self.between:g}, within {self.within:g}; allowed: from 0")
        if self.pieces < FEWEST_PIECES - 1:
            raise ValueError(f"Scatter.pieces {self.pieces}; allowed: from {FEWEST_PIECES - 1}")

    @property
    def of_a_piece(self) -> Real:
        """Covariance (K, K) of another piece's law about `mean`, the error of that included."""
        count = self.mean.size
        piece = self.between**2 * np.ones((count, count)) + self.within**2 * np.eye(count)
        return piece + self.covariance


def estimate_scatter(values: Real, covariance: Real) -> Scatter:
    """Estimate the mean law and both scatters.

    Parameters
    ----------
    values : (P, K) ndarray
        Of two or more pieces. With K = 1 nothing tells omega from tau; it is then 0.
    covariance : (P, K, K) ndarray
        Of the errors of each piece's values.

    Returns
    -------
    Scatter
    """
    pieces, count = values.shape
    if pieces < FEWEST_PIECES - 1 or count < 1 or covariance.shape != (pieces, count, count):
        raise ValueError(
            f"values {values.shape} with covariance {covariance.shape}; allowed: (P, K) with (P, K, K), P from "
            f"{FEWEST_PIECES - 1}, K from 1"
        )
    from scipy.optimize import minimize

    spread = float(np.std(values - values.mean(0))) or 1.0
    between = float(np.std(values.mean(1), ddof=1)) / spread
    rest = values - values.mean(0) - (values - values.mean(0)).mean(1)[:, None]
    within = float(np.sqrt(np.sum(rest**2) / max((pieces - 1) * (count - 1), 1))) / spread
    several = count > 1

    def deviance(logs: Real) -> float:
        tau, omega = np.exp(logs[0]) * spread, (np.exp(logs[1]) if several else 0.0) * spread
        return _fit(values, covariance, tau, omega)[2]

    start = np.log(np.clip([between, within], 1e-3, 10.0))[: 1 + several]
    bounds = [(np.log(LEAST_OMEGA_SHARE), np.log(1e3))] * len(start)
    best = min(
        (
            minimize(deviance, start + shift, method="L-BFGS-B", bounds=bounds)
            for shift in (np.zeros(len(start)), np.full(len(start), -2.0))
        ),
        key=lambda found: float(found.fun),
    )
    tau = float(np.exp(best.x[0])) * spread
    omega = float(np.exp(best.x[1])) * spread if several else 0.0
    mean, error, least = _fit(values, covariance, tau, omega)
    if _fit(values, covariance, 0.0, omega if several else LEAST_OMEGA_SHARE * spread)[2] <= least:
        tau = 0.0  # on the bound: the pieces differ by no more than their errors
        mean, error, _ = _fit(values, covariance, tau, omega if several else LEAST_OMEGA_SHARE * spread)
    return Scatter(mean, error, tau, omega, pieces)


def _fit(values: Real, covariance: Real, between: float, within: float) -> tuple[Real, Real, float]:
    """Return the mean law, its covariance, and minus twice the logarithm of the restricted likelihood."""
    count = values.shape[1]
    whole = covariance + between**2 * np.ones((count, count)) + within**2 * np.eye(count)
    weight = np.linalg.inv(whole)
    error = np.linalg.inv(weight.sum(0))
    mean = error @ np.einsum("pij,pj->i", weight, values)
    left = values - mean
    deviance = np.linalg.slogdet(whole)[1].sum() - np.linalg.slogdet(error)[1]
    return mean, error, float(deviance + np.einsum("pi,pij,pj->", left, weight, left))


OUTLIER_PROBABILITY = 0.01
"""Probability that a fleet of equal pieces has one that is called an outlier: one of a hundred such fleets."""
LARGEST_OUTLIER_SHARE = 1 / 4
"""Largest share of outliers that is looked for: with more of them it is not clear who the fleet is."""


@dataclass(frozen=True)
class Outlier:
    """A piece beside the others.

    Attributes
    ----------
    piece : int
        Its row.
    quantity : str
        In which it deviates most.
    deviation : float
        Of its level from what the others predict, on that quantity's scale.
    probability : float
        Of a deviate as large in a fleet of equal pieces, after Bonferroni over pieces and quantities.
    """

    piece: int
    quantity: str
    deviation: float
    probability: float


def outliers(quantities: Mapping[str, tuple[Real, Real]], one_sided: Sequence[str] = ()) -> tuple[Outlier, ...]:
    """Find the pieces that deviate in any of some quantities.

    Parameters
    ----------
    quantities : mapping of str to tuple
        Values (P, K) and covariances (P, K, K) as of `estimate_scatter`, of the same pieces.
    one_sided : sequence of str
        Quantities of which only large values count, such as a misfit.

    Returns
    -------
    tuple of Outlier
        The most deviating first; none of fewer than four pieces.
    """
    pieces = len(next(iter(quantities.values()))[0])
    left, taken = list(range(pieces)), list[Outlier]()
    for _ in range(max(int(pieces * LARGEST_OUTLIER_SHARE), 1)):
        if len(left) <= FEWEST_PIECES:
            break
        found = [
            _against_the_others(name, values, covariance, left, piece, name in one_sided)
            for name, (values, covariance) in quantities.items()
            for piece in left
        ]
        least = min(found, key=lambda one: one.probability)
        taken.append(
            Outlier(least.piece, least.quantity, least.deviation, min(1.0, least.probability * len(found)))
        )
        left.remove(least.piece)
    last = max((place for place, one in enumerate(taken) if one.probability < OUTLIER_PROBABILITY), default=-1)
    return tuple(taken[: last + 1])


def _against_the_others(
    name: str, values: Real, covariance: Real, left: Sequence[int], piece: int, upward: bool
) -> Outlier:
    """Compare one piece with the others of `left`; the probability is its own, without Bonferroni."""
    others = [one for one in left if one != piece]
    fleet = estimate_scatter(values[others], covariance[others])
    predicted = fleet.of_a_piece + covariance[piece]
    if fleet.between + fleet.within == 0.0 and not covariance[piece].any():
        predicted = predicted + np.finfo(float).tiny * np.eye(len(predicted))
    weight = np.linalg.solve(predicted, np.ones(len(predicted)))
    deviation = float(weight @ (values[piece] - fleet.mean) / weight.sum())
    deviate = deviation * float(np.sqrt(weight.sum()))
    beyond = student.sf(deviate if upward else abs(deviate), len(others) - 1)
    return Outlier(piece, name, deviation, float(beyond if upward else 2.0 * beyond))


def predict_piece(
    fleet: Scatter, place: int | None = None, value: float = 0.0, sigma: float = 0.0, share: float = 0.9
) -> PredictedLaw:
    """Predict the law of a piece that is not in the fleet.

    Parameters
    ----------
    place : int, optional
        Temperature at which it was measured, as index of the fleet's; None where it was not.
    value, sigma : float
        Measured there, with its standard deviation.
    share : float
        Probability of the band.

    Returns
    -------
    PredictedLaw
    """
    if not 0.0 < share < 1.0:
        raise ValueError(f"share {share:g}; allowed: between 0 and 1")
    mean, spread = fleet.mean, fleet.of_a_piece
    if place is not None:
        gain = spread[:, place] / (spread[place, place] + sigma**2)
        mean = mean + gain * (value - mean[place])
        spread = spread - np.outer(gain, spread[place])
    width = student.ppf(0.5 + 0.5 * share, fleet.pieces - 1) * np.sqrt(np.clip(np.diag(spread), 0.0, None))
    return PredictedLaw(mean, mean - width, mean + width, share)
