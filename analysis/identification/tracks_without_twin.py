"""Tracks of a campaign's modes, found without a twin.

The coldest and the hottest sweep are identified without start values, and the poles of the one that shows more
modes are followed to all others: tracks must not depend on the end where one begins. Then all sweeps are fitted
jointly with tracks that are smooth in temperature; tracks that BIC over all sweeps does not support are removed.
Where a sweep stays poor, all is done once more with poles farther outside the band.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.following import POOR_MISFIT, Followed, follow
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.parameters import BAND_MARGIN, WIDER_BAND_MARGIN, active_in
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.settings import Settings
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.sweep_fits import fit_sweeps

Method = Callable[[Measured, Settings], Modes]

HIDDEN_SCATTER = (2e-3, 0.05)
"""Scatter of log |lambda| and log damping ratio about their curves without a twin: modes that no sweep shows bias
their neighbours by about as much. On a polypropylene plate with one sensor, 95 % intervals with a scatter of 0.02
% and 0.2 % held 79 % and 57 % of the modes, with this one 86 % and 88 %, and errors are no larger. With the
uncertainty from hidden modes included they hold 92 % and 94 %."""

BACKGROUND_DAMPING = (1.0, 0.5)
"""Standard deviations of a background pole's own log damping ratio: constant, and along temperature."""


def find_tracks(
    temperature: NDArray[np.float64],
    measured: Sequence[Measured],
    start: int,
    settings: Settings,
    progress: Callable[[str, float], None] | None,
) -> tuple[tuple[Modes, ...], NDArray[np.int64], int, NDArray[np.float64]]:
    """Follow the poles of one end to all other sweeps, then fit all sweeps jointly.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    measured : sequence of Measured
        T sweeps.
    start : int
        Sweep that is identified without start values, as is the one farthest from it in temperature.
    progress : callable or None
        Called with the stage and the share done.

    Returns
    -------
    modes : tuple of Modes
        One per sweep.
    table : (T, N) ndarray of int
        Place of each track's pole in the sweep's modes, -1 where it has none; lowest frequency first.
    start : int
        Sweep whose poles were followed.
    excess : (T,) ndarray
        Ratio of the errors of each sweep to the stated standard deviations, 1 or more; 1 if none are stated.
    """
    report = progress or (lambda stage, share: None)
    ends = {start, *outwards(temperature, start)[-1:]}
    start, first = best_start(measured, ends, settings, identify)
    report("identify", 0.2)
    measured = list(measured)
    measured[start] = measured[start].without(first.left_out(measured[start].frequency))

    def tracked(beyond: float, stage: str) -> _Tracks:
        known = Followed.started(temperature, start, first, _terms(settings), beyond)
        _follow_all(known, measured, start, first, settings, lambda s: report(stage, 0.2 + 0.3 * s))
        return _fit_all(known, measured, settings, lambda _, share: report(stage, 0.5 + 0.5 * share))

    expected = [expected_misfit(one, first) if one.known else np.inf for one in measured]
    found = tracked(BAND_MARGIN, "identify")
    if found.worst(expected) > POOR_MISFIT:
        farther = tracked(WIDER_BAND_MARGIN, "identify, farther from the band")
        if farther.worst(expected) < POOR_MISFIT:
            found = farther
    modes = list(found.modes)
    modes[start] = replace(modes[start], rejected=first.rejected)
    return tuple(modes), _shown_by_frequency(found.table, modes, found.place), start, found.excess


@dataclass(frozen=True)
class _Tracks:
    """What `fit_sweeps` returns."""

    modes: tuple[Modes, ...]
    table: NDArray[np.int64]
    place: NDArray[np.float64]
    excess: NDArray[np.float64]

    def worst(self, expected: Sequence[float]) -> float:
        """Largest misfit of a sweep over that expected."""
        return max(one.misfit / usual for one, usual in zip(self.modes, expected, strict=True))


def _fit_all(
    known: Followed, measured: Sequence[Measured], settings: Settings, report: Callable[[str, float], None]
) -> _Tracks:
    """Fit all sweeps jointly, from the poles followed."""
    place = np.stack([known.filled(t) for t in range(len(measured))])
    rows = zip(place, measured, strict=True)
    active = np.stack([active_in(row, one.lines().frequency, known.beyond) for row, one in rows])
    prior = _prior(known.temperature, place, known.mode)
    terms = [known.terms] * len(measured)
    return _Tracks(*fit_sweeps(measured, terms, place, active, prior, settings, report, select_tracks=True))


def best_start(
    measured: Sequence[Measured], tried: set[int], settings: Settings, method: Method
) -> tuple[int, Modes]:
    """Identify some sweeps and choose the one that shows most modes.

    Parameters
    ----------
    tried : set of int
        Sweeps at the ends, because damping is least there.
    method : callable
        Identifies a sweep.

    Returns
    -------
    sweep : int
    modes : Modes
    """
    found = {t: method(measured[t], settings) for t in sorted(tried)}
    best = max(found, key=lambda t: (found[t].status.count("kept"), -found[t].misfit))
    return best, found[best]


def outwards(temperature: NDArray[np.float64], start: int) -> list[int]:
    """All other sweeps, nearest in temperature to the start first."""
    distance = np.abs(temperature - temperature[start])
    return [int(t) for t in np.argsort(distance, kind="stable") if t != start]


def _prior(temperature: NDArray[np.float64], place: NDArray[np.float64], mode: NDArray[np.bool_]) -> SmoothTracks:
    """Prior of the tracks of poles (T, J, 2), without a twin; those that are no mode (J,) are background."""
    tracks = SmoothTracks.polynomials(temperature, np.zeros_like(place))
    tracks = replace(tracks, scatter=np.array(HIDDEN_SCATTER))
    tracks.own[~mode, :2, 1] = np.square(BACKGROUND_DAMPING)[: tracks.own.shape[1]]
    return tracks


def _shown_by_frequency(
    table: NDArray[np.int64], modes: Sequence[Modes], place: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Columns of the table (T, N) whose pole is a mode in some sweep, lowest median frequency first."""
    table = table.copy()
    for t, one in enumerate(modes):
        table[t, (table[t] >= 0) & ~one.real[table[t]]] = -1
    shown = (table >= 0).any(axis=0)
    order = np.argsort(np.median(place[:, shown, 0], axis=0), kind="stable")
    return np.asarray(table[:, shown][:, order])


def _terms(settings: Settings) -> ResidualTerms:
    return max(settings.terms, key=lambda one: one.parameters)


def _follow_all(
    known: Followed,
    measured: Sequence[Measured],
    start: int,
    first: Modes,
    settings: Settings,
    report: Callable[[float], None],
) -> None:
    """Follow the poles of one sweep to all others."""
    for count, t in enumerate(outwards(known.temperature, start), start=1):
        follow(known, t, measured[t], expected_misfit(measured[t], first), settings)
        report(count / len(measured))


def expected_misfit(measured: Measured, before: Modes) -> float:
    """Misfit expected, as a share of rms |h|: the noise if it is known, else the neighbouring sweep's misfit."""
    if measured.known and measured.variance is not None:
        return float(np.sqrt(measured.variance.sum() / (np.abs(measured.h) ** 2).sum()))
    return before.misfit
