"""Modes of a campaign over temperature.

The coldest and the hottest sweep are identified without start values, and the poles of the one that shows more
modes are followed to all others: tracks must not depend on the end where one begins. Then all sweeps are fitted
jointly with tracks that are smooth in temperature; tracks that BIC over all sweeps does not support are removed.
With a method that identifies every sweep alone, modes are matched afterwards, by distance from their prediction
and by shape.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.frf import Frf
from analysis.identification.automatic import identify
from analysis.identification.averaging import averaged
from analysis.identification.common_factor import common_factor
from analysis.identification.expected_modes import ExpectedModes, fit_expected
from analysis.identification.following import Followed, active_in, follow
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.naming import NamedModes, enter, tabulated
from analysis.identification.settings import Settings
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.sweep_fits import fit_sweeps
from analysis.identification.tracked_modes import TrackedModes
from analysis.identification.work_arrays import WorkArrays

POOR = 1.15
"""Misfit, over the expected one, above which a sweep is reported."""

HIDDEN_SCATTER = (2e-3, 0.05)
"""Scatter of log |lambda| and log damping ratio about their curves without a twin: modes that no sweep shows bias
their neighbours by about as much. On a polypropylene plate with one sensor, 95 % intervals with a scatter of 0.02
% and 0.2 % held 79 % and 57 % of the modes, with this one 86 % and 88 %, and errors are no larger. With the
uncertainty from hidden modes included they hold 92 % and 94 %."""

BACKGROUND_DAMPING = (1.0, 0.5)
"""Standard deviations of a background pole's own log damping ratio: constant, and along temperature."""


def sweep_measured(frf: Frf, sweep: int) -> Measured:
    """Usable lines of one sweep, with their variance."""
    used = ~frf.excluded
    return Measured(frf.frequency[used], frf.h[sweep][:, used], frf.variance[sweep][:, used])


Method = Callable[[Measured, Settings], Modes]


def track(
    frf: Frf,
    settings: Settings | None = None,
    progress: Callable[[str, float], None] | None = None,
    method: Method | None = None,
    expected: ExpectedModes | None = None,
    start: int | None = None,
) -> TrackedModes:
    """Identify every sweep of a campaign and follow its modes.

    Parameters
    ----------
    frf : Frf
        All sensors of a sweep share their poles.
    settings : Settings, optional
        Of the identification.
    progress : callable, optional
        Called with the stage and the share done.
    method : callable, optional
        Identifies every sweep alone, without start values; modes are tracked afterwards.
    expected : ExpectedModes, optional
        Poles that a twin predicts for every sweep; its modes are fitted instead of a search, one track each.
    start : int, optional
        Number of the sweep, from 0, that is identified without start values, as is the one farthest from it in
        temperature; the coldest by default. Not used with `expected`.

    Returns
    -------
    TrackedModes

    Raises
    ------
    ValueError
        If a sweep's FRF is silent, or there is no sweep `start`.
    """
    settings = settings or Settings()
    if start is not None and not 0 <= start < len(frf.temperature):
        raise ValueError(f"start is sweep {start}; allowed 0 to {len(frf.temperature) - 1}")
    shared = WorkArrays()
    measured = [replace(sweep_measured(frf, t), work_arrays=shared) for t in range(len(frf.temperature))]
    if expected is not None:
        return _as_expected(frf, *fit_expected(frf.temperature, measured, expected, settings, progress))
    order = np.argsort(frf.temperature, kind="stable")
    if method is None:
        return _fitted_together(frf, measured, int(order[0]) if start is None else start, settings, progress)
    ends = {int(order[0]), int(order[-1])} if start is None else {start}
    start, first = _start(measured, ends, settings, method)
    done = NamedModes()
    enter(done, start, frf.temperature[start], first, 1.0)
    for count, t in enumerate(_outwards(frf.temperature, start), start=1):
        source = min(done.modes, key=lambda s: (abs(frf.temperature[s] - frf.temperature[t]), abs(s - t)))
        before = done.modes[source]
        shift, _ = common_factor(averaged(measured[t].lines()), before.poles, before.terms)
        modes = method(measured[t], settings)
        enter(done, t, frf.temperature[t], modes, done.factor[source] * shift)
        if progress is not None:
            progress("identify", (count + 1) / len(measured))
    return tabulated(done, frf, start)


def _fitted_together(
    frf: Frf,
    measured: Sequence[Measured],
    start: int,
    settings: Settings,
    progress: Callable[[str, float], None] | None,
) -> TrackedModes:
    """Follow the poles of one end to all other sweeps, then fit all sweeps jointly."""
    report = progress or (lambda stage, share: None)
    ends = {start, *_outwards(frf.temperature, start)[-1:]}
    start, first = _start(measured, ends, settings, identify)
    report("identify", 0.2)
    known = _followed(frf, measured, start, first, settings, lambda share: report("identify", 0.2 + 0.3 * share))
    measured = list(measured)
    measured[start] = measured[start].without(first.left_out(measured[start].frequency))
    place = np.stack([known.filled(t) for t in range(len(measured))])
    active = np.stack([active_in(row, one.lines()) for row, one in zip(place, measured, strict=True)])
    modes, table, place = fit_sweeps(
        measured,
        [known.terms] * len(measured),
        place,
        active,
        _prior(frf.temperature, place, known.mode),
        settings,
        lambda name, share: report(name, 0.5 + 0.5 * share),
        select_tracks=True,
    )
    modes = (*modes[:start], replace(modes[start], rejected=first.rejected), *modes[start + 1 :])
    usual = [_expected(one, first) for one in measured]
    poor = (_poor(*row) for row in zip(frf.temperature, range(len(modes)), modes, usual, strict=True))
    return TrackedModes(
        temperature=frf.temperature,
        direction=frf.direction,
        level=frf.level,
        level_unit=frf.level_unit(),
        channels=frf.channels,
        modes=modes,
        track=_shown_by_frequency(table, modes, place),
        start=start,
        notes=tuple(filter(None, poor)),
    )


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


def _followed(
    frf: Frf,
    measured: Sequence[Measured],
    start: int,
    first: Modes,
    settings: Settings,
    report: Callable[[float], None],
) -> Followed:
    """Follow the poles of one sweep to all others."""
    terms = max(settings.terms, key=lambda one: one.parameters)
    known = Followed.started(frf.temperature, start, first, terms)
    for count, t in enumerate(_outwards(frf.temperature, start), start=1):
        follow(known, t, measured[t], _expected(measured[t], first), settings)
        report(count / len(measured))
    return known


def _poor(temperature: float, sweep: int, modes: Modes, usual: float) -> str | None:
    """Message about a sweep with a large residual, or None."""
    if modes.misfit <= POOR * usual:
        return None
    return (
        f"{temperature:.1f} °C (sweep {sweep}): the model leaves {100 * modes.misfit:.2g} % of rms |h|, "
        f"{modes.misfit / usual:.1f} times what was expected: its modes are not reliable"
    )


def _as_expected(frf: Frf, modes: tuple[Modes, ...], table: NDArray[np.int64]) -> TrackedModes:
    """Tabulate the modes that a twin expected, those that are in band at some temperature."""
    return TrackedModes(
        temperature=frf.temperature,
        direction=frf.direction,
        level=frf.level,
        level_unit=frf.level_unit(),
        channels=frf.channels,
        modes=modes,
        track=table[:, (table >= 0).any(axis=0)],
        start=0,
    )


def _start(measured: Sequence[Measured], tried: set[int], settings: Settings, method: Method) -> tuple[int, Modes]:
    """Sweep that shows most modes, with its modes; `tried` are sweeps at the ends, where damping is least."""
    found = {t: method(measured[t], settings) for t in sorted(tried)}
    best = max(found, key=lambda t: (found[t].status.count("kept"), -found[t].misfit))
    return best, found[best]


def _outwards(temperature: NDArray[np.float64], start: int) -> list[int]:
    """All other sweeps, nearest in temperature to the start first."""
    distance = np.abs(temperature - temperature[start])
    return [int(t) for t in np.argsort(distance, kind="stable") if t != start]


def _expected(measured: Measured, before: Modes) -> float:
    """Misfit expected, as a share of rms |h|: the noise if it is known, else the neighbouring sweep's misfit."""
    if measured.known and measured.variance is not None:
        return float(np.sqrt(measured.variance.sum() / (np.abs(measured.h) ** 2).sum()))
    return before.misfit
