"""Calibration of the stated probabilities, and the settings with the best calibration."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.search.confidence import probability
from app.blind_trial.outcome import Named, TrialOutcome

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
