"""How many poles: backward elimination and one look back, both judged by BIC."""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.bic import bic, misfit_worth, pole_price, support
from analysis.identification.lines import Lines
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.residual_terms import CHOICES, ResidualTerms
from analysis.identification.resolution import unresolved
from analysis.identification.variable_projection import Projection, project

ROUGH = 3e-4
"""Relative fall of the misfit that is not worth another iteration while poles still come and go."""


UNSEEN = 1e-13
"""Information about a direction, relative to that about a single parameter, which is rounding."""


def covariance(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Covariance (2J, 2J) of log |pole| and log damping ratio, from the Jacobian and the misfit found.

    Lines whose errors go together count as often as they are independent. What the data do not determine has a
    variance without end, not none: directions that rounding hides keep the largest that rounding lets through.
    """
    now = fitted.projection
    freedom = max(lines.independent - fitted.parameters, 1.0) * lines.correlation
    root = np.sqrt(np.maximum(np.diag(now.hessian), np.finfo(float).tiny))
    size, directions = np.linalg.eigh(now.hessian / root[:, None] / root)
    directions /= root[:, None]
    inverse: NDArray[np.float64] = (directions / np.maximum(size, UNSEEN)) @ directions.T
    return inverse * ((now.misfit + lines.hidden) / freedom * lines.correlation)


def relative_deviations(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Return the standard deviations of log |pole| and log damping ratio, (J, 2)."""
    spread: NDArray[np.float64] = np.sqrt(np.diag(covariance(fitted, lines))).reshape(-1, 2)
    return spread


def drop_unsupported(lines: Lines, fitted: PoleFit, share: float = 0.0) -> PoleFit:
    """Drop, weakest first, the poles whose absence costs less than their price, the others held.

    Parameters
    ----------
    lines : Lines
    fitted : PoleFit
    share : float
        Of the price, a margin: 0 drops whatever does not pay, -0.5 only what pays less than half.

    Returns
    -------
    PoleFit
    """
    price = pole_price(lines)
    while len(fitted.poles):
        rise = support(fitted, lines)
        below = int((rise < share * price).sum())
        if below == 0:
            break
        # bounds of several poles do not add up, so no more than a quarter of them go at once
        fitted = _at(lines, np.delete(fitted.poles, np.argsort(rise)[: max(below // 4, 1)]), fitted.terms)
    return fitted


def _without_unsupported(lines: Lines, fitted: PoleFit) -> PoleFit:
    """Drop what does not pay, and refit the others."""
    left = drop_unsupported(lines, fitted)
    start = fitted.projection if left is fitted else None
    return fit(lines, left.poles, left.terms, tolerance=ROUGH, max_iterations=8, start=start)


def _at(lines: Lines, poles: NDArray[np.complex128], terms: ResidualTerms) -> PoleFit:
    return fit(lines, poles, terms, max_iterations=0)


def eliminate(lines: Lines, fitted: PoleFit, *, candidates: int = 3) -> PoleFit:
    """Backward elimination: drop or merge poles, refitting the others, as long as BIC falls.

    Parameters
    ----------
    lines : Lines
        What was measured.
    fitted : PoleFit
        Over-specified start.
    candidates : int
        How many of the weakest poles are tried before the order is accepted.

    Returns
    -------
    PoleFit
    """
    free = _at(lines, fitted.poles[~fitted.stuck | _outstanding(lines, fitted)], fitted.terms)
    lesser = unresolved(free.poles, free.projection.residues, lines.spacing)
    best = fit(lines, free.poles[~lesser], fitted.terms, tolerance=ROUGH, max_iterations=8)
    best = _without_unsupported(lines, best)
    while True:
        best = drop_unresolved(lines, best)
        smaller = _smaller(lines, best, candidates)
        if smaller is None:
            return best
        best = smaller


def _outstanding(lines: Lines, fitted: PoleFit) -> NDArray[np.bool_]:
    """Poles in the band that so much rests on that even at a bound only a refit without them may drop them."""
    place = fitted.poles.imag / (2.0 * np.pi)
    inside = (place > lines.frequency[0]) & (place < lines.frequency[-1])
    strong: NDArray[np.bool_] = inside & (support(fitted, lines) > 10.0 * pole_price(lines))
    return strong


def drop_unresolved(lines: Lines, fitted: PoleFit) -> PoleFit:
    """Drop poles that the lines cannot tell apart, refitting the others, until all can be."""
    while (lesser := unresolved(fitted.poles, fitted.projection.residues, lines.spacing)).any():
        fitted = fit(lines, fitted.poles[~lesser], fitted.terms, tolerance=ROUGH, max_iterations=8)
    return fitted


def attempt(
    lines: Lines,
    poles: NDArray[np.complex128],
    terms: ResidualTerms,
    level: float,
    *,
    start: Projection | None = None,
) -> PoleFit | None:
    """Fit a rival model; given up early where its BIC cannot fall below `level`.

    Parameters
    ----------
    lines : Lines
    poles : (J,) complex ndarray
        Start, rad/s, upper half plane.
    terms : ResidualTerms
    level : float
        BIC to fall below.
    start : Projection, optional
        The projection at `poles`, if it is known already.

    Returns
    -------
    PoleFit or None
        None where its BIC does not fall below `level`.
    """
    responses = len(lines.h)
    parameters = len(poles) * (2 + 2 * responses) + responses * terms.parameters
    target = misfit_worth(lines, level, parameters)
    trial = fit(lines, poles, terms, tolerance=ROUGH, max_iterations=18, start=start, target=target)
    return trial if trial.projection.misfit < target else None


def _smaller(lines: Lines, best: PoleFit, candidates: int) -> PoleFit | None:
    """Find a fit with fewer poles and a lower BIC, or None."""
    level = bic(best, lines)
    for suspect in suspects(lines, best, candidates):
        trial = attempt(lines, np.delete(best.poles, suspect), best.terms, level)
        if trial is not None:
            return _without_unsupported(lines, trial)
    for first, second in duplicates(best.poles):
        merged = np.append(np.delete(best.poles, [first, second]), best.poles[[first, second]].mean())
        trial = attempt(lines, merged, best.terms, level)
        if trial is not None:
            return trial
    return None


def suspects(lines: Lines, fitted: PoleFit, count: int) -> list[int]:
    """Poles worth dropping on trial: those that explain least, then the ill-determined ones.

    One of two poles that share a peak explains much as long as the other stays where it is; what gives it away is
    that its damping is hardly known.

    Parameters
    ----------
    lines : Lines
    fitted : PoleFit
    count : int
        How many of those that explain least are looked at.

    Returns
    -------
    list of int
        Places of the poles in `fitted`, at most `count` + 2.
    """
    rise, price = support(fitted, lines), pole_price(lines)
    rise[fitted.stuck] = -np.inf
    listed = [int(j) for j in np.argsort(rise)[:count] if rise[j] < 8.0 * price]
    uncertain = relative_deviations(fitted, lines)[:, 1]
    place = fitted.poles.imag / (2.0 * np.pi)
    uncertain[(place < lines.frequency[0]) | (place > lines.frequency[-1])] = 0.0  # background, never well known
    listed += [
        int(j)
        for j in np.argsort(uncertain)[::-1][:2]
        if uncertain[j] > 0.1 and rise[j] < 60.0 * price and j not in listed
    ]
    return listed


def duplicates(poles: NDArray[np.complex128], share: float = 0.5) -> list[tuple[int, int]]:
    """Pairs of poles closer than a share of their mean half width, closest first."""
    pairs = []
    for i in range(len(poles)):
        for j in range(i + 1, len(poles)):
            width = -0.5 * (poles[i].real + poles[j].real)
            distance = abs(poles[i] - poles[j]) / width
            if distance < share:
                pairs.append((distance, i, j))
    return [(i, j) for _, i, j in sorted(pairs)]


def choose_terms(lines: Lines, fitted: PoleFit, choices: tuple[ResidualTerms, ...] = CHOICES) -> PoleFit:
    """Choose the residual terms of lowest BIC, the poles refitted with each.

    Parameters
    ----------
    lines : Lines
    fitted : PoleFit
        Start, with residual terms of its own.
    choices : tuple of ResidualTerms
        Tried besides those of `fitted`.

    Returns
    -------
    PoleFit
    """
    best = fitted
    for terms in choices:
        if terms != fitted.terms:
            at = project(lines, fitted.poles, terms)
            trial = attempt(lines, fitted.poles, terms, bic(best, lines), start=at)
            best = trial if trial is not None else best
    return best
