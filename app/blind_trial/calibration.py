"""Whether a stated probability comes true as often as it says, and the settings with which it would."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.search.confidence import probability
from app.blind_trial.outcome import Named, TrialOutcome

BINS = 5
"""Of equally many claims each: a trial has some dozens of them."""
TEMPERATURES = np.geomspace(0.5, 20.0, 41)
UNLISTED = np.linspace(0.0, 0.5, 101)


@dataclass(frozen=True)
class Reliability:
    """Claims sorted by the probability stated, in bins.

    Attributes
    ----------
    stated, true : (B,) ndarray
        Mean probability, and share of claims that were right.
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
    """Every effect claimed, and whether it, an equivalent, or an effect confounded with it, is there."""
    return [(named, o.is_there(named)) for o in outcomes for named in o.named]


def reliability(stated: NDArray[np.float64], right: NDArray[np.bool_], bins: int = BINS) -> Reliability:
    """Sort claims into bins of equal size, by the probability stated.

    Parameters
    ----------
    stated : (N,) ndarray
        Probabilities, 0 to 1.
    right : (N,) bool ndarray
        Which claims came true.
    bins : int
        At most so many: fewer claims fill fewer bins.

    Returns
    -------
    Reliability
    """
    order = np.argsort(stated, kind="stable")
    parts = [part for part in np.array_split(order, bins) if part.size]
    return Reliability(
        stated=np.array([stated[p].mean() for p in parts]),
        true=np.array([right[p].mean() for p in parts]),
        count=np.array([p.size for p in parts], dtype=int),
    )


def likeliest_confidence(found: Sequence[tuple[Named, bool]]) -> dict[str, float] | None:
    """Return TEMPERATURE_OF_CONFIDENCE and UNLISTED under which the claims were likeliest; None without any."""
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
