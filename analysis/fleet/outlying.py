"""Pieces that do not belong to the others: generalised extreme studentised deviates.

A piece is compared with the law that the others predict for it: the deviation of its level, weighted by the
inverse covariance of the prediction, over its standard deviation is Student's t with P - 2 degrees of freedom if
the piece is one of them (with one temperature and no errors it is the externally studentised residual). Two
outliers hide each other, so the most deviating piece is taken out again and again, and the number of outliers is
that of the last step whose deviate is improbable (Rosner, Technometrics 25, 1983).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from analysis.arrays import Real
from analysis.fleet.scatter import FEWEST_PIECES, estimate_scatter

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
