"""Joint fit of all sweeps of a campaign: hidden modes added, superfluous ones removed, status of each.

Where modes overlap, one pole can represent two in every sweep, and its stated standard deviation covers noise
alone. If a mode keeps its place among the others, with residues in the same proportion to theirs in all sweeps, it
has two parameters per response instead of two per response and sweep: all sweeps together show far weaker modes.
Candidate places are tried one by one, with poles and tracks readjusted. A mode that BIC supports is added; the
others, weighted by the probability that they exist, are included in the standard deviations.

A track may be superfluous: a pole is added where BIC of one sweep supports it, and is then followed to all others,
with its own residues in each. Over all sweeps, the fall of the misfit has to exceed the BIC penalty of these
residues. The penalty of the track's own parameters is left out, so that a doubtful mode stays.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtrs

from analysis.arrays import Mask, Real
from analysis.identification.averaging import averaged
from analysis.identification.finishing import judged
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.joint_fit import JointFit, SweepsAt, SweepsSearch, fit_together
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.pole_residue import ResidualTerms, active_in, to_poles
from analysis.identification.pole_search import PoleFit, change_with_poles, factor_of_gram, fit
from analysis.identification.settings import Settings

LARGEST_TRACK_DISTANCE = 2.0
"""Largest distance of a hidden mode from a track, in half widths."""
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
ROUGH_FALL = 20.0
"""Fall of the sum of squares at which the first of two fits stops; it only serves to estimate the noise."""
UNLIKE_OTHERS = 1.5
"""Ratio of a sweep's normalised error to that of the median sweep above which it is not used to find hidden modes:
its residual has other causes."""


def fit_sweeps(
    measured: Sequence[Measured],
    terms: Sequence[ResidualTerms],
    start: NDArray[np.float64],
    active: NDArray[np.bool_],
    tracks: SmoothTracks,
    settings: Settings,
    progress: Callable[[str, float], None] | None = None,
    *,
    select_tracks: bool = False,
    learn_damping: bool = False,
) -> tuple[tuple[Modes, ...], NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Fit all sweeps with the modes of smooth tracks, and determine their status in each sweep.

    Parameters
    ----------
    measured : sequence of Measured
        T sweeps.
    terms : sequence of ResidualTerms
        Of each.
    start : (T, J, 2) ndarray
        Log |lambda| and log damping ratio to start from.
    active : (T, J) ndarray of bool
        Modes that take part in a sweep.
    settings : Settings
        Of the status.
    progress : callable, optional
        Called with the stage and the share done.
    select_tracks : bool
        Whether tracks are removed or added by BIC over all sweeps; the uncertainty from modes that stay hidden is
        then included in the standard deviations.
    learn_damping : bool
        Whether the scatter of the modes' own damping is learned from the sweeps, those of `tracks` being wide.

    Returns
    -------
    modes : tuple of Modes
        One per sweep.
    table : (T, N) ndarray of int
        Place of each track's pole in the sweep's modes; -1 where it takes no part, or out of band. Added tracks
        follow the J given.
    place : (T, N, 2) ndarray
        Log |lambda| and log damping ratio of all tracks.
    excess : (T,) ndarray
        Ratio of the errors of each sweep to the stated standard deviations, 1 or more; 1 if none are stated.
    """
    report = progress or (lambda stage, share: None)
    lines = [one.lines() for one in measured]
    blocks = [averaged(one) for one in lines]
    rough = fit_together(blocks, terms, start, active, tracks, settled=ROUGH_FALL)
    report("identify", 0.5)
    weighed, excess = _weighed(measured, lines, blocks, rough, terms)
    blocks = [_with_excess(averaged(one), by) for one, by in zip(weighed, excess.tolist(), strict=True)]
    if select_tracks:
        tracks = tracks.estimated(rough.place, rough.active)
        rough = remove_superfluous(blocks, terms, rough, tracks, ROUGH_FALL)
        report("identify", 0.7)
    if learn_damping:
        rough = fit_together(blocks, terms, rough.place, rough.active, tracks, settled=1.0)
        tracks = tracks.with_damping_of(rough.place, rough.covariance[:, :, 1, 1], rough.active)
    known = rough.projections if select_tracks else ()  # otherwise the weights have changed
    last = fit_together(blocks, terms, rough.place, rough.active, tracks, known=known)
    if select_tracks and last.active.any():
        last = add_hidden_modes(blocks, terms, last, tracks, excess <= UNLIKE_OTHERS * np.median(excess))
    report("identify", 0.9)
    found, table = _modes_of_sweeps(weighed, terms, last, settings)
    report("identify", 1.0)
    return found, table, last.place, excess


def _weighed(
    measured: Sequence[Measured],
    lines: Sequence[Lines],
    blocks: Sequence[Lines],
    rough: JointFit,
    terms: Sequence[ResidualTerms],
) -> tuple[list[Lines], NDArray[np.float64]]:
    """Lines weighted by a fit's residual, and the ratio (T,) of its errors to stated ones, 1 if there are none."""
    fits = [
        PoleFit(projection, own, 0, True, np.zeros(len(projection.poles), dtype=bool))
        for projection, own in zip(rough.projections, terms, strict=True)
    ]
    weighed = [one.reweighted(own, now) for one, own, now in zip(measured, lines, fits, strict=True)]
    excess = [
        _excess(own, now, last.correlation) if one.known else 1.0
        for one, own, now, last in zip(measured, blocks, fits, weighed, strict=True)
    ]
    return weighed, np.array(excess)


def _modes_of_sweeps(
    lines: Sequence[Lines], terms: Sequence[ResidualTerms], fitted: JointFit, settings: Settings
) -> tuple[tuple[Modes, ...], NDArray[np.int64]]:
    """Modes of every sweep at the poles of the joint fit, with their status, and the table of `fit_sweeps`."""
    table = np.full(fitted.active.shape, -1, dtype=np.int64)
    found = []
    for t, one in enumerate(lines):
        columns = np.flatnonzero(fitted.active[t])
        poles = to_poles(fitted.place[t, columns])
        own = fit(one, poles, terms[t], max_iterations=0)
        modes, place = judged(one, own, settings, fitted.covariance[t, columns])
        inside = (poles.imag > 2.0 * np.pi * modes.band[0]) & (poles.imag < 2.0 * np.pi * modes.band[1])
        table[t, columns] = np.where(inside, place, -1)
        found.append(modes)
    return tuple(found), table


def _with_excess(lines: Lines, excess: float) -> Lines:
    """Lines whose standard deviations are larger by a factor."""
    return replace(lines, deviation=excess * lines.deviation)


def _excess(blocks: Lines, fitted: PoleFit, correlation: float) -> float:
    """Ratio of a fit's errors to the stated standard deviations, at least 1, for correlated lines."""
    freedom = max(blocks.values - fitted.parameters * correlation, 1.0)
    return max(float(np.sqrt(2.0 * (fitted.projection.misfit + blocks.hidden) / freedom)), 1.0)


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
