"""Poles and residues of FRFs without a human: vector fitting, variable projection, order by BIC."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged, roughness
from analysis.identification.harmonics import harmonic_lines
from analysis.identification.lines import Lines
from analysis.identification.missing import add_missing, residual
from analysis.identification.modes import Modes, Rejected
from analysis.identification.noise import deviation_from_residual
from analysis.identification.order import choose_terms, covariance, drop_unsupported, eliminate
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.residual_terms import CHOICES, ResidualTerms
from analysis.identification.status import judge
from analysis.identification.vector_fitting import start_poles

EXACT = 2e-2
"""Fall of the misfit, in units of one line's, at which a fit stops: a seventh of the weakest pole's deviation."""

LAST_STEPS = 10
"""Projections on all lines at most: averaged lines have brought all but the weakest poles to rest already."""


@dataclass(frozen=True)
class Settings:
    """How FRFs are identified.

    Attributes
    ----------
    start_count : int
        Pole pairs vector fitting starts with; doubled while more than 0.7 of them stay.
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


@dataclass(frozen=True)
class Measured:
    """FRFs of one condition as they come.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    h : (K, F) complex ndarray
        One drive, K responses.
    variance : (K, F) ndarray or None
        E|h - H|^2; None, or not above zero on some line, where it is not known.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    variance: NDArray[np.float64] | None = None

    @property
    def known(self) -> bool:
        """Whether every line has a variance."""
        return self.variance is not None and bool((self.variance > 0.0).all())

    def without(self, spoilt: NDArray[np.bool_]) -> "Measured":
        """Leave out lines (F,)."""
        variance = None if self.variance is None else self.variance[:, ~spoilt]
        return Measured(self.frequency[~spoilt], self.h[:, ~spoilt], variance)

    def lines(self) -> Lines:
        """Lines weighted by the variance if it is known, by the roughness along frequency otherwise."""
        if self.known and self.variance is not None:
            return Lines(self.frequency, self.h, np.sqrt(self.variance))
        return Lines(self.frequency, self.h, roughness(self.h))

    def reweighted(self, lines: Lines, fitted: PoleFit) -> Lines:
        """Lines weighted by what a fit leaves over, unless the variance is known."""
        if self.known:
            return lines
        return Lines(self.frequency, self.h, deviation_from_residual(residual(lines, fitted), self.h))


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
    count = min(settings.start_count, max(len(lines.frequency) // 6, 1))
    while True:
        found, started = _search(measured, lines, count, settings)
        if len(found.poles) <= 0.7 * count or 2 * count > min(settings.most_count, len(lines.frequency) // 6):
            break
        count *= 2
    rejected: tuple[Rejected, ...] = ()
    if settings.mains is not None:
        spoilt = harmonic_lines(lines.frequency, residual(lines, found), lines.spacing, settings.mains)
        if spoilt.any():
            rejected = _spoilt(lines.frequency[spoilt], settings.mains)
            measured = measured.without(spoilt)
            lines = measured.lines()
            found = settle(measured, lines, found, settings)
    modes = finish(measured, lines, found, settings)
    return replace(modes, rejected=(*_rejected(started, modes.poles), *rejected))


def _spoilt(frequency: NDArray[np.float64], mains: float) -> tuple[Rejected, ...]:
    """Name the lines left out for the mains."""
    return tuple(
        Rejected(
            2j * np.pi * float(f), f"line left out: {max(round(f / mains), 1)} x {mains:g} Hz mains", "harmonic"
        )
        for f in frequency
    )


def _search(
    measured: Measured, lines: Lines, count: int, settings: Settings
) -> tuple[PoleFit, NDArray[np.complex128]]:
    """Find the order on averaged lines; also the start poles it came from."""
    richest = max(settings.terms, key=lambda terms: terms.parameters)
    blocks = averaged(lines)
    started = start_poles(blocks, min(count, max(len(blocks.frequency) // 4, 1)), richest)
    found = fit(blocks, started, richest, max_iterations=0)
    found = eliminate(blocks, drop_unsupported(blocks, found, share=-0.5))
    return settle(measured, lines, found, settings), started


def settle(
    measured: Measured,
    lines: Lines,
    found: PoleFit,
    settings: Settings,
    proposals: NDArray[np.complex128] | None = None,
) -> PoleFit:
    """Bring an order that is about right to the one BIC prefers: births, residual terms, deaths.

    `proposals` are poles to be tried besides those that the residual itself proposes.
    """
    lines = measured.reweighted(lines, found)
    blocks = averaged(lines)
    found = fit(blocks, found.poles, found.terms, tolerance=1e-4)
    found = add_missing(lines, blocks, found, proposals)
    found = choose_terms(blocks, found, settings.terms)
    return fit(blocks, eliminate(blocks, found).poles, found.terms, tolerance=EXACT / len(lines.frequency))


def finish(
    measured: Measured,
    lines: Lines,
    found: PoleFit,
    settings: Settings,
) -> Modes:
    """Fit on all lines and judge every pole."""
    lines = measured.reweighted(lines, found)
    tolerance = EXACT / len(lines.frequency) / len(lines.h)
    last = fit(lines, found.poles, found.terms, tolerance=tolerance, max_iterations=LAST_STEPS)
    status, reason = judge(lines, last, settings.mains)
    order = np.argsort(last.poles.imag)
    spread = covariance(last, lines)
    pairs = np.array([spread[2 * j : 2 * j + 2, 2 * j : 2 * j + 2] for j in order]).reshape(-1, 2, 2)
    left = residual(lines, last)
    return Modes(
        poles=last.poles[order],
        residues=last.projection.residues[:, order],
        covariance=pairs,
        terms=last.terms,
        coefficients=last.projection.coefficients,
        status=tuple(status[j] for j in order),
        reason=tuple(reason[j] for j in order),
        band=(float(lines.frequency[0]), float(lines.frequency[-1])),
        misfit=float(np.sqrt((np.abs(left) ** 2).sum() / (np.abs(lines.h) ** 2).sum())),
        lines=len(lines.frequency),
    )


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
    """Fit again from the poles and residual terms of `start`, with no search for the order: a warm start."""
    settings = settings or Settings()
    lines = measured.lines()
    blocks = averaged(lines)
    found = fit(blocks, start.poles, start.terms, tolerance=1e-5)
    return replace(finish(measured, lines, found, settings), rejected=start.rejected)
