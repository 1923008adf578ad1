"""Modes of a campaign over temperature.

All sweeps are fitted jointly, with the tracks of a twin or with tracks found in the sweeps; a sweep that shares no
modes with the others is identified by itself. With a method that identifies every sweep alone, modes are matched
afterwards: a pole belongs to the nearest predicted mode. The prediction uses the common step of all modes and the
mode's own trend; the distance includes the shape, or the residue's phase where there is one sensor.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.identification.automatic import identify
from analysis.identification.averaging import averaged
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.expected_modes import ExpectedModes, fit_expected
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.over_temperature.tracks_without_twin import (
    Method,
    best_start,
    common_factor,
    expected_misfit,
    find_tracks,
    outwards,
)
from analysis.identification.settings import Settings
from analysis.recordings.frf import Frf

LEAST_BASE = 0.5
"""Smallest difference of temperature, K, between two sweeps from which a trend is computed."""

SAME_MODE = 1.5
"""Largest distance, in half widths, between a mode's predicted and found pole."""


@dataclass(frozen=True)
class Sighting:
    """A mode as one sweep showed it: its pole over the sweep's common factor, and its residues."""

    temperature: float
    pole: complex
    shape: NDArray[np.complex128]


@dataclass
class NamedModes:
    """Sweeps done so far, the common factor of each, and the sweeps and poles in which every mode was found."""

    modes: dict[int, Modes] = field(default_factory=dict)
    labels: dict[int, NDArray[np.int64]] = field(default_factory=dict)
    factor: dict[int, float] = field(default_factory=dict)
    seen: dict[int, list[Sighting]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def predict(self, label: int, temperature: float) -> Sighting:
        """Predict a mode at a temperature: its pole in the nearest sweep, extrapolated along its own trend.

        The trend is the mode's change relative to the common factor between the two nearest sweeps with it,
        extrapolated by at most one and a half times their distance.
        """
        nearest, *others = sorted(self.seen[label], key=lambda s: abs(s.temperature - temperature))
        step = temperature - nearest.temperature
        for other in others:
            base = nearest.temperature - other.temperature
            if abs(base) > LEAST_BASE and abs(step) <= 1.5 * abs(base):
                trend = np.log(abs(nearest.pole) / abs(other.pole)) / base
                return Sighting(temperature, nearest.pole * np.exp(trend * step), nearest.shape)
        return nearest


def enter(done: NamedModes, t: int, temperature: float, modes: Modes, factor: float) -> None:
    """Label the poles of a sweep: each gets the label of a known mode, a new one, or -1 for no mode.

    Parameters
    ----------
    done : NamedModes
        The sweep is added to it.
    t : int
        Sweep.
    temperature : float
        Degrees Celsius.
    factor : float
        Common factor of its frequencies, relative to the first sweep's.
    """
    from scipy.optimize import linear_sum_assignment  # its import takes long; joint fits need no labels

    labels = np.full(len(modes.poles), -1, dtype=np.int64)
    known = list(done.seen)
    candidates = [int(n) for n in np.flatnonzero(modes.real)]
    cost = np.array(
        [[_distance(done.predict(label, temperature), modes, n, factor) for n in candidates] for label in known]
    ).reshape(len(known), len(candidates))
    for row, column in zip(*linear_sum_assignment(np.minimum(cost, 100.0)), strict=True):
        if cost[row, column] < SAME_MODE + 1.0:
            labels[candidates[column]] = known[row]
    for n in candidates:
        if labels[n] < 0:
            labels[n] = max(done.seen, default=-1) + 1
        sighting = Sighting(temperature, modes.poles[n] / factor, modes.residues[:, n])
        done.seen.setdefault(int(labels[n]), []).append(sighting)
    done.modes[t], done.labels[t], done.factor[t] = modes, labels, factor


def _distance(known: Sighting, modes: Modes, n: int, factor: float) -> float:
    """Distance of a pole from a mode's prediction in half widths, plus up to 1 for a different shape or phase."""
    predicted, shape = known.pole * factor, known.shape
    pole, residue = modes.poles[n], modes.residues[:, n]
    width = -0.5 * (predicted.real + pole.real)
    away = abs(predicted.imag - pole.imag) / width
    if away > SAME_MODE:
        return np.inf
    overlap = np.vdot(shape, residue)
    size = np.linalg.norm(shape) * np.linalg.norm(residue)
    if len(shape) > 1:
        return float(away + 1.0 - abs(overlap) ** 2 / size**2)  # MAC
    return float(away + abs(np.angle(overlap)) / np.pi)


def tabulated(done: NamedModes, frf: Frf, start: int) -> TrackedModes:
    """Order modes by their frequency, referred to the start's temperature, and tabulate them.

    Parameters
    ----------
    done : NamedModes
        All sweeps.
    start : int
        Sweep identified first.
    """
    order = sorted(done.seen, key=lambda label: np.median([abs(s.pole) for s in done.seen[label]]))
    table = np.full((len(frf.temperature), len(order)), -1, dtype=np.int64)
    for t, labels in done.labels.items():
        for n, label in enumerate(labels):
            if label >= 0:
                table[t, order.index(int(label))] = n
    return TrackedModes(
        temperature=frf.temperature,
        direction=frf.direction,
        level=frf.level,
        level_unit=frf.level_unit(),
        channels=frf.channels,
        modes=tuple(done.modes[t] for t in range(len(frf.temperature))),
        track=table,
        start=start,
        notes=tuple(done.notes),
    )


POOR_MISFIT = 1.15
"""Misfit, over the expected one, above which a sweep is reported."""

FOREIGN_ERROR_RATIO = 5.0
"""Ratio of a sweep's normalised error to that of the median sweep, after a joint fit, above which it shares no
modes with the others and is identified by itself. Sweeps of one plate stay below 1.1."""


def sweep_measured(frf: Frf, sweep: int) -> Measured:
    """Usable lines of one sweep, with their variance."""
    used = ~frf.excluded
    return Measured(
        frf.frequency[used],
        frf.h[sweep][:, used],
        frf.variance[sweep][:, used],
        at_rest=frf.at_rest,
        together=True,
        shift=0.0 if frf.shift is None else float(frf.shift[sweep]),
    )


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

    Raises
    ------
    ValueError
        If a sweep's FRF is silent, or there is no sweep `start`.
    """
    settings = settings or Settings()
    if start is not None and not 0 <= start < len(frf.temperature):
        raise ValueError(f"start is sweep {start}; allowed 0 to {len(frf.temperature) - 1}")
    measured = [sweep_measured(frf, t) for t in range(len(frf.temperature))]
    if expected is not None:
        return _as_expected(frf, *fit_expected(frf.temperature, measured, expected, settings, progress))
    order = np.argsort(frf.temperature, kind="stable")
    if method is None:
        return _fitted_together(frf, measured, int(order[0]) if start is None else start, settings, progress)
    ends = {int(order[0]), int(order[-1])} if start is None else {start}
    start, first = best_start(measured, ends, settings, method)
    done = NamedModes()
    enter(done, start, frf.temperature[start], first, 1.0)
    for count, t in enumerate(outwards(frf.temperature, start), start=1):
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
    """Fit all sweeps jointly, but for those that share no modes with the others."""
    sweeps = np.arange(len(measured))
    modes, table, start, excess = find_tracks(frf.temperature, measured, start, settings, progress)
    excess = excess / np.median(excess)
    foreign = excess > FOREIGN_ERROR_RATIO
    if foreign.any():
        kept = sweeps[~foreign]
        first = int(np.abs(kept - start).argmin())
        some, rows, first, _ = find_tracks(
            frf.temperature[kept], [measured[t] for t in kept], first, settings, None
        )
        start, table = int(kept[first]), np.full((len(sweeps), rows.shape[1]), -1, dtype=np.int64)
        table[kept] = rows
        together = dict(zip(kept.tolist(), some, strict=True))
        modes = tuple(together.get(t) or identify(measured[t], settings) for t in sweeps.tolist())
    usual = [expected_misfit(one, modes[start]) for one in measured]
    rows_of_notes = zip(frf.temperature, sweeps.tolist(), modes, usual, excess.tolist(), strict=True)
    return TrackedModes(
        temperature=frf.temperature,
        direction=frf.direction,
        level=frf.level,
        level_unit=frf.level_unit(),
        channels=frf.channels,
        modes=modes,
        track=table,
        start=start,
        notes=tuple(filter(None, (_doubt(*row) for row in rows_of_notes))),
    )


def _doubt(temperature: float, sweep: int, modes: Modes, usual: float, excess: float) -> str | None:
    """Message about a sweep with a large residual, alone or fitted with the others, or None."""
    said = []
    if excess > FOREIGN_ERROR_RATIO:
        said.append(
            f"fitted with the other sweeps it leaves {excess:.2g} times its noise: it was identified by itself, "
            "and its modes are not followed over temperature (check its temperature, channels and mounting)"
        )
    if modes.misfit > POOR_MISFIT * usual:
        said.append(
            f"the model leaves {100 * modes.misfit:.2g} % of rms |h|, {modes.misfit / usual:.1f} times what was "
            "expected: its modes are not reliable"
        )
    return f"{temperature:.1f} °C (sweep {sweep}): " + "; ".join(said) if said else None


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
