"""Automatic identification of poles and residues: vector fitting, variable projection, model order by BIC.

The paper's recipe (section 4.2): pick peaks, fit each locally, then refine all poles over the wide band.

Provided to reproduce the paper. A mode without a peak of its own is not found, and in a lossy plate peaks merge:
about a tenth of R10's modes is missed, where `automatic` misses none.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.finishing import finish, judged, last_fit, settle
from analysis.identification.judgement.status import harmonic_lines, harmonic_of, needle_hum, tones
from analysis.identification.lines import Lines
from analysis.identification.measured import MANY, Measured, principal_frfs
from analysis.identification.missing import residual
from analysis.identification.modes import Modes, Rejected
from analysis.identification.order import bic, drop_unresolved, drop_unsupported, eliminate, pole_penalty
from analysis.identification.pole_residue import REAL_E, REAL_E_F, ResidualTerms
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.settings import Settings
from analysis.identification.vector_fitting import start_poles

CLEAR_BIC_ADVANTAGE = 10.0
"""Advantage in BIC, in penalties of one pole, from which a wider search replaces an unfinished narrower one."""

START_POLES_FACTOR = 2.5
"""Factor on the number of start poles from one search to the next."""

MOST_POLES_KEPT = 0.6
"""If more than this share of the start poles is kept, there may have been too few start poles."""

CORRELATION_OF_MISSING_MODES = 3.0
"""Correlation of a residual, in lines, from which modes may be missing: that of the noise of FRFs is 1 to 2."""

LACKING_CORRELATION_RATIO = 1.5
"""Ratio of residual correlations, narrower over wider search, from which the narrower one lacks modes."""


def identify(measured: Measured, settings: Settings | None = None) -> Modes:
    """Identify FRFs that share their poles.

    Over-specified vector fitting finds the poles roughly, variable projection moves them to the least-squares
    optimum, backward elimination by BIC removes unsupported poles, poles that the residual shows are added, BIC
    chooses the residual terms. The search runs on averaged lines, the last fit on all.

    Raises
    ------
    ValueError
        For FRFs that are silent, not finite, or shorter than 8 lines.
    """
    settings = settings or Settings()
    lines = measured.lines()
    if not (np.abs(lines.h) > 0.0).any(axis=1).all():
        raise ValueError("an FRF is zero on every line: nothing to identify")
    alone = tones(measured.h)
    left_out = measured.frequency[alone]
    if alone.any():
        measured = measured.without(alone)
        lines = measured.lines()
    several = measured if len(measured.h) <= MANY else principal_frfs(measured).measured
    found, started = _widest_search(several, several.lines(), settings)
    rejected = [_left_out(f, "a tone on this line alone: no resonance") for f in left_out]
    if settings.mains is not None:
        lines = several.lines()
        clean = fit(lines, found.poles[~_hums(lines, found, settings.mains)], found.terms, max_iterations=0)
        spoilt = harmonic_lines(lines.frequency, residual(lines, clean), lines.spacing, settings.mains)
        if spoilt.any():
            rejected += [_left_out(f, _hum(f, settings.mains, lines.spacing)) for f in lines.frequency[spoilt]]
            measured, several = measured.without(spoilt), several.without(spoilt)
            found = settle(several, several.lines(), clean, settings)
    lines = measured.lines()
    if several is not measured:
        found = fit(lines, found.poles, found.terms, max_iterations=0)
    weighed, last = last_fit(measured, lines, found)
    separate = drop_unresolved(weighed, last)  # on averaged lines they looked further apart
    if separate is not last:
        weighed, last = last_fit(measured, lines, separate)
    modes, _ = judged(weighed, last, settings)
    return replace(modes, rejected=(*_rejected(started, modes.poles), *rejected))


def _widest_search(measured: Measured, lines: Lines, settings: Settings) -> tuple[PoleFit, NDArray[np.complex128]]:
    """Search with more and more start poles, until far fewer are kept or BIC no longer falls.

    Wider searches are also made while the residual is correlated along frequency, as missing modes make it. A
    search is completed only if it is the widest, or if a wider one is not clearly better.
    """
    count = min(settings.start_count, max(len(lines.frequency) // 6, 1))
    found, started = _search(lines, count, settings)
    ended = False
    while START_POLES_FACTOR * count <= min(settings.most_count, len(lines.frequency) // 6):
        full = len(found.poles) > MOST_POLES_KEPT * count
        if not full and measured.reweighted(lines, found).correlation <= CORRELATION_OF_MISSING_MODES:
            break
        count = int(START_POLES_FACTOR * count)
        wider, proposed = _search(lines, count, settings)
        wider = settle(measured, lines, wider, settings)
        if not ended and not _better(measured, lines, wider, found, CLEAR_BIC_ADVANTAGE):
            found, ended = settle(measured, lines, found, settings), True
        if ended and not _better(measured, lines, wider, found, 0.0):
            break
        found, started, ended = wider, proposed, True
    return found if ended else settle(measured, lines, found, settings), started


def _better(measured: Measured, lines: Lines, wider: PoleFit, found: PoleFit, margin: float) -> bool:
    """Whether a wider search has a lower BIC than another, by a margin in penalties of one pole.

    With too many poles the noise is estimated too small and too little correlated, which favours them. So BIC has
    to be lower with the noise estimated from the other search too, unless missing modes dominate its residual.
    """
    own, others = (averaged(measured.reweighted(lines, judge)) for judge in (wider, found))
    for weighed in (own, others) if others.correlation < LACKING_CORRELATION_RATIO * own.correlation else (own,):
        one, other = (
            bic(fit(weighed, rival.poles, rival.terms, tolerance=1e-3, max_iterations=5), weighed)
            for rival in (wider, found)
        )
        if one + margin * pole_penalty(weighed) >= other:
            return False
    return True


def _left_out(f: float, why: str) -> Rejected:
    """Name a line, Hz, left out of the fit."""
    return Rejected(2j * np.pi * float(f), f"line left out: {why}", "harmonic")


def _hums(lines: Lines, found: PoleFit, mains: float) -> NDArray[np.bool_]:
    """Poles of a fit narrower than a line at a mains harmonic: (J,) ndarray of bool."""
    return np.array([needle_hum(p, mains, lines.spacing) is not None for p in found.poles], dtype=bool)


def _hum(f: float, mains: float, spacing: float) -> str:
    number, fundamental = harmonic_of(f, mains, spacing) or (1, mains)
    return f"{number} x {fundamental:g} Hz mains"


def _search(lines: Lines, count: int, settings: Settings) -> tuple[PoleFit, NDArray[np.complex128]]:
    """Find the order on averaged lines, from `count` start poles; also return the start poles."""
    richest = max(settings.terms, key=lambda terms: terms.parameters)
    blocks = averaged(lines)
    started = start_poles(blocks, min(count, max(len(blocks.frequency) // 4, 1)), richest)
    found = fit(blocks, started, richest, max_iterations=0)
    return eliminate(blocks, drop_unsupported(blocks, found, share=-0.5)), started


def _rejected(started: NDArray[np.complex128], stayed: NDArray[np.complex128]) -> tuple[Rejected, ...]:
    """Start poles with no final pole within their width."""
    free = list(range(len(stayed)))
    rejected = []
    for pole in sorted(started, key=lambda p: -p.real):
        near = [j for j in free if abs(stayed[j] - pole) < max(-pole.real, -stayed[j].real)]
        if near:
            free.remove(min(near, key=lambda j: abs(stayed[j] - pole)))
        else:
            rejected.append(Rejected(complex(pole), "vector fitting proposed it; BIC falls without it"))
    return tuple(sorted(rejected, key=lambda r: r.pole.imag))


def refine(measured: Measured, start: Modes, settings: Settings | None = None) -> Modes:
    """Fit again from the poles and residual terms of `start`, with no search for the order: a warm start."""
    settings = settings or Settings()
    lines = measured.lines()
    blocks = averaged(lines)
    found = fit(blocks, start.poles, start.terms, tolerance=1e-5)
    return replace(finish(measured, lines, found, settings)[0], rejected=start.rejected)


LEAST_PROMINENCE = 10.0
"""Smallest prominence of a peak, in standard deviations of the noise."""


def identify_by_peaks(
    measured: Measured, settings: Settings | None = None, terms: ResidualTerms = REAL_E_F
) -> Modes:
    """Identify FRFs that share their poles by their peaks.

    Parameters
    ----------
    measured : Measured
        One drive, K responses.
    settings : Settings, optional
        Only the mains frequency is used.
    terms : ResidualTerms
        The paper's E + F/s^2 by default.

    Raises
    ------
    ValueError
        If no peak stands out of the noise.
    """
    lines = measured.lines()
    start = [local_pole(lines, place, width) for place, width in peaks(lines)]
    if not start:
        raise ValueError(
            f"no peak stands {LEAST_PROMINENCE:g} standard deviations out of the noise: nothing to pick"
        )
    found = fit(lines, np.array(start), terms, tolerance=1e-6, max_iterations=100)
    return finish(measured, lines, found, settings or Settings())[0]


def peaks(lines: Lines) -> list[tuple[int, float]]:
    """Find peaks: the index of each one's line, and its half-power width in lines.

    Amplitudes in standard deviations of the band's noise, all responses together.
    """
    from scipy.signal import find_peaks, peak_widths

    noise = np.median(lines.deviation, axis=1, keepdims=True)  # scatter over lines would add peaks
    height: NDArray[np.float64] = np.sqrt((np.abs(lines.h / noise) ** 2).mean(axis=0))
    places, _ = find_peaks(height, prominence=LEAST_PROMINENCE)
    widths = peak_widths(height, places, rel_height=1.0 - np.sqrt(0.5))[0]
    return [(int(place), float(width)) for place, width in zip(places, widths, strict=True)]


def local_pole(lines: Lines, place: int, width: float) -> complex:
    """Pole of one peak, fitted alone with a constant over one half-power width to either side.

    Parameters
    ----------
    place : int
        Line of the peak.
    width : float
        Half-power width, in lines.

    Returns
    -------
    complex
        rad/s; the half-power estimate itself where the fit leaves that window.
    """
    f = lines.frequency[place]
    half = 0.5 * max(width, 1.0) * float(lines.spacing_at(f))
    guess = 2.0 * np.pi * complex(-half, f)
    reach = max(int(np.ceil(width)), 4)
    window = slice(max(place - reach, 0), place + reach + 1)
    if window.stop - window.start < 8 or len(lines.frequency[window]) < 8:
        return guess
    near = Lines(lines.frequency[window], lines.h[:, window], lines.deviation[:, window], as_measured=lines.grid)
    pole = complex(fit(near, np.array([guess]), REAL_E, tolerance=1e-6).poles[0])
    inside = near.frequency[0] <= pole.imag / (2.0 * np.pi) <= near.frequency[-1]
    return pole if inside and -pole.real < 8.0 * np.pi * half else guess
