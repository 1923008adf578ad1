"""Hidden modes, which no sweep shows alone: candidates, their support by all sweeps, their effect on other modes.

Where modes overlap, one pole can represent two in every sweep, and its stated standard deviation covers noise
alone. If a mode keeps its place among the others, with residues in the same proportion to theirs in all sweeps, it
has two parameters per response instead of two per response and sweep: all sweeps together show far weaker modes.
Candidate places are tried one by one, with poles and tracks readjusted. A mode that BIC supports is added; the
others, weighted by the probability that they exist, are included in the standard deviations.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from analysis.arrays import Mask, Real
from analysis.identification.hidden_candidates import candidate_derivatives, candidate_places, in_band
from analysis.identification.joint_fit import JointFit, fit_together
from analysis.identification.lines import Lines
from analysis.identification.parameters import active_in
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.superfluous import sum_of_squares
from analysis.identification.sweeps_search import SweepsSearch

MOST_ADDED = 4
"""Largest number of added modes."""

LARGEST = 2.0
"""Largest residue of a hidden mode, relative to the others: model errors may give larger ones."""

ALIKE = 2.0
"""Distance, in half widths, within which places are alternatives for one mode."""

MOST_CERTAIN = 100.0
"""Log odds at which they are clipped, as good as certain."""


@dataclass(frozen=True)
class HiddenModes:
    """Places at which a mode may be hidden.

    Attributes
    ----------
    place : (T, G, 2) ndarray
        Log |lambda| and log damping ratio of G places in T sweeps.
    active : (T, G) ndarray of bool
        Sweeps in which a mode there would lie in band.
    gain : (G,) ndarray
        Fall of the sum of squares with a mode there, in variances of one number, with the prior that its residues
        are about as large as those of the other modes.
    spread : (T, J, 2, 2) ndarray
        What hidden modes add to the covariance of the J tracks.
    """

    place: Real
    active: Mask
    gain: Real
    spread: Real


def add_hidden_modes(
    lines: Sequence[Lines],
    terms: Sequence[ResidualTerms],
    fitted: JointFit,
    tracks: SmoothTracks,
    informative: Mask,
) -> JointFit:
    """Add the hidden modes that BIC supports, with residues in the same proportion to the others in all sweeps.

    Parameters
    ----------
    lines : sequence of Lines
        T sweeps, with their final weights.
    terms : sequence of ResidualTerms
        Of each.
    fitted : JointFit
        Of J tracks.
    tracks : SmoothTracks
    informative : (T,) ndarray of bool
        Sweeps whose residual can show hidden modes: not those whose residual has other causes.

    Returns
    -------
    JointFit
        The J tracks and the added ones; their covariance includes the effect of modes still hidden.
    """
    values = sum(one.independent for one in lines)
    penalty = (2.0 * lines[0].responses + tracks.basis.shape[1] + 2) * np.log(values)
    for left in reversed(range(MOST_ADDED + 1)):
        found = find_hidden_modes(lines, terms, fitted, tracks, informative)
        best = int(np.argmax(found.gain))
        if not left or found.gain[best] < penalty:
            break
        new = found.place[:, [best]]
        takes_part = np.stack([active_in(row, one.frequency) for row, one in zip(new, lines, strict=True)])
        place = np.concatenate([fitted.place, new], axis=1)
        active = np.concatenate([fitted.active, takes_part], axis=1)
        wider = tracks.one_more()
        target = sum_of_squares(lines, fitted) - penalty
        trial = fit_together(lines, terms, place, active, wider, target=target)
        if sum_of_squares(lines, trial) > target:
            break
        fitted, tracks = trial, wider
    return replace(fitted, hidden=found.spread)


def find_hidden_modes(
    lines: Sequence[Lines],
    terms: Sequence[ResidualTerms],
    fitted: JointFit,
    tracks: SmoothTracks,
    informative: Mask,
) -> HiddenModes:
    """Find modes that the tracks of a joint fit hide.

    Parameters
    ----------
    lines : sequence of Lines
        T sweeps, as fitted.
    terms : sequence of ResidualTerms
        Of each.
    fitted : JointFit
        Of J tracks.
    tracks : SmoothTracks
    informative : (T,) ndarray of bool
        Sweeps whose residual can show hidden modes: not those whose residual has other causes.

    Returns
    -------
    HiddenModes
    """
    search = SweepsSearch(lines, terms, fitted.active, tracks, fitted.projections)
    now = search.at(fitted.place, np.ones(len(lines), dtype=bool))
    inverse, _, outer = search.curvature(now, np.zeros(len(lines)))
    numbers = search.nearest(now.x, np.zeros(tracks.count), tracks.scatter)
    rest = search.step(now, numbers, np.zeros(len(lines))).reshape(len(lines), -1)
    follows = tracks.moves(np.tile(np.eye(2 * now.x.shape[1]), (len(lines), 1, 1)))
    place, density = candidate_places(fitted, lines)
    active = in_band(place, lines) & informative[:, None]
    logarithm, moved = np.zeros(place.shape[1]), []
    gain = np.zeros(place.shape[1])
    for mixed, square, score in candidate_derivatives(search, now, place, active):
        slope = np.tensordot(follows, search.precision[:, None] * (inverse @ mixed), ((0, 1), (0, 1)))
        along = follows @ np.linalg.solve(outer, slope)
        steps = inverse @ (mixed + search.precision[:, None] * along)
        known = 1.0 + np.maximum(square - (mixed * steps).sum(axis=(0, 1)), 0.0)
        score = score - np.einsum("tig,ti->g", mixed, rest)  # as for a fully converged fit
        gain += (score**2 / known).reshape(-1, 2).sum(axis=1)
        logarithm -= 0.5 * np.log(known).reshape(-1, 2).sum(axis=1)
        size = np.minimum((score / known) ** 2, LARGEST**2) + 1.0 / known
        moved.append(steps * np.sqrt(size))
    odds = density * np.exp(np.minimum(0.5 * gain + logarithm, MOST_CERTAIN))
    weight = np.sqrt(np.repeat(_probability(place, odds), 2))
    each = (np.concatenate(moved, axis=2) * np.tile(weight, len(moved))).reshape(*now.x.shape, -1)
    return HiddenModes(place, active, gain, each @ each.swapaxes(-1, -2))


def _probability(place: Real, odds: Real) -> Real:
    """Probability of a mode at every place (T, G, 2), near ones being alternatives, from their odds (G,)."""
    apart = reduce(np.minimum, (np.abs(row[:, None] - row) for row in place[:, :, 0]))  # one (G, G) at a time
    rivals = apart < ALIKE * np.exp(np.median(place[:, :, 1]))
    return np.asarray(odds / (1.0 + rivals @ odds))
