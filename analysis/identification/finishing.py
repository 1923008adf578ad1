"""From approximate poles to modes: final model order by BIC, last fit on all lines, status of every pole."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.damping_prior import DampingPrior
from analysis.identification.errors_at_peaks import variance_factors
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.missing import add_missing, residual, split
from analysis.identification.modes import Modes
from analysis.identification.order import choose_terms, covariance, eliminate, relative_deviations
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.settings import Settings
from analysis.identification.status import judge

LEAST_FALL_OF_MISFIT = 2e-2
"""Fall of the misfit, over that of one line, at which a fit stops: a seventh of a pole's standard deviation."""

LAST_STEPS = 10
"""Most projections on all lines: the fit on averaged lines has already converged for all but weak poles."""

MOST_SETTLINGS = 4
"""Most repetitions of the choice of the model order."""

MORE_CORRELATED = 1.1
"""Growth of the lines' correlation from which the model order is chosen again."""


def settle(measured: Measured, lines: Lines, found: PoleFit, settings: Settings) -> PoleFit:
    """Improve an approximate model order to the one of lowest BIC: add poles, choose residual terms, drop poles.

    Repeated while the residual shows fewer independent lines than assumed, or while the number of modes from which
    the distribution of damping ratios is estimated changes.

    Parameters
    ----------
    lines : Lines
        All lines, unaveraged.
    found : PoleFit
        Start.
    """
    for _ in range(MOST_SETTLINGS):
        before = len(found.poles)
        lines = measured.reweighted(lines, found)
        blocks = averaged(_with_damping(lines, found))
        found = fit(blocks, _widened(lines, found.poles), found.terms, tolerance=1e-4)
        found = add_missing(lines, blocks, found)
        while (two := split(blocks, found)) is not None:
            found = two
        found = choose_terms(blocks, found, settings.terms)
        found = fit(
            blocks,
            eliminate(blocks, found).poles,
            found.terms,
            tolerance=LEAST_FALL_OF_MISFIT / len(lines.frequency),
        )
        prior_changed = blocks.damping is not None and len(found.poles) != before
        if (
            not prior_changed
            and measured.reweighted(lines, found).correlation < MORE_CORRELATED * lines.correlation
        ):
            break
    return found


def _with_damping(lines: Lines, found: PoleFit) -> Lines:
    """Lines with the distribution of damping ratios estimated from the poles of a fit as prior."""
    fitted = found if found.projection.hessian.size else fit(lines, found.poles, found.terms, max_iterations=1)
    known = relative_deviations(fitted, lines)[:, 1]
    return replace(lines, damping=DampingPrior.estimated(fitted.poles, known, lines.band))


def _widened(lines: Lines, poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Poles widened to one line at least: with earlier weights a resonance may have converged to a single line."""
    one_line = 2.0 * np.pi * lines.spacing_at(poles.imag / (2.0 * np.pi))
    wide: NDArray[np.complex128] = np.minimum(poles.real, -one_line) + 1j * poles.imag
    return wide


def finish(measured: Measured, lines: Lines, found: PoleFit, settings: Settings) -> tuple[Modes, NDArray[np.intp]]:
    """Fit once more on all lines and determine the status of every pole.

    Parameters
    ----------
    lines : Lines
        All lines, unaveraged.

    Returns
    -------
    modes : Modes
        Sorted by frequency.
    place : (J,) ndarray of int
        Place of each pole of `found` in `modes`.
    """
    return judged(*last_fit(measured, lines, found), settings)


def last_fit(measured: Measured, lines: Lines, found: PoleFit) -> tuple[Lines, PoleFit]:
    """Fit once more on all lines.

    Parameters
    ----------
    lines : Lines
        All lines, unaveraged.

    Returns
    -------
    lines : Lines
        With the weights of `found`.
    last : PoleFit
    """
    lines = _with_damping(measured.reweighted(lines, found), found)
    tolerance = LEAST_FALL_OF_MISFIT / len(lines.frequency) / len(lines.h)
    return lines, fit(lines, found.poles, found.terms, tolerance=tolerance, max_iterations=LAST_STEPS)


def judged(
    lines: Lines, last: PoleFit, settings: Settings, spread: NDArray[np.float64] | None = None
) -> tuple[Modes, NDArray[np.intp]]:
    """Determine the status of every pole of a finished fit.

    Parameters
    ----------
    lines : Lines
        All lines, unaveraged.
    last : PoleFit
        Of J poles.
    spread : (J, 2, 2) ndarray, optional
        Covariance of every pole's log |pole| and log damping ratio; taken from the fit if not given.

    Returns
    -------
    modes : Modes
        Sorted by frequency.
    place : (J,) ndarray of int
        Place of each pole of `last` in `modes`.
    """
    left = residual(lines, last)
    if spread is None:
        every = covariance(last, lines)
        spread = np.array([every[j : j + 2, j : j + 2] for j in range(0, len(every), 2)]).reshape(-1, 2, 2)
        more = np.sqrt(variance_factors(lines, last, left))
        spread = spread * more[:, :, None] * more[:, None, :]
    status, reason = judge(lines, last, settings.mains, spread, left)
    order = np.argsort(last.poles.imag)
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
