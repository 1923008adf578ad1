"""Whether a stated probability comes true as often as it says, and the temperature with which it would."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.confidence import probability
from app.blind_trial.outcome import Named, Outcome

BINS = 5
"""Of equally many claims each: a trial has some dozens of them."""
TEMPERATURES = np.geomspace(0.5, 100.0, 81)


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


def claims(outcomes: Sequence[Outcome]) -> list[tuple[Named, bool]]:
    """Every effect claimed, and whether it, or an equivalent, is there."""
    return [(named, o.is_there(named)) for o in outcomes for named in o.named]


def reliability(stated: NDArray[np.float64], right: NDArray[np.bool_], bins: int = BINS) -> Reliability:
    """Sort claims into `bins` of equal size, by the probability stated (N,); `right` (N,) says which came true."""
    order = np.argsort(stated, kind="stable")
    parts = [part for part in np.array_split(order, bins) if part.size]
    return Reliability(
        stated=np.array([stated[p].mean() for p in parts]),
        true=np.array([right[p].mean() for p in parts]),
        count=np.array([p.size for p in parts], dtype=int),
    )


def best_temperature(found: Sequence[tuple[Named, bool]]) -> float | None:
    """Return the temperature of confidence under which the claims were likeliest; None without a wrong claim.

    Without one every temperature is too high, and none is best.
    """
    right = np.array([true for _, true in found], dtype=bool)
    if not found or right.all():
        return None
    losses = []
    for temperature in TEMPERATURES:
        p = np.array([probability(n.against, n.equivalent, temperature=float(temperature)) for n, _ in found])
        p = np.clip(p, 1e-9, 1.0 - 1e-9)
        losses.append(-float(np.log(np.where(right, p, 1.0 - p)).sum()))
    return float(TEMPERATURES[int(np.argmin(losses))])
