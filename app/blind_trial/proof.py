"""Figures of merit of a trial, each with its target, and calibration of the stated probabilities.

Intervals of proportions are Wilson's (Journal of the American Statistical Association 22, 1927).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.gap.search.confidence import probability
from app.blind_trial.draw_effects import SIMILAR_COSINE
from app.blind_trial.outcome import Named, TrialOutcome

FAINT_SIZES = (5.0, 8.0)
"""Sizes, sigma, between which an effect counts as one of 6 sigma."""
PLAIN, CLEAR_SIZES = 13.5, 27.0
"""Sizes, sigma, from which an effect counts as one of 15 or 30 sigma: the size reached may be a little less."""
REFUSED = "refused"
Test = Callable[[TrialOutcome], bool]


@dataclass(frozen=True)
class Figure:
    """One line of the table.

    Attributes
    ----------
    name : str
    value : float or None
        None if there was nothing to count.
    low, high : float or None
        Of Wilson's interval at 95 %, for shares.
    count : int
        Number of cases.
    target : (float, float)
        Ends within which it should lie.
    """

    name: str
    value: float | None
    low: float | None
    high: float | None
    count: int
    target: tuple[float, float]

    @property
    def met(self) -> bool | None:
        """Whether the figure reaches its target; None if there was nothing to count."""
        return None if self.value is None else self.target[0] <= self.value <= self.target[1]

    def record(self) -> dict[str, Any]:
        """Return it for a file."""
        return {**asdict(self), "met": self.met}


def figures(outcomes: Sequence[TrialOutcome]) -> tuple[Figure, ...]:
    """Return the whole table; refused campaigns count as wrong answers."""
    return (
        *_nulls(outcomes),
        *_singles(outcomes),
        *_unlisted(outcomes),
        *_pairs(outcomes),
        *_closure(outcomes),
        *_parameters(outcomes),
        *_laws(outcomes),
        *_confidence(outcomes),
        *_blind_spots(outcomes),
    )


NINETY_FIVE = 1.959963984540054
"""Half width of the 95 % interval of a normal distribution, in standard deviations."""


def proportion_interval(hits: int, count: int, z: float = NINETY_FIVE) -> tuple[float, float]:
    """Return the ends of the interval for a proportion.

    Parameters
    ----------
    hits, count : int
        Hits among all that were counted.
    z : float
        Half width of the interval in standard deviations of a normal distribution; 95 % by default.

    Returns
    -------
    low, high : float
        0 and 1 where nothing was counted.

    Raises
    ------
    ValueError
        For more hits than were counted, or less than none.
    """
    if not 0 <= hits <= count:
        raise ValueError(f"{hits} hits of {count}: between none and all are possible")
    if count == 0:
        return 0.0, 1.0
    share, weight = hits / count, z**2 / count
    middle = (share + 0.5 * weight) / (1.0 + weight)
    half = z * np.sqrt(share * (1.0 - share) / count + 0.25 * weight / count) / (1.0 + weight)
    low, high = float(max(middle - half, 0.0)), float(min(middle + half, 1.0))
    return (0.0 if hits == 0 else low), (1.0 if hits == count else high)


def share(name: str, among: Sequence[TrialOutcome], test: Test, least: float = 0.0, most: float = 1.0) -> Figure:
    """Share of campaigns that pass a test.

    Parameters
    ----------
    name : str
        Of the figure.
    among : sequence of TrialOutcome
    test : callable
        Whether a campaign passes.
    least, most : float
        Ends within which the share should lie.

    Returns
    -------
    Figure
        Its value is None where `among` is empty.
    """
    hits = sum(test(o) for o in among)
    low, high = proportion_interval(hits, len(among))
    return Figure(name, hits / len(among) if among else None, low, high, len(among), (least, most))


def _kind(outcomes: Sequence[TrialOutcome], *kinds: str) -> list[TrialOutcome]:
    return [o for o in outcomes if o.kind in kinds]


def strength(o: TrialOutcome) -> float:
    """Size of the weakest of a campaign's effects, in sigma."""
    return min(o.size.values(), default=0.0)


def _nulls(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    nulls = _kind(outcomes, "null")
    yield share("nulls: an effect claimed", nulls, lambda o: bool(o.named) or o.verdict == REFUSED, most=0.005)
    quiet = [o for o in nulls if not o.scatter]
    yield share(
        "nulls without nuisances: a gap or an effect claimed", quiet, lambda o: o.verdict != "none", most=0.01
    )


def _singles(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    singles = _kind(outcomes, "single")
    plain = [o for o in singles if strength(o) >= PLAIN]
    faint = [o for o in singles if FAINT_SIZES[0] <= strength(o) < FAINT_SIZES[1]]
    seen = [o for o in faint if o.named]
    yield share("single, 15 sigma and more: right name", plain, lambda o: o.right_names, 0.95)
    yield share("single, 15 sigma and more: right class", plain, lambda o: o.right_classes, 0.99)
    yield share("single, 6 sigma: an effect claimed", faint, lambda o: bool(o.named), 0.80)
    yield share("single, 6 sigma, claimed: right name", seen, lambda o: o.right_names, 0.85)
    yield share("single, 6 sigma, claimed: right class", seen, lambda o: o.right_classes, 0.95)


def _unlisted(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    both, outside = _kind(outcomes, "outside", "ablated"), _kind(outcomes, "outside")
    yield share("outside or ablated: unknown, or a confounded effect", both, lambda o: o.declared_unknown, 0.90)
    yield share("outside or ablated: unknown", both, lambda o: o.verdict == "unknown", 0.0)
    yield share("outside: any name accepted", outside, lambda o: bool(o.named), most=0.05)


def _pairs(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    pairs = [o for o in _kind(outcomes, "pair") if strength(o) >= PLAIN]
    for name, alike, least in (("|cos| < 0.8", False, 0.85), ("|cos| >= 0.8", True, 0.70)):
        some = [o for o in pairs if (abs(o.cosine or 0.0) >= SIMILAR_COSINE) == alike]
        yield share(f"pair, {name}: both right", some, lambda o: o.right_classes, least)


def closures(outcomes: Sequence[TrialOutcome]) -> NDArray[np.float64]:
    """Closure on held-out temperatures, of every campaign whose hidden effects were found."""
    return np.array([o.closure for o in _found(outcomes) if o.closure is not None])


def _found(outcomes: Sequence[TrialOutcome]) -> list[TrialOutcome]:
    return [o for o in _kind(outcomes, "single", "pair") if o.right_classes]


def _closure(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    closed = closures(outcomes)
    for name, quantile, least in (("median", 0.5, 0.95), ("worst decile", 0.1, 0.85)):
        value = float(np.quantile(closed, quantile)) if closed.size else None
        yield Figure(f"gap closed on held-out temperatures, {name}", value, None, None, closed.size, (least, 1.0))
    also = np.array([closure for o in _found(outcomes) for closure in o.closure_also])
    value = float(np.median(also)) if also.size else None
    yield Figure("gap closed on a held-out channel or level, median", value, None, None, also.size, (0.9, 1.0))


HALF_WIDTH_OF_90 = 1.6448536269514722
"""Half width of the 90 % interval of a normal distribution, in standard deviations."""


def errors(outcomes: Sequence[TrialOutcome]) -> NDArray[np.float64]:
    """Relative error of the one effect of each outcome, (N,).

    Its amplitudes count as one vector, in units of their priors, because a single component may be nearly zero (a
    gradient along x has almost none along y). Shape parameters are not included.
    """
    found = []
    for o in outcomes:
        ((name, scale),) = o.scale.items()
        true, estimate = o.effects[name], o.named[0].parameters
        size = np.linalg.norm([true[p] / sigma for p, sigma in scale.items()])
        off = np.linalg.norm([(estimate[p][0] - true[p]) / sigma for p, sigma in scale.items()])
        found.append(float(off / size))
    return np.array(found)


def coverage(outcomes: Sequence[TrialOutcome]) -> tuple[int, int]:
    """Count the parameters whose 90 % interval contains the truth, and all parameters."""
    inside = [
        abs(value - o.effects[named.name][parameter]) <= HALF_WIDTH_OF_90 * sigma
        for o in outcomes
        for named in o.named
        for parameter, (value, sigma) in named.parameters.items()
    ]
    return sum(inside), len(inside)


def _parameters(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    found = [o for o in _kind(outcomes, "single") if o.right_names]
    off = errors([o for o in found if strength(o) >= CLEAR_SIZES])
    value = float(np.median(off)) if off.size else None
    yield Figure("parameter error from 30 sigma, median", value, None, None, off.size, (0.0, 0.03))
    hits, count = coverage(found)
    low, high = proportion_interval(hits, count)
    held = hits / count if count else None
    yield Figure("true parameters within their 90 % intervals", held, low, high, count, (0.85, 0.95))


def _laws(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    """Bands of the laws; the errors of one campaign at its temperatures are much alike, so it counts once."""
    judged = [o for o in outcomes if o.law_errors]
    for name in ("youngs_modulus", "poisson_ratio", "loss_factor"):
        held = [float(np.mean(np.abs(o.law_errors[name]) <= HALF_WIDTH_OF_90)) for o in judged]
        value = float(np.mean(held)) if held else None
        low, high = proportion_interval(round(sum(held)), len(held))
        yield Figure(f"true {name} within its 90 % band", value, low, high, len(held), (0.85, 0.95))


def _confidence(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    found = claims(outcomes)
    stated = np.array([named.probability for named, _ in found])
    right = np.array([true for _, true in found], dtype=bool)
    error = reliability(stated, right).error if found else None
    yield Figure("calibration error of the stated probability", error, None, None, len(found), (0.0, 0.05))


def _blind_spots(outcomes: Sequence[TrialOutcome]) -> Iterator[Figure]:
    one_ramp = [o for o in outcomes if o.one_ramp and o.verdict != "refused"]
    yield share(
        "thermal lag not observable on one ramp", one_ramp, lambda o: "thermal_lag" in o.not_observable, 1.0
    )


PROBABILITY_BINS = 5
"""Number of bins with about equally many claims: a trial has some dozens of claims."""
DECIMALS = 2
"""Of the stated probabilities, as a report states them."""
TEMPERATURES = np.geomspace(0.5, 20.0, 41)
UNLISTED = np.linspace(0.0, 0.5, 101)


@dataclass(frozen=True)
class Reliability:
    """Claims in bins of their stated probability.

    Attributes
    ----------
    stated, true : (B,) ndarray
        Mean stated probability, and share of right claims.
    count : (B,) int ndarray
    """

    stated: NDArray[np.float64]
    true: NDArray[np.float64]
    count: NDArray[np.int_]

    @property
    def error(self) -> float:
        """Expected calibration error: mean distance of the two, weighted by claims."""
        return float(np.sum(self.count * np.abs(self.stated - self.true)) / max(int(self.count.sum()), 1))


def claims(outcomes: Sequence[TrialOutcome]) -> list[tuple[Named, bool]]:
    """Every claimed effect, and whether it, an equivalent or a confounded effect is present."""
    return [(named, o.is_there(named)) for o in outcomes for named in o.named]


def reliability(
    stated: NDArray[np.float64], right: NDArray[np.bool_], bins: int = PROBABILITY_BINS
) -> Reliability:
    """Sort claims into bins of about equal size, by the probability stated; equal probabilities share a bin.

    Most claims state the largest probability. In several bins, each with a part of them, the error would be the
    scatter of small samples.

    Parameters
    ----------
    stated : (N,) ndarray
        Probabilities, 0 to 1.
    right : (N,) bool ndarray
        Which claims are right.
    bins : int
        Largest number of bins; fewer for few claims.

    Returns
    -------
    Reliability
    """
    percent = np.round(stated, DECIMALS)
    edges = np.quantile(percent, np.linspace(0.0, 1.0, bins + 1)[1:-1], method="higher")
    place = np.searchsorted(edges, percent, side="right")
    parts = [np.flatnonzero(place == number) for number in np.unique(place)]
    return Reliability(
        stated=np.array([stated[p].mean() for p in parts]),
        true=np.array([right[p].mean() for p in parts]),
        count=np.array([p.size for p in parts], dtype=int),
    )


def likeliest_confidence(found: Sequence[tuple[Named, bool]]) -> dict[str, float] | None:
    """Return maximum-likelihood TEMPERATURE_OF_CONFIDENCE and UNLISTED; None without claims."""
    if not found:
        return None
    right = np.array([true for _, true in found], dtype=bool)
    best, least = None, np.inf
    for temperature in TEMPERATURES:
        p = [probability(n.against, n.equivalent, temperature=float(temperature), unlisted=0.0) for n, _ in found]
        stated = np.clip((1.0 - UNLISTED[:, None]) * p, 1e-9, 1.0 - 1e-9)
        losses = -np.log(np.where(right, stated, 1.0 - stated)).sum(1)
        if losses.min() < least:
            least = losses.min()
            best = {"temperature": float(temperature), "unlisted": float(UNLISTED[losses.argmin()])}
    return best
