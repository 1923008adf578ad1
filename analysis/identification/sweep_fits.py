"""Joint fit of all sweeps of a campaign, with the modes of every sweep and their status."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.finishing import judged
from analysis.identification.hidden_modes import add_hidden_modes, remove_superfluous
from analysis.identification.joint_fit import JointFit, fit_together
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.parameters import to_poles
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.settings import Settings
from analysis.identification.smooth_tracks import SmoothTracks

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
