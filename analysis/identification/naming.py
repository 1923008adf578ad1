"""Matching of modes between sweeps that were identified one by one.

A pole belongs to the nearest predicted mode. The prediction uses the common step of all modes and the mode's own
trend; the distance includes the shape, or the residue's phase where there is one sensor.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.frf import Frf
from analysis.identification.modes import Modes
from analysis.identification.tracked_modes import TrackedModes

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
    modes : Modes
    factor : float
        Common factor of its frequencies, relative to the first sweep's.

    Returns
    -------
    None
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
    frf : Frf
    start : int
        Sweep identified first.

    Returns
    -------
    TrackedModes
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
