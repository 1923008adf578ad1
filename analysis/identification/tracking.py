"""One identification followed over temperature.

A polymer's modulus moves all frequencies nearly together. So the poles of one sweep, times one common factor
found by a scan, are good start values at the next temperature; variable projection does the rest, and the
order is settled anew: modes are born and die. Each sweep starts from its nearest neighbour in temperature
that is done, outwards from the start in both directions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from analysis.frf import Frf
from analysis.identification.automatic import Settings, finish, identify, settle
from analysis.identification.averaging import averaged
from analysis.identification.common_factor import common_factor
from analysis.identification.expected_modes import ExpectedModes, fit_expected
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.pole_search import fit
from analysis.identification.tracked_modes import TrackedModes

LEAST_BASE = 0.5
"""Difference of temperature, K, below which two sweeps show no trend."""

POOR = 1.15
"""Misfit, in multiples of the one expected, above which a sweep is identified afresh, then reported."""

SAME_MODE = 1.5
"""Largest distance, in half widths, between a mode's predicted and found pole."""


@dataclass(frozen=True)
class _Sighting:
    """A mode as one sweep showed it: its pole over the sweep's common factor, and its residues."""

    temperature: float
    pole: complex
    shape: NDArray[np.complex128]


@dataclass
class _Progress:
    """What is known so far: sweeps done, the common factor of each, and where every mode was seen."""

    modes: dict[int, Modes] = field(default_factory=dict)
    labels: dict[int, NDArray[np.int64]] = field(default_factory=dict)
    factor: dict[int, float] = field(default_factory=dict)
    seen: dict[int, list[_Sighting]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def predict(self, label: int, temperature: float) -> _Sighting:
        """Where a mode should be: as the nearest sweep showed it, moved on along its own trend.

        The trend is what the mode did beside the common factor between the two nearest sweeps that showed it,
        and is believed for one and a half times their distance.
        """
        nearest, *others = sorted(self.seen[label], key=lambda s: abs(s.temperature - temperature))
        step = temperature - nearest.temperature
        for other in others:
            base = nearest.temperature - other.temperature
            if abs(base) > LEAST_BASE and abs(step) <= 1.5 * abs(base):
                trend = np.log(abs(nearest.pole) / abs(other.pole)) / base
                return _Sighting(temperature, nearest.pole * np.exp(trend * step), nearest.shape)
        return nearest


def sweep_measured(frf: Frf, sweep: int) -> Measured:
    """Lines of one sweep that may be fitted, with their variance."""
    used = ~frf.excluded
    return Measured(frf.frequency[used], frf.h[sweep][:, used], frf.variance[sweep][:, used])


Method = Callable[[Measured, Settings], Modes]


def track(
    frf: Frf,
    settings: Settings | None = None,
    progress: Callable[[str, float], None] | None = None,
    method: Method | None = None,
    expected: ExpectedModes | None = None,
) -> TrackedModes:
    """Identify every sweep of a campaign and follow its modes.

    Parameters
    ----------
    frf : Frf
        All sensors of a sweep share their poles.
    settings : Settings, optional
        Of the identification.
    progress : callable, optional
        Told the stage and the share done.
    method : callable, optional
        Identifies every sweep alone, with no warm start; modes are followed all the same.
    expected : ExpectedModes, optional
        What a twin expects in every sweep. Its modes are fitted in place of a search, and are the tracks.

    Returns
    -------
    TrackedModes

    Raises
    ------
    ValueError
        If a sweep's FRF is silent.
    """
    settings = settings or Settings()
    measured = [sweep_measured(frf, t) for t in range(len(frf.temperature))]
    if expected is not None:
        return _as_expected(frf, *fit_expected(frf.temperature, measured, expected, settings, progress))
    start, first = _start(frf.temperature, measured, settings, method or identify)
    done = _Progress()
    _enter(done, start, frf.temperature[start], first, 1.0)
    for count, t in enumerate(_outwards(frf.temperature, start), start=1):
        source = min(done.modes, key=lambda s: (abs(frf.temperature[s] - frf.temperature[t]), abs(s - t)))
        if method is None:
            _follow(done, measured[t], t, frf.temperature[t], source, settings)
        else:
            before = done.modes[source]
            shift, _ = common_factor(averaged(measured[t].lines()), before.poles, before.terms)
            modes = method(measured[t], settings)
            _enter(done, t, frf.temperature[t], modes, done.factor[source] * shift)
        if progress is not None:
            progress("identify", (count + 1) / len(measured))
    return _collect(done, frf, start)


def _as_expected(frf: Frf, modes: tuple[Modes, ...], table: NDArray[np.int64]) -> TrackedModes:
    """Tabulate the modes that a twin expected, those that are in band at some temperature."""
    return TrackedModes(
        temperature=frf.temperature,
        direction=frf.direction,
        level=frf.level,
        channels=frf.channels,
        modes=modes,
        track=table[:, (table >= 0).any(axis=0)],
        start=0,
    )


def _start(
    temperature: NDArray[np.float64], measured: Sequence[Measured], settings: Settings, method: Method
) -> tuple[int, Modes]:
    """Of the coldest and the hottest sweep the one that shows more modes: damping is least at the ends."""
    order = np.argsort(temperature, kind="stable")
    tried = {int(order[n]) for n in (0, -1)}
    found = {t: method(measured[t], settings) for t in sorted(tried)}
    best = max(found, key=lambda t: (found[t].status.count("kept"), -found[t].misfit))
    return best, found[best]


def _outwards(temperature: NDArray[np.float64], start: int) -> list[int]:
    """All other sweeps, nearest in temperature to the start first."""
    distance = np.abs(temperature - temperature[start])
    return [int(t) for t in np.argsort(distance, kind="stable") if t != start]


def _follow(
    done: _Progress, measured: Measured, t: int, temperature: float, source: int, settings: Settings
) -> None:
    """Identify sweep `t` from the poles of sweep `source`; start afresh where that fails."""
    lines, before = measured.lines(), done.modes[source]
    shift, found_end = common_factor(averaged(lines), before.poles, before.terms)
    factor = done.factor[source] * shift
    start = before.poles * shift
    for n, label in enumerate(done.labels[source]):
        if label >= 0:
            start[n] = factor * done.predict(int(label), temperature).pole
    shown = set(done.labels[source].tolist())
    dormant = [factor * done.predict(label, temperature).pole for label in done.seen if label not in shown]
    warm = fit(averaged(lines), start, before.terms, tolerance=1e-3)
    settled = settle(measured, lines, warm, settings, np.array(dormant, dtype=complex), rounds=1)
    modes = finish(measured, lines, settled, settings)
    ceiling = POOR * _expected(measured, before)
    if found_end or modes.misfit > ceiling:
        fresh = identify(measured, settings)
        modes = fresh if fresh.misfit < modes.misfit else modes
    if modes.misfit > ceiling:
        done.notes.append(
            f"{temperature:.1f} °C (sweep {t}): the model leaves {100 * modes.misfit:.2g} % of rms |h|, "
            f"{POOR * modes.misfit / ceiling:.1f} times what was expected: its modes are not to be relied on"
        )
    _enter(done, t, temperature, modes, factor)


def _expected(measured: Measured, before: Modes) -> float:
    """Misfit to be expected, as a share of rms |h|: the noise if it is known, the neighbour's misfit if not."""
    if measured.known and measured.variance is not None:
        return float(np.sqrt(measured.variance.sum() / (np.abs(measured.h) ** 2).sum()))
    return before.misfit


def _enter(done: _Progress, t: int, temperature: float, modes: Modes, factor: float) -> None:
    """Name the poles of a sweep: each gets the label of a known mode, a new one, or -1 for no mode."""
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
        sighting = _Sighting(temperature, modes.poles[n] / factor, modes.residues[:, n])
        done.seen.setdefault(int(labels[n]), []).append(sighting)
    done.modes[t], done.labels[t], done.factor[t] = modes, labels, factor


def _distance(known: _Sighting, modes: Modes, n: int, factor: float) -> float:
    """Distance of a pole from a mode's prediction in half widths, plus up to 1 for another shape or phase."""
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


def _collect(done: _Progress, frf: Frf, start: int) -> TrackedModes:
    """Order modes by their frequency, referred to the start's temperature, and tabulate them."""
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
        channels=frf.channels,
        modes=tuple(done.modes[t] for t in range(len(frf.temperature))),
        track=table,
        start=start,
        notes=tuple(done.notes),
    )
