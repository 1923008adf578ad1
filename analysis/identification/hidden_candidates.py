"""Candidates for hidden modes: places near the tracks, and how a mode there would change misfit and poles."""

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from scipy.linalg.lapack import dtrtrs

from analysis.arrays import Mask, Real
from analysis.identification.joint_fit import JointFit
from analysis.identification.lines import Lines
from analysis.identification.normal_equations import factor_of_gram
from analysis.identification.parameters import to_poles
from analysis.identification.sweeps_search import SweepsAt, SweepsSearch
from analysis.identification.variable_projection import change_with_poles

REACH = 2.0
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
    step, reach = float(np.exp(damping.min())), REACH * float(np.exp(damping.max()))
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
    search : SweepsSearch
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
