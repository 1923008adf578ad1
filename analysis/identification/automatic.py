"""Poles and residues of FRFs without a human: vector fitting, variable projection, order by BIC."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.harmonics import harmonic_lines, harmonic_of, needle_hum, tones
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.missing import add_missing, residual
from analysis.identification.modes import Modes, Rejected
from analysis.identification.order import bic, choose_terms, covariance, drop_unsupported, eliminate, pole_price
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.residual_terms import CHOICES, ResidualTerms
from analysis.identification.status import judge
from analysis.identification.vector_fitting import start_poles

CLEARLY = 10.0
"""Prices of a pole by which a wider search must be better for the narrower one to be left unfinished."""

EXACT = 2e-2
"""Fall of the misfit, in units of one line's, at which a fit stops: a seventh of the weakest pole's deviation."""

LAST_STEPS = 10
"""Projections on all lines at most: averaged lines have brought all but the weakest poles to rest already."""

MOST_SETTLINGS = 4
"""Orders tried at most from nothing; a neighbour's order is settled once."""

FULL = 0.6
"""Share of the start poles that stay from which there may have been too few."""

MORE_CORRELATED = 1.1
"""Growth of the lines' correlation from which the order is settled again."""


@dataclass(frozen=True)
class Settings:
    """How FRFs are identified.

    Attributes
    ----------
    start_count : int
        Pole pairs vector fitting starts with; doubled while more than `FULL` of them stay.
    most_count : int
        Where doubling ends.
    terms : tuple of ResidualTerms
        BIC chooses among these.
    mains : float or None
        Mains frequency, Hz; narrow poles at its harmonics are flagged.
    """

    start_count: int = 24
    most_count: int = 96
    terms: tuple[ResidualTerms, ...] = CHOICES
    mains: float | None = 50.0

    def __post_init__(self) -> None:
        if not 1 <= self.start_count <= self.most_count <= 500:
            raise ValueError(
                f"start_count {self.start_count} and most_count {self.most_count}: 1 to 500, in this order, wanted"
            )
        if not self.terms:
            raise ValueError("terms: at least one choice of residual terms is needed")
        if self.mains is not None and not 1.0 <= self.mains <= 1000.0:
            raise ValueError(f"mains {self.mains:g} Hz: 1 to 1000 allowed, or none")


def identify(measured: Measured, settings: Settings | None = None) -> Modes:
    """Identify FRFs that share their poles.

    Over-specified vector fitting finds the poles roughly, variable projection moves them to the least-squares
    optimum, elimination by BIC takes away what the data do not pay for, a look at the residual brings back
    what was lost, BIC chooses the residual terms. The search runs on averaged lines, the last fit on all.

    Raises ValueError for FRFs that are silent, not finite, or shorter than 8 lines.
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
    found, started = _widest_search(measured, lines, settings)
    rejected = [_left_out(f, "a tone on this line alone: no resonance") for f in left_out]
    if settings.mains is not None:
        clean = fit(lines, found.poles[~_hums(lines, found, settings.mains)], found.terms, max_iterations=0)
        spoilt = harmonic_lines(lines.frequency, residual(lines, clean), lines.spacing, settings.mains)
        if spoilt.any():
            rejected += [_left_out(f, _hum(f, settings.mains, lines.spacing)) for f in lines.frequency[spoilt]]
            measured = measured.without(spoilt)
            lines = measured.lines()
            found = settle(measured, lines, clean, settings)
    modes = finish(measured, lines, found, settings)
    return replace(modes, rejected=(*_rejected(started, modes.poles), *rejected))


def _widest_search(measured: Measured, lines: Lines, settings: Settings) -> tuple[PoleFit, NDArray[np.complex128]]:
    """Search from more and more start poles, until far fewer stay or BIC gains nothing.

    A search is brought to its end only where it is the widest, or a wider one is not clearly better.
    """
    count = min(settings.start_count, max(len(lines.frequency) // 6, 1))
    found, started = _search(lines, count, settings)
    ended = False
    while len(found.poles) > FULL * count and 2 * count <= min(settings.most_count, len(lines.frequency) // 6):
        count *= 2
        wider, proposed = _search(lines, count, settings)
        wider = settle(measured, lines, wider, settings)
        if not ended and not _better(measured, lines, wider, found, CLEARLY):
            found, ended = settle(measured, lines, found, settings), True
        if ended and not _better(measured, lines, wider, found, 0.0):
            break
        found, started, ended = wider, proposed, True
    return found if ended else settle(measured, lines, found, settings), started


def _better(measured: Measured, lines: Lines, wider: PoleFit, found: PoleFit, margin: float) -> bool:
    """Whether the BIC of a wider search is lower than another's, by a margin in prices of a pole."""
    weighed = measured.reweighted(lines, wider)
    rival = fit(weighed, found.poles, found.terms, tolerance=1e-3, max_iterations=5)
    return bic(wider, weighed) + margin * pole_price(weighed) < bic(rival, weighed)


def _left_out(f: float, why: str) -> Rejected:
    """Name a line, Hz, left out of the fit."""
    return Rejected(2j * np.pi * float(f), f"line left out: {why}", "harmonic")


def _hums(lines: Lines, found: PoleFit, mains: float) -> NDArray[np.bool_]:
    """Poles of a fit that are needles at a mains harmonic: (J,) ndarray."""
    return np.array([needle_hum(p, mains, lines.spacing) is not None for p in found.poles], dtype=bool)


def _hum(f: float, mains: float, spacing: float) -> str:
    number, fundamental = harmonic_of(f, mains, spacing) or (1, mains)
    return f"{number} x {fundamental:g} Hz mains"


def _search(lines: Lines, count: int, settings: Settings) -> tuple[PoleFit, NDArray[np.complex128]]:
    """Find the order on averaged lines, from `count` start poles; also the start poles it came from."""
    richest = max(settings.terms, key=lambda terms: terms.parameters)
    blocks = averaged(lines)
    started = start_poles(blocks, min(count, max(len(blocks.frequency) // 4, 1)), richest)
    found = fit(blocks, started, richest, max_iterations=0)
    return eliminate(blocks, drop_unsupported(blocks, found, share=-0.5)), started


def settle(
    measured: Measured,
    lines: Lines,
    found: PoleFit,
    settings: Settings,
    proposals: NDArray[np.complex128] | None = None,
    *,
    rounds: int = MOST_SETTLINGS,
) -> PoleFit:
    """Bring an order that is about right to the one BIC prefers: births, residual terms, deaths.

    Parameters
    ----------
    measured : Measured
    lines : Lines
        All lines, unaveraged.
    found : PoleFit
        Start.
    settings : Settings
    proposals : (N,) complex ndarray, optional
        Poles to be tried besides those that the residual itself proposes, rad/s.
    rounds : int
        How often at most the order is settled anew because what it leaves over shows fewer independent lines than
        were counted on.

    Returns
    -------
    PoleFit
    """
    for _ in range(rounds):
        lines = measured.reweighted(lines, found)
        blocks = averaged(lines)
        found = fit(blocks, _widened(found.poles, lines.spacing), found.terms, tolerance=1e-4)
        found = add_missing(lines, blocks, found, proposals)
        found = choose_terms(blocks, found, settings.terms)
        found = fit(blocks, eliminate(blocks, found).poles, found.terms, tolerance=EXACT / len(lines.frequency))
        if rounds == 1 or measured.reweighted(lines, found).correlation < MORE_CORRELATED * lines.correlation:
            break
    return found


def _widened(poles: NDArray[np.complex128], spacing: float) -> NDArray[np.complex128]:
    """Poles no narrower than a line: a resonance may have got stuck there while its lines had other weights."""
    wide: NDArray[np.complex128] = np.minimum(poles.real, -2.0 * np.pi * spacing) + 1j * poles.imag
    return wide


def finish(
    measured: Measured,
    lines: Lines,
    found: PoleFit,
    settings: Settings,
) -> Modes:
    """Fit once more on all lines and judge every pole.

    Parameters
    ----------
    measured : Measured
    lines : Lines
        All lines, unaveraged.
    found : PoleFit
    settings : Settings

    Returns
    -------
    Modes
        Sorted by frequency.
    """
    lines = measured.reweighted(lines, found)
    tolerance = EXACT / len(lines.frequency) / len(lines.h)
    last = fit(lines, found.poles, found.terms, tolerance=tolerance, max_iterations=LAST_STEPS)
    return judged(lines, last, settings)[0]


def judged(
    lines: Lines, last: PoleFit, settings: Settings, spread: NDArray[np.float64] | None = None
) -> tuple[Modes, NDArray[np.intp]]:
    """Judge every pole of a finished fit.

    Parameters
    ----------
    lines : Lines
        All lines, unaveraged.
    last : PoleFit
        Of J poles.
    settings : Settings
    spread : (J, 2, 2) ndarray, optional
        Covariance of every pole's log |pole| and log damping ratio; the fit's own where there is none.

    Returns
    -------
    modes : Modes
        Sorted by frequency.
    place : (J,) ndarray of int
        Place of each pole of `last` in `modes`.
    """
    if spread is None:
        every = covariance(last, lines)
        spread = np.array([every[j : j + 2, j : j + 2] for j in range(0, len(every), 2)]).reshape(-1, 2, 2)
    status, reason = judge(lines, last, settings.mains, spread)
    order = np.argsort(last.poles.imag)
    left = residual(lines, last)
    modes = Modes(
        poles=last.poles[order],
        residues=last.projection.residues[:, order],
        covariance=spread[order],
        terms=last.terms,
        coefficients=last.projection.coefficients,
        status=tuple(status[j] for j in order),
        reason=tuple(reason[j] for j in order),
        band=(float(lines.frequency[0]), float(lines.frequency[-1])),
        misfit=float(np.sqrt((np.abs(left) ** 2).sum() / (np.abs(lines.h) ** 2).sum())),
        lines=len(lines.frequency),
    )
    return modes, np.argsort(order)


def _rejected(started: NDArray[np.complex128], stayed: NDArray[np.complex128]) -> tuple[Rejected, ...]:
    """Start poles with no final pole of their own within their width."""
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
    """Fit again from the poles and residual terms of `start`, with no search for the order: a warm start.

    Parameters
    ----------
    measured : Measured
    start : Modes
    settings : Settings, optional

    Returns
    -------
    Modes
    """
    settings = settings or Settings()
    lines = measured.lines()
    blocks = averaged(lines)
    found = fit(blocks, start.poles, start.terms, tolerance=1e-5)
    return replace(finish(measured, lines, found, settings), rejected=start.rejected)
