"""Joint fit of all sweeps of a campaign, with the modes of every sweep and their status."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.finishing import judged
from analysis.identification.joint_fit import fit_together
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.parameters import to_poles
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.settings import Settings
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.superfluous import paying
from analysis.identification.unseen import add_unseen
from analysis.identification.variable_projection import Projection

ROUGHLY = 20.0
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
    must_pay: bool = False,
) -> tuple[tuple[Modes, ...], NDArray[np.int64], NDArray[np.float64]]:
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
    tracks : SmoothTracks
    settings : Settings
        Of the status.
    progress : callable, optional
        Called with the stage and the share done.
    must_pay : bool
        Whether tracks are removed or added by BIC over all sweeps; the uncertainty from modes that stay hidden is
        then included in the standard deviations.

    Returns
    -------
    modes : tuple of Modes
        One per sweep.
    table : (T, N) ndarray of int
        Place of each track's pole in the sweep's modes; -1 where it takes no part, or out of band. Added tracks
        follow the J given.
    place : (T, N, 2) ndarray
        Log |lambda| and log damping ratio of all tracks.
    """
    told = progress or (lambda stage, share: None)
    lines = [one.lines() for one in measured]
    blocks = [averaged(one) for one in lines]
    rough = fit_together(blocks, terms, start, active, tracks, settled=ROUGHLY)
    told("identify", 0.5)
    fits = _fits(rough.looks, terms)
    weighed = [one.reweighted(own, now) for one, own, now in zip(measured, lines, fits, strict=True)]
    excess = [
        _excess(own, now, last.correlation) if one.known else 1.0
        for one, own, now, last in zip(measured, blocks, fits, weighed, strict=True)
    ]
    blocks = [averaged(one) for one in weighed]
    blocks = [replace(one, deviation=by * one.deviation) for one, by in zip(blocks, excess, strict=True)]
    if must_pay:
        tracks = tracks.learned(rough.place, rough.active)
        rough = paying(blocks, terms, rough, tracks, ROUGHLY)
        told("identify", 0.7)
    known = rough.looks if must_pay else ()  # otherwise the weights have changed
    last = fit_together(blocks, terms, rough.place, rough.active, tracks, known=known)
    if must_pay and last.active.any():
        last = add_unseen(blocks, terms, last, tracks, np.array(excess) <= UNLIKE_OTHERS * np.median(excess))
    active = last.active
    told("identify", 0.9)
    table = np.full(active.shape, -1, dtype=np.int64)
    found = []
    for t, one in enumerate(weighed):
        columns = np.flatnonzero(active[t])
        poles = to_poles(last.place[t, columns])
        modes, place = judged(
            one, fit(one, poles, terms[t], max_iterations=0), settings, last.covariance[t, columns]
        )
        inside = (poles.imag > 2.0 * np.pi * modes.band[0]) & (poles.imag < 2.0 * np.pi * modes.band[1])
        table[t, columns] = np.where(inside, place, -1)
        found.append(modes)
    told("identify", 1.0)
    return tuple(found), table, last.place


def _fits(looks: Sequence[Projection], terms: Sequence[ResidualTerms]) -> list[PoleFit]:
    return [
        PoleFit(look, own, 0, True, np.zeros(len(look.poles), dtype=bool))
        for look, own in zip(looks, terms, strict=True)
    ]


def _excess(blocks: Lines, fitted: PoleFit, correlation: float) -> float:
    """Ratio of a fit's errors to the stated standard deviations, at least 1, for correlated lines."""
    freedom = max(blocks.values - fitted.parameters * correlation, 1.0)
    return max(float(np.sqrt(2.0 * (fitted.projection.misfit + blocks.hidden) / freedom)), 1.0)
