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
from analysis.identification.automatic import Measured, Settings, finish, identify, settle
from analysis.identification.averaging import averaged
from analysis.identification.lines import Lines
from analysis.identification.modes import Modes
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.tracked_modes import TrackedModes
from analysis.identification.variable_projection import fit, misfit_at

WIDEST_STEP = 0.12
"""Largest shift of log frequency from one sweep to the next that the scan looks for at first."""

POOR = 1.15
"""Misfit, in multiples of the one expected, above which a sweep is identified afresh, then reported."""

SAME_MODE = 1.5
"""Largest distance, in half widths, between a mode's predicted and found pole."""


@dataclass
class _Progress:
    """What is known so far: sweeps done, the common factor of each, and where every mode was last seen."""

    modes: dict[int, Modes] = field(default_factory=dict)
    labels: dict[int, NDArray[np.int64]] = field(default_factory=dict)
    factor: dict[int, float] = field(default_factory=dict)
    last: dict[int, tuple[complex, NDArray[np.complex128]]] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


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

    Raises
    ------
    ValueError
        If a sweep's FRF is silent.
    """
    settings = settings or Settings()
    measured = [sweep_measured(frf, t) for t in range(len(frf.temperature))]
    start, first = _start(frf.temperature, measured, settings, method or identify)
    done = _Progress()
    _enter(done, start, first, 1.0)
    for count, t in enumerate(_outwards(frf.temperature, start), start=1):
        source = min(done.modes, key=lambda s: (abs(frf.temperature[s] - frf.temperature[t]), abs(s - t)))
        if method is None:
            _follow(done, measured[t], t, source, settings, f"{frf.temperature[t]:.1f} °C (sweep {t})")
        else:
            before = done.modes[source]
            shift, _ = common_factor(averaged(measured[t].lines()), before.poles, before.terms)
            _enter(done, t, method(measured[t], settings), done.factor[source] * shift)
        if progress is not None:
            progress("identify", (count + 1) / len(measured))
    return _collect(done, frf, start)


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


def _follow(done: _Progress, measured: Measured, t: int, source: int, settings: Settings, name: str) -> None:
    """Identify sweep `t` from the poles of sweep `source`; start afresh where that fails."""
    lines, before = measured.lines(), done.modes[source]
    shift, found_end = common_factor(averaged(lines), before.poles, before.terms)
    factor = done.factor[source] * shift
    shown = set(done.labels[source].tolist())
    dormant = [pole * factor for label, (pole, _) in done.last.items() if label not in shown]
    warm = fit(averaged(lines), before.poles * shift, before.terms, tolerance=1e-3)
    settled = settle(measured, lines, warm, settings, np.array(dormant, dtype=complex))
    modes = finish(measured, lines, settled, settings)
    ceiling = POOR * _expected(measured, before)
    if found_end or modes.misfit > ceiling:
        fresh = identify(measured, settings)
        modes = fresh if fresh.misfit < modes.misfit else modes
    if modes.misfit > ceiling:
        times = POOR * modes.misfit / ceiling
        done.notes.append(
            f"{name}: the model leaves {100 * modes.misfit:.2g} % of rms |h|, {times:.1f} times what was "
            "expected: its modes are not to be relied on"
        )
    _enter(done, t, modes, factor)


def _expected(measured: Measured, before: Modes) -> float:
    """Misfit to be expected, as a share of rms |h|: the noise if it is known, the neighbour's misfit if not."""
    if measured.known and measured.variance is not None:
        return float(np.sqrt(measured.variance.sum() / (np.abs(measured.h) ** 2).sum()))
    return before.misfit


def common_factor(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> tuple[float, bool]:
    """Find the factor that moves all poles to where they explain FRFs best, and whether that is the scan's edge.

    A scan in steps of half the median half width, no coarser than 0.5 %, then a parabola through the lowest
    three; three times as wide where the lowest is the last.
    """
    zeta = float(np.median(-poles.real / np.abs(poles))) if len(poles) else 0.01
    step = min(max(0.5 * zeta, 1e-3), 5e-3)
    for widest in (WIDEST_STEP, 3.0 * WIDEST_STEP):
        grid = np.arange(-widest, widest + step, step)
        misfit = np.array([misfit_at(lines, poles * np.exp(g), terms) for g in grid])
        lowest = int(np.argmin(misfit))
        if 0 < lowest < len(grid) - 1:
            left, middle, right = misfit[lowest - 1 : lowest + 2]
            bend = left - 2.0 * middle + right
            offset = 0.5 * (left - right) / bend if bend > 0.0 else 0.0
            return float(np.exp(grid[lowest] + step * offset)), False
    return float(np.exp(grid[lowest])), True


def _enter(done: _Progress, t: int, modes: Modes, factor: float) -> None:
    """Name the poles of a sweep: each gets the label of a known mode, a new one, or -1 for no mode."""
    labels = np.full(len(modes.poles), -1, dtype=np.int64)
    known = list(done.last)
    candidates = [int(n) for n in np.flatnonzero(modes.real)]
    cost = np.array(
        [[_distance(done.last[label], modes, n, factor) for n in candidates] for label in known]
    ).reshape(len(known), len(candidates))
    for row, column in zip(*linear_sum_assignment(np.minimum(cost, 100.0)), strict=True):
        if cost[row, column] < SAME_MODE + 1.0:
            labels[candidates[column]] = known[row]
    for n in candidates:
        if labels[n] < 0:
            labels[n] = max(done.last, default=-1) + 1
        done.last[int(labels[n])] = (modes.poles[n] / factor, modes.residues[:, n])
    done.modes[t], done.labels[t], done.factor[t] = modes, labels, factor


def _distance(known: tuple[complex, NDArray[np.complex128]], modes: Modes, n: int, factor: float) -> float:
    """Distance of a pole from a mode's prediction in half widths, plus up to 1 for another shape or phase."""
    predicted, shape = known[0] * factor, known[1]
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
    order = sorted(done.last, key=lambda label: abs(done.last[label][0]))
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
