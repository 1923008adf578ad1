"""Confirmation of a campaign's modes by its other sweeps."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.bic import bic, support
from analysis.identification.confirmation import weighed
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.order import ROUGH, attempt
from analysis.identification.pole_search import fit
from analysis.identification.resolution import COINCIDENT
from analysis.identification.tracked_modes import TrackedModes

UNSURE = 2.0
"""Distance of two modes, in standard deviations of one's frequency, up to which they may be one."""


def confirmed_by_neighbours(tracked: TrackedModes, measured: Sequence[Measured]) -> TrackedModes:
    """Confirm the modes of a campaign by its other sweeps, which are independent measurements.

    Sweeps fitted jointly, or with a twin, contain modes that only other sweeps show. So a sweep shows a mode only
    if BIC of its own lines supports it.

    Parameters
    ----------
    tracked : TrackedModes
    measured : sequence of Measured
        The sweeps that they were identified from.

    Returns
    -------
    TrackedModes
        A mode is confirmed where its sweep and the next colder or the next hotter one of the same level and
        direction show it; where a sweep has no such neighbour, `confirmation` is left as it is.

    Raises
    ------
    ValueError
        If fewer than 8 lines of a sweep are left.
    """
    runs: dict[tuple[str, float], list[int]] = {}
    for t in np.argsort(tracked.temperature, kind="stable").tolist():
        runs.setdefault((tracked.direction[t], float(tracked.level[t])), []).append(t)
    shown = _shown(tracked, measured)
    modes = list(tracked.modes)
    for run in runs.values():
        for place, t in enumerate(run):
            beside = [run[n] for n in (place - 1, place + 1) if 0 <= n < len(run)]
            if beside:
                modes[t] = _beside(tracked, shown, t, beside)
    return replace(tracked, modes=tuple(modes))


def _shown(tracked: TrackedModes, measured: Sequence[Measured]) -> NDArray[np.bool_]:
    """Whether BIC of each sweep's own lines supports each mode: (T, J) ndarray."""
    shown = np.zeros(tracked.track.shape, dtype=bool)
    for t, (modes, own) in enumerate(zip(tracked.modes, measured, strict=True)):
        paid = _paid(averaged(weighed(own, modes)), modes)
        there = tracked.track[t] >= 0
        shown[t, there] = paid[tracked.track[t, there]]
    return shown


def _paid(blocks: Lines, modes: Modes) -> NDArray[np.bool_]:
    """Modes (J,) that BIC of a sweep's own lines supports.

    With all others held, each of two poles at one peak seems indispensable. If the frequency of one is not known
    to differ from that of the other, it is supported only if BIC rises without it after a refit.
    """
    gain = support(fit(blocks, modes.poles, modes.terms, max_iterations=0), blocks)
    paid: NDArray[np.bool_] = modes.real & (gain > 0.0)
    place, sigma = np.log(np.abs(modes.poles)), np.sqrt(modes.covariance[:, 0, 0])
    half_width = -modes.poles.real / np.abs(modes.poles)
    apart = np.abs(place[:, None] - place) + np.where(np.eye(len(place), dtype=bool), np.inf, 0.0)
    double = paid & (apart < np.minimum(UNSURE * sigma, COINCIDENT * half_width)[:, None]).any(axis=1)
    if not double.any():
        return paid
    best, left = fit(blocks, modes.poles, modes.terms, tolerance=ROUGH, max_iterations=3), np.arange(len(place))
    for j in sorted(np.flatnonzero(double), key=lambda j: -sigma[j] / half_width[j]):
        others = left[left != j]
        if not (apart[j, others] < COINCIDENT * half_width[j]).any():
            continue  # the other one is gone
        without = attempt(blocks, best.poles[left != j], best.terms, bic(best, blocks))
        if without is not None:
            paid[j], best, left = False, without, others
    return paid


def _beside(tracked: TrackedModes, shown: NDArray[np.bool_], t: int, beside: list[int]) -> Modes:
    """Confirm the modes of one sweep that both it and a neighbouring sweep show."""
    modes = tracked.modes[t]
    names = " nor at ".join(f"{tracked.temperature[n]:.1f} °C" for n in beside)
    lacking = dict.fromkeys(range(len(modes.poles)), f"not found at {names}")
    for j in np.flatnonzero(tracked.track[t] >= 0):
        if not shown[t, j]:
            lacking[int(tracked.track[t, j])] = "the lines of this sweep alone do not pay for it"
        elif shown[beside, j].any():
            del lacking[int(tracked.track[t, j])]
    return replace(
        modes,
        confirmation=tuple(
            ("unconfirmed" if n in lacking else "confirmed") if real else "" for n, real in enumerate(modes.real)
        ),
        reason=tuple(
            f"{why}; {lacking[n]}" if n in lacking and modes.real[n] else why for n, why in enumerate(modes.reason)
        ),
    )
