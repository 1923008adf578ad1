"""Tracks of a campaign's modes, found without a twin.

The coldest and the hottest sweep are identified without start values, and the poles of the one that shows more
modes are followed to all others: tracks must not depend on the end where one begins. Then all sweeps are fitted
jointly with tracks that are smooth in temperature; tracks that BIC over all sweeps does not support are removed.
Where a sweep stays poor, all is done once more with poles farther outside the band.

A polymer's modulus shifts all frequencies by nearly the same factor, and its loss factor all damping ratios. So
one common step of both is fitted from sweep to sweep, and a prior holds every pole near it: overlapping modes
cannot change places, and heavily damped ones are not lost. A pole is added where BIC supports it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.averaging import averaged
from analysis.identification.judgement.resolution import unresolved
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.missing import gains, matched, residual
from analysis.identification.modes import Modes
from analysis.identification.order import pole_penalty
from analysis.identification.over_temperature.joint_fit import JointFit, fit_together
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.over_temperature.sweep_fits import fit_sweeps
from analysis.identification.pole_residue import (
    BAND_MARGIN,
    WIDER_BAND_MARGIN,
    ResidualTerms,
    active_in,
    to_parameters,
    to_poles,
)
from analysis.identification.pole_search import PoleFit, misfit_at
from analysis.identification.settings import Settings

Method = Callable[[Measured, Settings], Modes]

HIDDEN_SCATTER = (2e-3, 0.05)
"""Scatter of log |lambda| and log damping ratio about their curves without a twin: modes that no sweep shows bias
their neighbours by about as much. On a polypropylene plate with one sensor, 95 % intervals with a scatter of 0.02
% and 0.2 % held 79 % and 57 % of the modes, with this one 86 % and 88 %, and errors are no larger. With the
uncertainty from hidden modes included they hold 92 % and 94 %."""

BACKGROUND_DAMPING = (1.0, 0.5)
"""Standard deviations of a background pole's own log damping ratio: constant, and along temperature."""


OWN_STEP = (2e-3, 0.02)
"""Standard deviations of a mode's own step from one sweep to the next, log |lambda| and log damping ratio."""
BACKGROUND_STEP = (0.02, 0.2)
"""The same for a background pole, which represents modes out of band or curvature of the background."""
MOST_DAMPED = 0.5
"""Largest predicted damping ratio."""
MOST_NEW = 4
"""Most new poles in one sweep."""
SAME_MODE = 1.5
"""Largest distance, in half widths, between a mode's predicted and found pole after a fresh start."""
POOR_MISFIT = 1.5
"""Misfit, over the expected one, above which a sweep is identified anew without start values."""
WORTH_TRYING = 0.5
"""A new pole is tried if, with all others held, the misfit falls by this share of its BIC penalty."""
LIKE_OTHERS = 0.5
"""Largest distance of log damping ratio from the modes' median at which a new pole in band counts as a mode."""


@dataclass
class Followed:
    """Poles of the sweeps done so far.

    Attributes
    ----------
    temperature : (T,) ndarray
        Degrees Celsius, of all sweeps.
    terms : ResidualTerms
    place : (T, J, 2) ndarray
        Log |lambda| and log damping ratio, NaN where not known.
    mode : (J,) ndarray of bool
        Which are modes; the others are background.
    done : list of int
        Sweeps.
    beyond : float
        See `parameters.active_in`.
    """

    temperature: NDArray[np.float64]
    terms: ResidualTerms
    place: NDArray[np.float64]
    mode: NDArray[np.bool_]
    done: list[int] = field(default_factory=list)
    beyond: float = BAND_MARGIN

    @classmethod
    def started(
        cls, temperature: NDArray[np.float64], sweep: int, modes: Modes, terms: ResidualTerms, beyond: float
    ) -> "Followed":
        """Begin with the poles of one sweep.

        Parameters
        ----------
        temperature : (T,) ndarray
            Degrees Celsius, of all sweeps.
        modes : Modes
            Of that sweep.
        terms : ResidualTerms
            Of all sweeps.
        beyond : float
            See `parameters.active_in`.
        """
        place = np.full((len(temperature), len(modes.poles), 2), np.nan)
        place[sweep] = to_parameters(modes.poles)
        return cls(temperature, terms, place, modes.real.copy(), [sweep], beyond)

    def nearest(self, sweep: int) -> list[int]:
        """Sweeps done, nearest in temperature first, then latest."""
        away = np.abs(self.temperature[self.done] - self.temperature[sweep])
        return [self.done[n] for n in np.lexsort((-np.arange(len(self.done)), np.round(away, 3)))]

    def predicted(self, sweep: int) -> tuple[NDArray[np.float64], bool]:
        """Every pole (J, 2) at a sweep, moved on along its trend, and whether there is a trend yet."""
        source, *others = self.nearest(sweep)
        here = self.filled(source)
        step = self.temperature[sweep] - self.temperature[source]
        for other in others:
            base = self.temperature[source] - self.temperature[other]
            if abs(base) > 0.5 and abs(step) <= 1.5 * abs(base):
                trend = (here - self.filled(other)) / base
                trend[~self.mode] = _middle(trend[self.guide])  # background has none of its own
                here += trend * step
                here[:, 1] = np.minimum(here[:, 1], np.log(MOST_DAMPED))
                return here, True
        return here, False

    @property
    def guide(self) -> NDArray[np.bool_]:
        """Poles from which the common step is computed: the modes, or all poles where there are no modes."""
        return self.mode if self.mode.any() else ~self.mode

    def filled(self, sweep: int) -> NDArray[np.float64]:
        """Poles at a sweep, (J, 2); where unknown, those of the nearest sweep, moved by the common step."""
        place: NDArray[np.float64] = self.place[sweep].copy()
        for j in np.flatnonzero(np.isnan(place[:, 0])):
            known = next(t for t in self.nearest(sweep) if np.isfinite(self.place[t, j, 0]))
            step = (self.place[sweep] - self.place[known])[self.guide]
            place[j] = self.place[known, j] + _middle(step[np.isfinite(step[:, 0])])
            place[j, 1] = min(place[j, 1], np.log(MOST_DAMPED))
        return place

    def _add(self, sweep: int, place: NDArray[np.float64], mode: bool) -> None:
        """Add a pole that one sweep shows."""
        unknown = np.full((len(self.temperature), 1, 2), np.nan)
        self.place = np.concatenate([self.place, unknown], axis=1)
        self.place[sweep, -1] = place
        self.mode = np.append(self.mode, mode)


def follow(known: Followed, sweep: int, measured: Measured, usual: float, settings: Settings) -> None:
    """Fit one more sweep, starting from the poles of the sweeps done.

    Parameters
    ----------
    known : Followed
        The sweep's poles are added to it.
    measured : Measured
        The sweep.
    usual : float
        Expected misfit, as a share of rms |h|.
    settings : Settings
        Used if the sweep has to be identified without start values.
    """
    lines = measured.lines()
    blocks = averaged(lines)
    start, moving = known.predicted(sweep)
    if not moving:
        start[:, 0] += _common_step(blocks, start, known)
    found = _held(blocks, start, known)
    poor = _left(lines, found, known) > POOR_MISFIT * usual
    if poor and moving:  # the trend may have changed
        start[:, 0] += _common_step(blocks, start, known)
        found = _held(blocks, start, known)
        poor = _left(lines, found, known) > POOR_MISFIT * usual
    if poor:
        _afresh(known, sweep, start, identify(measured, settings))
        found = _held(blocks, known.filled(sweep), known)
    known.done.append(sweep)
    known.place[sweep] = found.place[0]
    lines = measured.reweighted(lines, _as_fit(found, known.terms))
    blocks = averaged(lines)
    if not measured.known:
        found = _held(blocks, known.place[sweep], known)
    for _ in range(MOST_NEW):
        added = _with_new_pole(known, sweep, lines, blocks, found)
        if added is None:
            break
        found = added
    known.place[sweep] = found.place[0]


WIDEST_STEP = 0.12
"""Range of the first scan: largest shift of log frequency from one sweep to the next."""

WIDE_MISFIT = 0.1
"""Unexplained share of the FRF's energy at the best factor above which a wider scan is made."""


def common_factor(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> tuple[float, bool]:
    """Find the common factor on all poles that explains the FRFs best.

    A scan in steps of half the median half width, no coarser than 0.5 %, then a parabola through the lowest three;
    three times as wide where the lowest is at the edge or leaves a large residual.

    Parameters
    ----------
    poles : (J,) complex ndarray
        Upper half plane, rad/s.

    Returns
    -------
    factor : float
    edge : bool
        Whether the lowest misfit is at the edge of the scan.
    """
    zeta = float(np.median(-poles.real / np.abs(poles))) if len(poles) else 0.01
    step = min(max(0.5 * zeta, 1e-3), 5e-3)
    energy = float((np.abs(lines.h / lines.deviation) ** 2).sum())
    grid, misfit = _scan(lines, poles, terms, WIDEST_STEP, step)
    if not 0 < np.argmin(misfit) < len(grid) - 1 or misfit.min() > WIDE_MISFIT * energy:
        grid, misfit = _scan(lines, poles, terms, 3.0 * WIDEST_STEP, step)
    lowest = int(np.argmin(misfit))
    if not 0 < lowest < len(grid) - 1:
        return float(np.exp(grid[lowest])), True
    left, middle, right = misfit[lowest - 1 : lowest + 2]
    bend = left - 2.0 * middle + right
    offset = 0.5 * (left - right) / bend if bend > 0.0 else 0.0
    return float(np.exp(grid[lowest] + step * offset)), False


def _scan(
    lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms, widest: float, step: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Shifts of log frequency to either side, and the misfit at each."""
    grid = step * np.arange(-np.ceil(widest / step), np.ceil(widest / step) + 1)
    return grid, np.array([misfit_at(lines, poles * np.exp(g), terms) for g in grid])


def _common_step(blocks: Lines, start: NDArray[np.float64], known: Followed) -> float:
    """Shift of log |lambda| of all poles (J, 2) that explains a sweep best."""
    active = active_in(start, blocks.frequency, known.beyond)
    return float(np.log(common_factor(blocks, to_poles(start[active]), known.terms)[0]))


def _held(blocks: Lines, start: NDArray[np.float64], known: Followed) -> JointFit:
    """Fit one sweep with every pole held near the common step."""
    tracks = SmoothTracks.polynomials(np.zeros(1), start[None])
    tracks.own[:, 0] = np.square(np.where(known.mode[:, None], OWN_STEP, BACKGROUND_STEP))
    active = active_in(start, blocks.frequency, known.beyond)[None]
    return fit_together([blocks], [known.terms], start[None], active, tracks, settled=2.0, most=12)


def _left(lines: Lines, found: JointFit, known: Followed) -> float:
    """Root mean square of a fit's residual, as a share of that of |h|."""
    return float(np.linalg.norm(residual(lines, _as_fit(found, known.terms))) / np.linalg.norm(lines.h))


def _with_new_pole(known: Followed, sweep: int, lines: Lines, blocks: Lines, found: JointFit) -> JointFit | None:
    """Add the pole that explains most of the residual, if BIC falls; return the fit with it, or None."""
    now = _as_fit(found, known.terms)
    candidates = matched(lines, residual(lines, now), shortlist=4)
    if len(candidates) == 0:
        return None
    gain = gains(blocks, now, candidates)
    misfit = found.projections[0].misfit
    penalty = pole_penalty(lines) * max((misfit + blocks.hidden) / lines.independent, 0.5 * lines.redundancy)
    if gain.max() < WORTH_TRYING * penalty:
        return None
    pole = candidates[[int(gain.argmax())]]
    place = np.concatenate([known.place[sweep], to_parameters(pole)])
    with_it = replace(known, place=place[None], mode=np.append(known.mode, False))
    tried = _held(blocks, place, with_it)
    projection = tried.projections[0]
    if misfit - projection.misfit < penalty or unresolved(lines, projection.poles, projection.residues).any():
        return None
    new, others = tried.place[0, -1], tried.place[0, :-1, 1][known.guide]
    inside = lines.frequency[0] < np.exp(new[0]) / (2.0 * np.pi) < lines.frequency[-1]
    like = len(others) == 0 or abs(new[1] - np.median(others)) < LIKE_OTHERS
    known.place[sweep] = tried.place[0, :-1]
    known._add(sweep, new, bool(inside and like))
    return tried


def _middle(steps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Median (2,) of the steps (N, 2) of several poles; zero where there is no pole."""
    return np.asarray(np.median(steps, axis=0) if len(steps) else np.zeros(2))


def _as_fit(found: JointFit, terms: ResidualTerms) -> PoleFit:
    return PoleFit(found.projections[0], terms, 0, True, np.zeros(int(found.active.sum()), dtype=bool))


def _afresh(known: Followed, sweep: int, start: NDArray[np.float64], fresh: Modes) -> None:
    """Take a sweep's poles from an identification of its own, and match them to the predicted ones nearby."""
    from scipy.optimize import linear_sum_assignment  # its import takes long, and a new start is seldom needed

    place = to_parameters(fresh.poles)
    away = np.abs(start[:, None, 0] - place[None, :, 0]) / np.exp(place[None, :, 1])
    for j, n in zip(*linear_sum_assignment(np.minimum(away, 10.0)), strict=True):
        if away[j, n] < SAME_MODE:
            known.place[sweep, j] = place[n]
            place[n] = np.nan
    for n in np.flatnonzero(np.isfinite(place[:, 0])):
        known._add(sweep, place[n], bool(fresh.real[n]))


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
