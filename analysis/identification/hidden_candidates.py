"""Candidates for hidden modes: places near the tracks, and how a mode there would change misfit and poles."""

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.linalg.lapack import dtrtrs

from analysis.arrays import Mask, Real
from analysis.identification.joint_fit import JointFit
from analysis.identification.lines import Lines
from analysis.identification.normal_equations import triangular_factor
from analysis.identification.parameters import to_poles
from analysis.identification.pole_residue import fill_columns
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
    fixed = lines.term_columns(search.terms[t])
    linear = 2 * count + len(fixed)
    parts = [linear, linear + 2 * count + 1]
    columns, weighted = lines.work_arrays.arrays(parts[-1] + 2 * len(place), len(lines.s))
    own, moves, new = np.split(columns, parts)
    fill_columns(lines.s, poles, lines.spread, own[: 2 * count], moves[:-1])
    own[2 * count :] = fixed
    fill_columns(lines.s, to_poles(place), lines.spread, new)
    found = []
    for h, deviation, residues in zip(lines.h, lines.deviation, projection.residues, strict=True):
        moves[-1] = h
        weight = np.repeat(1.0 / deviation, 2) / np.sqrt(0.5 * lines.correlation)
        linears, others, added = np.split(
            np.multiply(columns.view(float), weight, out=weighted.view(float)), parts
        )
        triangle, lengths = triangular_factor(linears, linear)
        onto = dtrtrs(triangle, linears @ others.T / lengths[:, None], trans=1)[0]
        added_onto = dtrtrs(triangle, linears @ added.T / lengths[:, None], trans=1)[0]
        left = others @ added.T - onto.T @ added_onto
        size = np.median(np.abs(residues * poles)[known]) * np.repeat(np.exp(-place[:, 0]) * active, 2)
        change = change_with_poles(residues, poles).swapaxes(1, 2)
        mixed = (change @ left[:-1].reshape(count, 2, -1)).reshape(2 * count, -1)
        alone = np.einsum("gf,gf->g", added, added) - (added_onto**2).sum(axis=0)
        found.append((mixed * size, alone * size**2, left[-1] * size))
    return found
