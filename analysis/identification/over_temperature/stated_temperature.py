"""Poles at the temperature stated for their sweep, where the sine passed them at another one.

On a ramp a sine passes each frequency f at a temperature T + d(f) of its own. A pole lambda(T) of the plate then
appears at p = lambda(T + d(p / 2 pi j)), with the drift d continued to complex frequencies: its real part moves
the pole along its track, its imaginary part, the drift over a half width, stretches the resonance. To first order
lambda(T) = p (1 - s d), with s = d log lambda / dT from the pole's own track. Residues change by the share
s f dd/df, alike for all sensors; they stay as fitted.

The repeats of a sweep, of which the mean is taken, have temperatures of their own. If the frequencies move over
them with the relative standard deviation u (`analysis.recordings.h1`), the mean is R/x + (u lambda)**2 R/x**3 to
second order, x = j w - lambda. In the sense of least squares over all w, 1/x**3 is nearest to a change of 1/x by a
wider pole: the damping ratio zeta appears too large by the share (u/zeta)**2.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Real, Whole
from analysis.gap.data.groups import LawSmoothness, TemperatureGroups
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.pole_residue import LARGEST_DAMPING, to_parameters, to_poles
from analysis.protocol.objections import STIFFNESS_CHANGE
from analysis.recordings.sweep_point import SweepPoint


def at_stated_temperature(
    tracked: TrackedModes, points: Sequence[SweepPoint], shift: Real | None = None
) -> TrackedModes:
    """Correct poles to the temperatures stated for their sweeps.

    Parameters
    ----------
    tracked : TrackedModes
        As fitted.
    points : sequence of SweepPoint
        Of its sweeps, with the drift of the temperature where it is known.
    shift : (T,) ndarray, optional
        Relative standard deviation of all frequencies over the repeats of each sweep.

    Returns
    -------
    TrackedModes
        With `Modes.corrected`, and the uncertainty of the corrections in `Modes.covariance`. Poles stay at the
        temperatures of their lines where there is no drift, or in a direction with one temperature only, which
        tells no slope: a note says so where it may matter.
    """
    modes, notes = list(tracked.modes), list(tracked.notes)
    if shift is not None:
        modes = [_of_one_repeat(*one) for one in zip(modes, shift.tolist(), strict=True)]
    for way in dict.fromkeys(tracked.direction):  # at one reading the plate may be warmer on the way down
        leg = np.array([t for t, one in enumerate(tracked.direction) if one == way])
        drifting = [t for t in leg.tolist() if points[t].drifts and len(modes[t].poles)]
        groups = TemperatureGroups.of(tracked.temperature[leg])
        known = _slopes(_tracks(tracked, leg, groups), groups.reference) if drifting else None
        if known is None:
            notes.extend(_said(way, [(modes[t], points[t]) for t in drifting]))
            continue
        for t in drifting:
            group, column = groups.of_sweep[leg == t][0], _columns(tracked, t)
            modes[t] = _corrected(modes[t], points[t], *known[:, group, column])
    return replace(tracked, modes=tuple(modes), notes=tuple(notes))


def _tracks(tracked: TrackedModes, leg: Whole, groups: TemperatureGroups) -> Real:
    """Log |pole| and log damping ratio of tracks, mean of the sweeps of each group, (G, J, 2); NaN if absent."""
    place = np.full((len(leg), tracked.track.shape[1], 2), np.nan)
    for row, t in enumerate(leg):
        there = tracked.track[t] >= 0
        place[row, there] = to_parameters(tracked.modes[t].poles)[tracked.track[t, there]]
    count = groups.total(np.isfinite(place).astype(float))
    return np.asarray(groups.total(np.nan_to_num(place)) / np.where(count > 0.0, count, np.nan))


def _slopes(place: Real, temperature: Real) -> Real | None:
    """Slopes of tracks (G, J, 2) over temperature, per K, and their standard deviations, (2, G, J + 1, 2).

    The last column, and tracks that only one temperature shows, have the median of the other tracks, with their
    spread for a standard deviation. None where no track has a slope.
    """
    found = np.full((2, len(place), place.shape[1] + 1, 2), np.nan)
    for j, column in enumerate(place.swapaxes(0, 1)):
        there = np.isfinite(column[:, 0])
        if there.sum() > 1:
            smoothness = LawSmoothness.of(temperature[there], column[there])
            found[0, there, j], found[1, there, j] = (
                smoothness.derivatives(column[there])[0],
                smoothness.slope_sigma,
            )
    known = np.isfinite(found[0, :, :, 0])
    if not known.any():
        return None
    for g, here in enumerate(known):
        slope, sigma = found[:, g, here] if here.any() else found[:, known]
        found[0, g, ~here] = np.median(slope, axis=0)
        found[1, g, ~here] = np.hypot(slope.std(axis=0), np.median(sigma, axis=0))
    return found


def _columns(tracked: TrackedModes, t: int) -> Whole:
    """Track of each pole of a sweep; -1, the last column of the slopes, for poles without one."""
    column = np.full(len(tracked.modes[t].poles), -1)
    there = np.flatnonzero(tracked.track[t] >= 0)
    column[tracked.track[t, there]] = there
    return column


def _of_one_repeat(modes: Modes, shift: float) -> Modes:
    """Correct the damping of a sweep for the mean over its repeats."""
    if not shift:
        return modes
    place = to_parameters(modes.poles)
    wider = np.log1p((shift / np.exp(place[:, 1])) ** 2)
    place[:, 1] -= wider
    # neighbours and the weights of a fit change what the mean over repeats makes of a pole by half of it
    covariance = modes.covariance + np.square(0.5 * wider)[:, None, None] * np.diag([0.0, 1.0])
    return replace(modes, corrected=to_poles(place), covariance=covariance)


def _corrected(modes: Modes, point: SweepPoint, slope: Real, sigma: Real) -> Modes:
    """Correct the poles (J,) of a sweep with the slopes of log |pole| and log damping ratio, (J, 2), per K."""
    place, drift = to_parameters(modes.stated_poles), point.drift(modes.poles / 2j / np.pi)
    zeta = np.exp(place[:, 1])
    turn = zeta / np.sqrt(1.0 - zeta**2)  # of the pole's angle in the plane, by its log damping ratio
    change = (slope[:, 0] + 1j * turn * slope[:, 1]) * drift
    error = np.abs(drift)[:, None] * sigma
    covariance = modes.covariance + (error**2)[:, :, None] * np.eye(2)
    place -= np.column_stack([change.real, change.imag / turn])
    place[:, 1] = np.minimum(place[:, 1], np.log(LARGEST_DAMPING))  # where a track jumps, its slope is no slope
    return replace(modes, corrected=to_poles(place), covariance=covariance)


def _said(way: str, sweeps: Sequence[tuple[Modes, SweepPoint]]) -> list[str]:
    """Return a note on sweeps left uncorrected, if a soft polymer would change by more than is stated."""
    away = 0.0
    for modes, point in sweeps:
        reading, real = modes.reading(), np.flatnonzero(modes.real)
        drift = np.abs(point.drift(reading.frequency_hz[real]))
        matters = 0.5 * STIFFNESS_CHANGE * drift * reading.frequency_hz[real] > reading.sigma_frequency_hz[real]
        away = max(away, drift[matters].max(initial=0.0))
    if not away:
        return []
    return [
        f"one temperature on the way {way}: frequencies are those at the temperatures when the sine passed, up "
        f"to {away:.2g} K off ({50 * STIFFNESS_CHANGE * away:.2g} % of those of a soft polymer); from two "
        "temperatures on they are corrected"
    ]
