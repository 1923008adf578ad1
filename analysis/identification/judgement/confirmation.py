"""Confirmation of modes: found again with other bands, lines or channels, in other sweeps, without single hits.

BIC judges a pole on one set of data. It does not notice that a pole compensates a model error near a band edge, or
that channels measured on different states of a structure are in one fit. Such poles move or vanish when the data
are changed a little, modes do not. All refits start from the poles found and run on averaged lines, so that they
cost a fraction of the search.

What a mode explains of averaged FRFs grows with the power of the hits that show it. Without hit i, of power
|F_i|^2, the share 1 - |F_i|^2 / sum |F|^2 of it is left, for any mode of the structure. A pole that one hit alone
shows, because a cable struck the plate or the hammer touched twice, keeps next to nothing; BIC, which sees the
average only, cannot tell.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.judgement.resolution import COINCIDENT_DISTANCE
from analysis.identification.lines import Lines
from analysis.identification.measured import MANY, Measured, principal_frfs
from analysis.identification.modes import DampingPrior, Modes
from analysis.identification.order import (
    ROUGH_FALL_OF_MISFIT,
    attempt,
    bic,
    eliminate,
    misfit_worth,
    pole_penalty,
    support,
)
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.identification.pole_search import PoleFit, fit, project

SHIFT_OF_BAND = 0.05
"""Share of the band that is cut off at its lower, then at its upper end."""
SAME_FREQUENCY = 1.0
"""Largest distance of the same pole in two fits, in half widths (half the half-power bandwidth)."""
SAME_DAMPING = 0.5
"""The same for the damping ratio, relative."""
LINES_OF_PEAK = 3
"""Lines within the half-power bandwidth needed to show a mode when every other line is left out."""
FEWEST_LINES_IN_PART = 16
"""Smallest number of averaged lines in a part."""


@dataclass(frozen=True)
class PartOfData:
    """Part of the lines and channels, its description, and the lines within a peak needed to show a mode."""

    description: str
    lines: Lines
    least_lines: int = 0


def confirmed(measured: Measured, modes: Modes) -> Modes:
    """Refit parts of the data, starting from the poles found, and report which modes are found again.

    Parameters
    ----------
    measured : Measured
        FRFs that the modes were identified from.

    Returns
    -------
    Modes
        The same, with `confirmation`, and with the reason for it in `reason`.

    Raises
    ------
    ValueError
        If fewer than 8 lines are left.
    """
    lost: list[list[str]] = [[] for _ in modes.poles]
    tried = np.zeros(len(modes.poles), dtype=int)
    for part in _parts(measured, modes):
        expected = modes.real & _expected(part, modes)
        tried += expected
        found = _found_again(part.lines, modes)
        for j in np.flatnonzero(expected & ~found):
            lost[j].append(part.description)
    words = [
        ""
        if not real
        else f"; not found again {' nor '.join(gone)}"
        if gone
        else f"; found again in {count} of {count} refits"
        if count
        else "; no part of the data supports it alone"
        for real, gone, count in zip(modes.real, lost, tried, strict=True)
    ]
    verdicts = tuple(
        ("confirmed" if count and not gone else "unconfirmed") if real else ""
        for real, gone, count in zip(modes.real, lost, tried, strict=True)
    )
    reasons = tuple(why + word for why, word in zip(modes.reason, words, strict=True))
    return replace(modes, confirmation=verdicts, reason=reasons)


def weighed(measured: Measured, modes: Modes) -> Lines:
    """Return all lines used in the fit, weighted by the residual of the modes."""
    kept = measured.without(modes.left_out(measured.frequency))
    return kept.weighed(kept.h - modes.synthesis(kept.frequency), modes.poles)


def averaged_lines(measured: Measured, modes: Modes) -> Lines:
    """Average lines of the FRFs, or of their principal FRFs where they are many, weighted as in the fit.

    Parameters
    ----------
    measured : Measured
    modes : Modes
        Identified from them: their residual tells the weights.

    Returns
    -------
    Lines
    """
    if len(measured.h) > MANY:
        sums = principal_frfs(measured)
        measured, modes = sums.measured, sums.modes(modes)
    lines = weighed(measured, modes)
    prior = DampingPrior.estimated(modes.poles, np.sqrt(modes.covariance[:, 1, 1]), lines.band)
    return averaged(replace(lines, damping=prior))


def _parts(measured: Measured, modes: Modes) -> Iterator[PartOfData]:
    """Yield the band cut at either end, every second line, and every second FRF."""
    blocks = averaged_lines(measured, modes)
    f = blocks.frequency
    cut = SHIFT_OF_BAND * (f[-1] - f[0])
    low, high = f[0] + cut, f[-1] - cut
    yield from _part(blocks, f >= low, None, f"above {low:.4g} Hz")
    yield from _part(blocks, f <= high, None, f"below {high:.4g} Hz")
    place = np.arange(len(f))
    for half, which in enumerate(("first", "second")):
        description = f"on the {which} half of the lines, every other one"
        for part in _part(blocks, place % 2 == half, None, description):
            yield replace(part, least_lines=LINES_OF_PEAK)
    if len(measured.h) > 1:
        row = np.arange(len(measured.h))
        for half, which in enumerate(("first", "second")):
            rows, description = row % 2 == half, f"in the {which} half of the FRFs, every other one"
            if len(measured.h) > MANY:
                yield from _part(averaged_lines(measured.rows(rows), modes.of_rows(rows)), None, None, description)
            else:
                yield from _part(blocks, None, rows, description)


def _part(
    blocks: Lines, columns: NDArray[np.bool_] | None, rows: NDArray[np.bool_] | None, description: str
) -> Iterator[PartOfData]:
    """Yield these lines and rows, unless they are too few to be fitted."""
    columns = np.ones(len(blocks.frequency), bool) if columns is None else columns
    rows = np.ones(len(blocks.h), bool) if rows is None else rows
    if columns.sum() < FEWEST_LINES_IN_PART:
        return
    share = columns.mean() * rows.mean()
    lines = replace(
        blocks,
        frequency=blocks.frequency[columns],
        h=blocks.h[rows][:, columns],
        deviation=blocks.deviation[rows][:, columns],
        hidden=round(blocks.hidden * share),
        as_measured=blocks.grid,
    )
    yield PartOfData(description, lines)


def _expected(part: PartOfData, modes: Modes) -> NDArray[np.bool_]:
    """Modes that a part has to show, (J,): the peak is in it and BIC supports the mode by twice its penalty."""
    lines, place, half = part.lines, modes.poles.imag / (2.0 * np.pi), -modes.poles.real / (2.0 * np.pi)
    inside = (place - half > lines.frequency[0]) & (place + half < lines.frequency[-1])
    seen = (np.abs(lines.frequency - place[:, None]) <= half[:, None]).sum(axis=1) >= part.least_lines
    here = fit(lines, modes.poles, modes.terms, max_iterations=0)
    paid: NDArray[np.bool_] = inside & seen & (support(here, lines) > pole_penalty(lines))
    return paid


def _found_again(lines: Lines, modes: Modes) -> NDArray[np.bool_]:
    """Modes found again at the same place when part of the data is refitted with its own model order, (J,)."""
    start = fit(lines, modes.poles, modes.terms, tolerance=1e-3, max_iterations=10)
    poles = eliminate(lines, start).poles
    found = np.zeros(len(modes.poles), dtype=bool)
    free = list(range(len(poles)))
    for j in np.flatnonzero(modes.real):
        pole = modes.poles[j]
        near = [n for n in free if same_mode(pole, poles[n])]
        if near:
            found[j] = True
            free.remove(min(near, key=lambda n: abs(poles[n] - pole)))
    return found


def same_mode(one: complex, other: complex) -> bool:
    """Whether two poles, rad/s, differ by no more than `SAME_FREQUENCY` and `SAME_DAMPING` of the first."""
    zeta = -one.real / abs(one), -other.real / abs(other)
    close = abs(one.imag - other.imag) <= SAME_FREQUENCY * -one.real
    return close and abs(zeta[1] / zeta[0] - 1.0) <= SAME_DAMPING


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


FEWEST_HITS = 3
"""Hits from which one may be left out: of two hits nobody knows which is right."""
RESTING_SHARE = 0.35
"""Share of the expected below which a mode rests on the hit left out. In 40 simulated tests of five hits, 200
strong modes that all show kept 1.06 and more, 37 weak ones (BIC 50 to 300) 0.97 and more; one that a single hit
shows keeps 0.004 at most."""


@dataclass(frozen=True)
class WithoutHit:
    """FRFs of a test without one hit.

    Attributes
    ----------
    name : str
        Of the hit left out: ``hit 3``.
    h : (L, F) complex ndarray
        Like those of all hits.
    share : float
        Of the drives' power that is left, 0 to 1.
    """

    name: str
    h: NDArray[np.complex128] = field(repr=False)
    share: float


def confirmed_by_hits(measured: Measured, without: Sequence[WithoutHit], modes: Modes) -> Modes:
    """Say which modes rest on one hit alone; they are unconfirmed.

    Parameters
    ----------
    measured : Measured
        FRFs of all hits, from which the modes were identified.
    without : sequence of WithoutHit
    modes : Modes

    Returns
    -------
    Modes
    """
    if len(without) < FEWEST_HITS or not modes.real.any():
        return modes
    left = left_without(measured, without, modes)
    worst = left.argmin(axis=0)
    rests = modes.real & (left.min(axis=0) < RESTING_SHARE)
    if not rests.any():
        return modes
    words = [
        f"; rests on {without[n].name} alone: without it {100 * max(share, 0.0):.0f} % of what is expected is left"
        if alone
        else ""
        for n, share, alone in zip(worst, left.min(axis=0), rests, strict=True)
    ]
    before = modes.confirmation or tuple("confirmed" if real else "" for real in modes.real)
    return replace(
        modes,
        confirmation=tuple("unconfirmed" if alone else one for one, alone in zip(before, rests, strict=True)),
        reason=tuple(why + word for why, word in zip(modes.reason, words, strict=True)),
    )


def left_without(measured: Measured, without: Sequence[WithoutHit], modes: Modes) -> NDArray[np.float64]:
    """Return what is left of each mode without each hit, as a share of what is expected, (H, J).

    Parameters
    ----------
    measured : Measured
        FRFs of all hits.
    without : sequence of WithoutHit
        H of them.
    modes : Modes
        J of them.

    Returns
    -------
    (H, J) ndarray
    """
    every = np.maximum(_explained(measured, modes), np.finfo(float).tiny)
    return np.array([_explained(replace(measured, h=one.h), modes) / every / one.share for one in without])


def _explained(measured: Measured, modes: Modes) -> NDArray[np.float64]:
    """Minus twice the logarithm of the likelihood that each pole saves, (J,), where the poles are.

    Residues are fitted anew: with those of all hits, what a false pole lacks here would be taken for noise.
    """
    lines = measured.without(modes.left_out(measured.frequency)).lines()
    here = project(lines, modes.poles, modes.terms, derivatives=False)
    fitted = replace(modes, residues=here.residues, coefficients=here.coefficients)
    blocks = averaged_lines(measured, fitted)
    return support(fit(blocks, modes.poles, modes.terms, max_iterations=0), blocks) + pole_penalty(blocks)
