"""Modes that all sweeps together show: hidden ones added, superfluous tracks removed.

Where modes overlap, one pole can represent two in every sweep, and its stated standard deviation covers noise
alone. If a mode keeps its place among the others, with residues in the same proportion to theirs in all sweeps, it
has two parameters per response instead of two per response and sweep: all sweeps together show far weaker modes.
Candidate places are tried one by one, with poles and tracks readjusted. A mode that BIC supports is added; the
others, weighted by the probability that they exist, are included in the standard deviations.

A track may be superfluous: a pole is added where BIC of one sweep supports it, and is then followed to all others,
with its own residues in each. Over all sweeps, the fall of the misfit has to exceed the BIC penalty of these
residues. The penalty of the track's own parameters is left out, so that a doubtful mode stays.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtrs

from analysis.arrays import Mask, Real
from analysis.identification.joint_fit import JointFit, SweepsAt, SweepsSearch, fit_together
from analysis.identification.lines import Lines
from analysis.identification.normal_equations import factor_of_gram
from analysis.identification.parameters import active_in, to_poles
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.variable_projection import change_with_poles

LARGEST_TRACK_DISTANCE = 2.0
"""Largest distance of a hidden mode from a track, in half widths."""


def candidate_places(fitted: JointFit, lines: Sequence[Lines]) -> tuple[Real, float]:
    """Places where a mode may be hidden: near the tracks, and parallel to them.

    Parameters
    ----------
    fitted : JointFit
        Of J tracks.
    lines : sequence of Lines
        T sweeps, as fitted.

    Returns
    -------
    place : (T, G, 2) ndarray
        Log |lambda| and log damping ratio.
    density : float
        Expected number of modes at each place.
    """
    used = np.flatnonzero(fitted.active.any(axis=0))
    used = used[np.argsort(fitted.place[:, used, 0].mean(axis=0), kind="stable")]
    middle = fitted.place[:, used, 0].mean(axis=0)
    inside = fitted.active & in_band(fitted.place, lines)
    damping = np.array(
        [
            np.median(row[there if there.any() else slice(None)])
            for row, there in zip(fitted.place[:, :, 1], inside, strict=True)
        ]
    )
    step, reach = float(np.exp(damping.min())), LARGEST_TRACK_DISTANCE * float(np.exp(damping.max()))
    grid = np.arange(middle[0], middle[-1] + step, step)
    density = len(used) / len(grid)
    grid = grid[np.abs(grid[:, None] - middle).min(axis=1) < reach]
    place = np.empty((len(fitted.place), len(grid), 2))
    for t, row in enumerate(fitted.place[:, used, 0]):
        place[t, :, 0] = grid + np.interp(grid, middle, row - middle)
    place[:, :, 1] = damping[:, None]
    return place, density


def in_band(place: Real, lines: Sequence[Lines]) -> Mask:
    """Which places (T, N, 2) lie in the band of their sweep, (T, N)."""
    band = np.log(2.0 * np.pi * np.array([one.frequency[[0, -1]] for one in lines]))
    return np.asarray((place[:, :, 0] > band[:, :1]) & (place[:, :, 0] < band[:, 1:]))


def candidate_derivatives(
    search: SweepsSearch, now: SweepsAt, place: Real, active: Mask
) -> Iterator[tuple[Real, Real, Real]]:
    """Yield derivatives of the misfit by the residues of candidate modes, response by response.

    Residues are in units of a typical one of the sweep, the other residues are refitted; unit: variance of one
    number. Real and imaginary residues alternate along the axis of length 2G.

    Parameters
    ----------
    now : SweepsAt
        All sweeps at the poles of the joint fit.
    place : (T, G, 2) ndarray
        Log |lambda| and log damping ratio of the candidates.
    active : (T, G) ndarray of bool
        Sweeps in which a candidate lies in band.

    Yields
    ------
    mixed : (T, 2J, 2G) ndarray
        Mixed derivatives with the poles' parameters.
    square : (2G,) ndarray
        Squared norms of the candidates' columns.
    score : (2G,) ndarray
        Their products with the data.
    """
    sweeps, responses = range(len(place)), range(len(search.lines[0].h))
    each = [_derivatives_of_sweep(search, now, t, place[t], active[t]) for t in sweeps]
    for response in responses:
        mixed = np.zeros((len(place), 2 * now.x.shape[1], 2 * place.shape[1]))
        square, score = np.zeros((2, 2 * place.shape[1]))
        for t in sweeps:
            numbers = np.flatnonzero(np.repeat(search.active[t], 2))
            for own_mixed, own_square, own_score in each[t][response : response + 1]:
                mixed[t, numbers] = own_mixed
                square += own_square
                score += own_score
        yield mixed, square, score


def _derivatives_of_sweep(
    search: SweepsSearch, now: SweepsAt, t: int, place: Real, active: Mask
) -> list[tuple[Real, Real, Real]]:
    """Return the same for one sweep, one row per parameter of its poles; an empty list if none is in band."""
    lines, projection = search.lines[t], now.projections[t]
    poles, count = projection.poles, len(projection.poles)
    known = in_band(now.x[t : t + 1], [lines])[0, search.active[t]]
    if not known.any():
        return []
    terms = search.terms[t]
    linear, new = 2 * count + terms.parameters, to_poles(place)
    typical = np.median(np.abs(projection.residues * poles)[:, known], axis=1)
    size = typical[:, None] * np.repeat(np.exp(-place[:, 0]) * active, 2)
    found: list[tuple[Real, Real, Real]] = [(np.empty(0),) * 3] * len(lines.h)
    for group, weighted in zip(lines.weight_groups, lines.weighted(terms), strict=True):
        products, there = weighted.at(poles, derivatives=True), weighted.at(new)
        gram, added = products.gram(terms.parameters), products.with_columns_of(there, terms.parameters)
        kept = np.r_[:linear, linear + 2 * count : len(gram)]  # without the derivative columns
        triangle, lengths = factor_of_gram(
            gram[np.ix_(kept, kept)],
            linear,
            partial(weighted.line_by_line, poles, terms.parameters, derivatives=False),
        )
        triangle = triangle[:linear, :linear]
        onto = dtrtrs(triangle, (gram[linear:, :linear] / lengths).T, trans=1)[0]
        added_onto = dtrtrs(triangle, added[:linear] / lengths[:, None], trans=1)[0]
        left = added[linear:] - onto.T @ added_onto
        moves, alone = left[: 2 * count].reshape(count, 2, -1), there.squares - (added_onto**2).sum(axis=0)
        for k, (row, scale) in enumerate(zip(group.rows, group.scales, strict=True)):
            change = scale * change_with_poles(projection.residues[row], poles).swapaxes(1, 2)
            unit = size[row] * scale / (0.5 * lines.redundancy)
            mixed = (change @ moves).reshape(2 * count, -1)
            found[row] = mixed * unit, alone * scale * size[row] * unit, left[2 * count + k] * unit
    return found


MOST_ADDED = 4
"""Largest number of added modes."""

LARGEST_HIDDEN_RESIDUE = 2.0
"""Largest residue of a hidden mode, relative to the others: model errors may give larger ones."""

ALTERNATIVE_DISTANCE = 2.0
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
    informative : (T,) ndarray of bool
        Sweeps whose residual can show hidden modes: not those whose residual has other causes.
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
        size = np.minimum((score / known) ** 2, LARGEST_HIDDEN_RESIDUE**2) + 1.0 / known
        moved.append(steps * np.sqrt(size))
    odds = density * np.exp(np.minimum(0.5 * gain + logarithm, MOST_CERTAIN))
    weight = np.sqrt(np.repeat(_probability(place, odds), 2))
    each = (np.concatenate(moved, axis=2) * np.tile(weight, len(moved))).reshape(*now.x.shape, -1)
    return HiddenModes(place, active, gain, each @ each.swapaxes(-1, -2))


def _probability(place: Real, odds: Real) -> Real:
    """Probability of a mode at every place (T, G, 2), near ones being alternatives, from their odds (G,)."""
    apart = reduce(np.minimum, (np.abs(row[:, None] - row) for row in place[:, :, 0]))  # one (G, G) at a time
    rivals = apart < ALTERNATIVE_DISTANCE * np.exp(np.median(place[:, :, 1]))
    return np.asarray(odds / (1.0 + rivals @ odds))
