"""Removal of superfluous tracks: those BIC over all sweeps does not support.

A pole is added where BIC of one sweep supports it, and is then followed to all others, with its own residues in
each. Over all sweeps, the fall of the misfit has to exceed the BIC penalty of these residues. The penalty of the
track's own parameters is left out, so that a doubtful mode stays.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.identification.joint_fit import JointFit, fit_together
from analysis.identification.lines import Lines
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.smooth_tracks import SmoothTracks

REPLACEABLE_DISTANCE = 1.5
"""Median distance of two tracks, in half widths, from which neither can replace the other."""

STRONG_LOSS = 100.0
"""Loss without a track, in BIC penalties with all others held, from which its removal is not tried."""

MOST_TRIALS = 8
"""Largest number of tracks whose removal is tried with a refit of the others."""

TRIAL_STEPS = 4
"""Steps of the refit, which has only to show whether the others can reach the sum of squares allowed."""


def remove_superfluous(
    blocks: Sequence[Lines], terms: Sequence[ResidualTerms], fitted: JointFit, tracks: SmoothTracks, settled: float
) -> JointFit:
    """Remove, weakest first, the tracks whose residues BIC does not support.

    Parameters
    ----------
    blocks : sequence of Lines
        T sweeps, with their final weights.
    terms : sequence of ResidualTerms
        Of each.
    fitted : JointFit
        Of J tracks.
    settled : float
        Fall of the sum of squares at which the fit of a trial stops.

    Returns
    -------
    JointFit
        With the remaining tracks; the removed ones are active in no sweep.
    """
    penalty = np.array([2.0 * one.responses * np.log(one.independent) for one in blocks])

    def fit(left: NDArray[np.bool_], target: float | None) -> JointFit:
        place = np.where(now.active[:, :, None], now.place, fitted.place)
        steps = 0 if target is None else TRIAL_STEPS
        return fit_together(
            blocks, terms, place, left, tracks, settled=settled, most=steps, target=target, known=now.projections
        )

    now = fit_together(blocks, terms, fitted.place, fitted.active, tracks, most=0)  # with the final weights
    tried: set[int] = set()
    while True:
        due = now.active.T @ penalty
        share = np.divide(_losses(blocks, now), due, out=np.full(len(due), np.inf), where=due > 0.0)
        doubtful = (share < 1.0) | (
            (share < STRONG_LOSS) & (_away(now).min(axis=0, initial=np.inf) < REPLACEABLE_DISTANCE)
        )
        rivals = [int(j) for j in np.argsort(share) if doubtful[j] and (share[j] < 1.0 or int(j) not in tried)]
        sure = bool(rivals) and share[rivals[0]] < 1.0  # a refit of the others would lose even less
        if not rivals or (len(tried) >= MOST_TRIALS and not sure):
            return now
        weakest = rivals[0]
        left = now.active & (np.arange(len(due)) != weakest)
        target = sum_of_squares(blocks, now) + due[weakest]
        trial = fit(left, None if sure else target)
        if not sure:
            tried.add(weakest)
        if sure or sum_of_squares(blocks, trial) < target:
            now = trial


def _losses(blocks: Sequence[Lines], now: JointFit) -> NDArray[np.float64]:
    """Rise of the sum of squares without each track, all others held, (J,), in variances of one number."""
    rise: NDArray[np.float64] = (now.loss / np.array([[0.5 * one.redundancy] for one in blocks])).sum(axis=0)
    return rise


def sum_of_squares(blocks: Sequence[Lines], now: JointFit) -> float:
    """Return the sum of squares of all sweeps, in variances of one number."""
    return sum(
        projection.misfit / (0.5 * one.redundancy) for projection, one in zip(now.projections, blocks, strict=True)
    )


def _away(now: JointFit) -> NDArray[np.float64]:
    """Distances (J, J) of tracks from each other, in half widths: median over the sweeps that hold both."""
    place, active = now.place[:, :, 0], now.active
    away = np.abs(place[:, :, None] - place[:, None, :]) / np.exp(now.place[:, None, :, 1])
    both = active[:, :, None] & active[:, None, :]
    away = np.sort(np.where(both, away, np.inf), axis=0)
    count = both.sum(axis=0)
    middle: NDArray[np.float64] = np.take_along_axis(away, np.maximum(count - 1, 0)[None] // 2, axis=0)[0]
    np.fill_diagonal(middle, np.inf)
    return middle
