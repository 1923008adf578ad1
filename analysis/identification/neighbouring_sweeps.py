"""Confirmation of a campaign's modes by its other sweeps."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.confirmation import same_mode, weighed
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.order import ROUGH_FALL_OF_MISFIT, attempt, bic, misfit_worth, support
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.resolution import COINCIDENT_DISTANCE
from analysis.identification.tracked_modes import TrackedModes

SAME_MODE_SIGMA = 2.0
"""Distance of two modes, in standard deviations of one's frequency, up to which they may be one."""


def confirmed_by_neighbours(tracked: TrackedModes, measured: Sequence[Measured]) -> TrackedModes:
    """Confirm the modes of a campaign by its other sweeps, which are independent measurements.

    Sweeps fitted jointly, or with a twin, contain modes that only other sweeps show. So a sweep shows a mode only
    if BIC of its own lines supports it.

    Parameters
    ----------
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
    """Modes (J,) that a sweep's own lines support: BIC with all others held, and both tests below."""
    held = fit(blocks, modes.poles, modes.terms, max_iterations=0)
    paid: NDArray[np.bool_] = modes.real & (support(held, blocks) > 0.0)
    free, moved = _free(blocks, modes, held)
    return _without_doubles(blocks, modes, free, paid & ~moved)


def _free(blocks: Lines, modes: Modes, held: PoleFit) -> tuple[PoleFit, NDArray[np.bool_]]:
    """Fit of a sweep alone, and which modes (J,) its lines put elsewhere.

    A pole held on its track may stand for what the model lacks: a mode out of band, the movement of a peak while
    it is measured. A fit of the sweep alone then moves it to where it explains that best. Noise moves poles, too:
    n log(misfit) falls by one, on average, for each of the 2J numbers of the poles. The fit counts only from twice
    that fall on, as in Akaike's information criterion, and is not made where derivatives promise less.
    """
    count = len(modes.poles)
    target = misfit_worth(blocks, bic(held, blocks) - 2.0 * (2 * count), count, modes.terms)
    free = fit(blocks, modes.poles, modes.terms, tolerance=ROUGH_FALL_OF_MISFIT, target=target)
    if free.projection.misfit > target:
        return held, np.zeros(count, dtype=bool)
    free = fit(blocks, free.poles, modes.terms, tolerance=ROUGH_FALL_OF_MISFIT)
    pairs = zip(modes.poles.tolist(), free.poles.tolist(), strict=True)
    return free, np.array([not same_mode(one, other) for one, other in pairs], dtype=bool)


def _without_doubles(blocks: Lines, modes: Modes, free: PoleFit, paid: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Modes of `paid` (J,) less those whose peak one pole less describes as well.

    With all others held, each of two poles at one peak seems indispensable. If the frequency of one is not known
    to differ from that of the other, it is supported only if BIC rises without it after a refit.
    """
    place, sigma = np.log(np.abs(modes.poles)), np.sqrt(modes.covariance[:, 0, 0])
    half_width = -modes.poles.real / np.abs(modes.poles)
    apart = np.abs(place[:, None] - place) + np.where(np.eye(len(place), dtype=bool), np.inf, 0.0)
    double = paid & (apart < np.minimum(SAME_MODE_SIGMA * sigma, COINCIDENT_DISTANCE * half_width)[:, None]).any(
        axis=1
    )
    if not double.any():
        return paid
    paid = paid.copy()
    best, left = (
        fit(blocks, free.poles, modes.terms, tolerance=ROUGH_FALL_OF_MISFIT, max_iterations=3),
        np.arange(len(place)),
    )
    for j in sorted(np.flatnonzero(double), key=lambda j: -sigma[j] / half_width[j]):
        others = left[left != j]
        if not (apart[j, others] < COINCIDENT_DISTANCE * half_width[j]).any():
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
