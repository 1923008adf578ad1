"""Hidden modes, which no sweep shows alone: candidates, their support by all sweeps, their effect on other modes.

Where modes overlap, one pole can stand for two in every sweep, and its stated standard deviation covers noise
alone. If a mode keeps its place among the others, with residues in the same proportion to theirs in all sweeps, it
has two parameters per response instead of two per response and sweep: all sweeps together show far weaker modes.
Candidate places are tried one by one, with poles and tracks readjusted. A mode that BIC supports is added; the
others, weighted by the probability that they exist, are included in the standard deviations.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dtrtrs

from analysis.identification.following import active_in
from analysis.identification.joint_fit import JointFit, fit_together
from analysis.identification.lines import Lines
from analysis.identification.normal_equations import triangular_factor
from analysis.identification.parameters import to_poles
from analysis.identification.pole_residue import fill_columns
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.superfluous import sum_of_squares
from analysis.identification.sweeps_search import SweepsAt, SweepsSearch
from analysis.identification.variable_projection import change_with_poles

MOST_ADDED = 4
"""Largest number of added modes."""

REACH = 2.0
"""Largest distance of a hidden mode from a track, in half widths."""

LARGEST = 2.0
"""Largest residue of a hidden mode, relative to the others: model errors may give larger ones."""

ALIKE = 2.0
"""Distance, in half widths, within which places are alternatives for one mode."""

MOST_CERTAIN = 100.0
"""Log odds at which they are clipped, as good as certain."""


@dataclass(frozen=True)
class Unseen:
    """Places at which a mode may be hidden.

    Attributes
    ----------
    place : (T, G, 2) ndarray
        Log |lambda| and log damping ratio of G places in T sweeps.
    active : (T, G) ndarray of bool
        Sweeps in which a mode there would stand in band.
    gain : (G,) ndarray
        Fall of the sum of squares with a mode there, in variances of one number, with the prior that its residues
        are about as large as those of the other modes.
    spread : (T, J, 2, 2) ndarray
        What hidden modes add to the covariance of the J tracks.
    """

    place: NDArray[np.float64]
    active: NDArray[np.bool_]
    gain: NDArray[np.float64]
    spread: NDArray[np.float64]


def add_unseen(
    lines: Sequence[Lines],
    terms: Sequence[ResidualTerms],
    fitted: JointFit,
    tracks: SmoothTracks,
    told: NDArray[np.bool_],
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
    told : (T,) ndarray of bool
        Sweeps that tell of hidden modes: not those whose residual is something else.

    Returns
    -------
    JointFit
        The J tracks and the added ones; their covariance includes the effect of modes still hidden.
    """
    values = sum(one.independent for one in lines)
    price = (2 * len(lines[0].h) + tracks.basis.shape[1] + 2) * np.log(values)
    for left in reversed(range(MOST_ADDED + 1)):
        found = look_for_unseen(lines, terms, fitted, tracks, told)
        best = int(np.argmax(found.gain))
        if not left or found.gain[best] < price:
            break
        new = found.place[:, [best]]
        takes_part = np.stack([active_in(row, one) for row, one in zip(new, lines, strict=True)])
        place = np.concatenate([fitted.place, new], axis=1)
        active = np.concatenate([fitted.active, takes_part], axis=1)
        wider = tracks.one_more()
        target = sum_of_squares(lines, fitted) - price
        trial = fit_together(lines, terms, place, active, wider, target=target)
        if sum_of_squares(lines, trial) > target:
            break
        fitted, tracks = trial, wider
    return replace(fitted, hidden=found.spread)


def look_for_unseen(
    lines: Sequence[Lines],
    terms: Sequence[ResidualTerms],
    fitted: JointFit,
    tracks: SmoothTracks,
    told: NDArray[np.bool_],
) -> Unseen:
    """Look for modes that the tracks of a joint fit hide.

    Parameters
    ----------
    lines : sequence of Lines
        T sweeps, as fitted.
    terms : sequence of ResidualTerms
        Of each.
    fitted : JointFit
        Of J tracks.
    tracks : SmoothTracks
    told : (T,) ndarray of bool
        Sweeps that tell of hidden modes: not those whose residual is something else.

    Returns
    -------
    Unseen
    """
    search = SweepsSearch(lines, terms, fitted.active, tracks, fitted.looks)
    now = search.at(fitted.place, np.ones(len(lines), dtype=bool))
    inverse, _, outer = search.curvature(now, np.zeros(len(lines)))
    numbers = search.nearest(now.x, np.zeros(tracks.count), tracks.scatter)
    rest = search.step(now, numbers, np.zeros(len(lines))).reshape(len(lines), -1)
    follows = tracks.moves(np.tile(np.eye(2 * now.x.shape[1]), (len(lines), 1, 1)))
    place, density = _places(fitted, lines)
    active = _inside(place, lines) & told[:, None]
    logarithm, moved = np.zeros(place.shape[1]), []
    gain = np.zeros(place.shape[1])
    for pull, seen, score in _pulls(search, now, place, active):
        slope = np.tensordot(follows, search.held[:, None] * (inverse @ pull), ((0, 1), (0, 1)))
        along = follows @ np.linalg.solve(outer, slope)
        steps = inverse @ (pull + search.held[:, None] * along)
        known = 1.0 + np.maximum(seen - (pull * steps).sum(axis=(0, 1)), 0.0)
        score = score - np.einsum("tig,ti->g", pull, rest)  # as for a fully converged fit
        gain += (score**2 / known).reshape(-1, 2).sum(axis=1)
        logarithm -= 0.5 * np.log(known).reshape(-1, 2).sum(axis=1)
        size = np.minimum((score / known) ** 2, LARGEST**2) + 1.0 / known
        moved.append(steps * np.sqrt(size))
    odds = density * np.exp(np.minimum(0.5 * gain + logarithm, MOST_CERTAIN))
    apart = reduce(np.minimum, (np.abs(row[:, None] - row) for row in place[:, :, 0]))  # one (G, G) at a time
    rivals = apart < ALIKE * np.exp(np.median(place[:, :, 1]))
    probable = np.sqrt(np.repeat(odds / (1.0 + rivals @ odds), 2))
    each = (np.concatenate(moved, axis=2) * np.tile(probable, len(moved))).reshape(*now.x.shape, -1)
    return Unseen(place, active, gain, each @ each.swapaxes(-1, -2))


def _places(fitted: JointFit, lines: Sequence[Lines]) -> tuple[NDArray[np.float64], float]:
    """Places (T, G, 2) near the tracks, parallel to them, and the expected number of modes at each."""
    used = np.flatnonzero(fitted.active.any(axis=0))
    used = used[np.argsort(fitted.place[:, used, 0].mean(axis=0), kind="stable")]
    middle = fitted.place[:, used, 0].mean(axis=0)
    inside = fitted.active & _inside(fitted.place, lines)
    damping = np.array(
        [
            np.median(row[there if there.any() else slice(None)])
            for row, there in zip(fitted.place[:, :, 1], inside, strict=True)
        ]
    )
    step, reach = float(np.exp(damping.min())), REACH * float(np.exp(damping.max()))
    grid = np.arange(middle[0], middle[-1] + step, step)
    density = len(used) / len(grid)
    grid = grid[np.abs(grid[:, None] - middle).min(axis=1) < reach]
    place = np.empty((len(fitted.place), len(grid), 2))
    for t, row in enumerate(fitted.place[:, used, 0]):
        place[t, :, 0] = grid + np.interp(grid, middle, row - middle)
    place[:, :, 1] = damping[:, None]
    return place, density


def _inside(place: NDArray[np.float64], lines: Sequence[Lines]) -> NDArray[np.bool_]:
    """Which places (T, N, 2) stand in band."""
    band = np.log(2.0 * np.pi * np.array([one.frequency[[0, -1]] for one in lines]))
    return np.asarray((place[:, :, 0] > band[:, :1]) & (place[:, :, 0] < band[:, 1:]))


def _pulls(
    search: SweepsSearch, now: SweepsAt, place: NDArray[np.float64], active: NDArray[np.bool_]
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """Yield the effect of modes with a typical residue, response by response.

    Each item: mixed derivatives (T, 2J, 2G) with the poles' parameters, real and imaginary residue alternating;
    squared norms (2G,); products with the data (2G,). Other residues are refitted; unit: variance of one number.
    """
    sweeps, responses = range(len(place)), range(len(search.lines[0].h))
    each = [_pulls_of_sweep(search, now, t, place[t], active[t]) for t in sweeps]
    for response in responses:
        pull = np.zeros((len(place), 2 * now.x.shape[1], 2 * place.shape[1]))
        seen, score = np.zeros((2, 2 * place.shape[1]))
        for t in sweeps:
            numbers = np.flatnonzero(np.repeat(search.active[t], 2))
            for own_pull, own_seen, own_score in each[t][response : response + 1]:
                pull[t, numbers] = own_pull
                seen += own_seen
                score += own_score
        yield pull, seen, score


def _pulls_of_sweep(
    search: SweepsSearch, now: SweepsAt, t: int, place: NDArray[np.float64], active: NDArray[np.bool_]
) -> list[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """Return the same for one sweep, one row per parameter of its poles; an empty list if none is in band."""
    lines, look = search.lines[t], now.looks[t]
    poles, count = look.poles, len(look.poles)
    known = _inside(now.x[t : t + 1], [lines])[0, search.active[t]]
    if not known.any():
        return []
    fixed = lines.term_columns(search.terms[t])
    linear = 2 * count + len(fixed)
    parts = [linear, linear + 2 * count + 1]
    columns, room = lines.room.arrays(parts[-1] + 2 * len(place), len(lines.s))
    own, moves, new = np.split(columns, parts)
    fill_columns(lines.s, poles, lines.spread, own[: 2 * count], moves[:-1])
    own[2 * count :] = fixed
    fill_columns(lines.s, to_poles(place), lines.spread, new)
    found = []
    for h, deviation, residues in zip(lines.h, lines.deviation, look.residues, strict=True):
        moves[-1] = h
        weight = np.repeat(1.0 / deviation, 2) / np.sqrt(0.5 * lines.correlation)
        linears, others, added = np.split(np.multiply(columns.view(float), weight, out=room.view(float)), parts)
        triangle, lengths = triangular_factor(linears, linear)
        onto = dtrtrs(triangle, linears @ others.T / lengths[:, None], trans=1)[0]
        added_onto = dtrtrs(triangle, linears @ added.T / lengths[:, None], trans=1)[0]
        left = others @ added.T - onto.T @ added_onto
        size = np.median(np.abs(residues * poles)[known]) * np.repeat(np.exp(-place[:, 0]) * active, 2)
        change = change_with_poles(residues, poles).swapaxes(1, 2)
        pull = (change @ left[:-1].reshape(count, 2, -1)).reshape(2 * count, -1)
        alone = np.einsum("gf,gf->g", added, added) - (added_onto**2).sum(axis=0)
        found.append((pull * size, alone * size**2, left[-1] * size))
    return found
