"""Model order: backward elimination of poles and choice of residual terms by BIC.

In the criterion the scale of the noise is taken as unknown (n log misfit): otherwise every small model error would
be fitted with poles. Where responses share their errors, as those of the measured force, they count as fewer, in
the number of values and in that of residues.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.judgement.resolution import unresolved
from analysis.identification.lines import Lines
from analysis.identification.pole_residue import CHOICES, ResidualTerms
from analysis.identification.pole_search import PoleFit, Projection, fit, project

ROUGH_FALL_OF_MISFIT = 3e-4
"""Relative fall of the misfit at which fits stop while the model order is not final."""


STRONG_POLE_SUPPORT = 10.0
"""Support of a strong pole, in penalties of one pole. Without one outside the band that explains much, the noise
is estimated too large, and a fit can lose its other poles."""

UNSEEN_EIGENVALUE = 1e-13
"""Relative eigenvalue of the information matrix below which it is rounding error."""


def covariance(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Covariance (2J, 2J) of log |pole| and log damping ratio, from the Jacobian and the misfit found.

    Lines and responses with correlated errors count as fewer independent ones. A direction that the data do not
    determine gets the largest variance that rounding error allows, not zero.
    """
    now = fitted.projection
    freedom = max(lines.values / lines.correlation - fitted.parameters, 1.0) * lines.correlation
    root = np.sqrt(np.maximum(np.diag(now.hessian), np.finfo(float).tiny))
    size, directions = np.linalg.eigh(now.hessian / root[:, None] / root)
    directions /= root[:, None]
    inverse: NDArray[np.float64] = (directions / np.maximum(size, UNSEEN_EIGENVALUE)) @ directions.T
    return inverse * ((now.misfit + lines.hidden) / freedom * lines.redundancy)


def relative_deviations(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Return the standard deviations of log |pole| and log damping ratio, (J, 2)."""
    spread: NDArray[np.float64] = np.sqrt(np.diag(covariance(fitted, lines))).reshape(-1, 2)
    return spread


def bic(fitted: PoleFit, lines: Lines) -> float:
    """Bayesian information criterion, n log(misfit) + parameters log(n); smaller is better."""
    n, misfit = lines.independent, fitted.projection.misfit + lines.hidden
    parameters = _parameters(lines, len(fitted.poles), fitted.terms)
    return float(n * np.log(misfit / lines.values) + parameters * np.log(n))


def _parameters(lines: Lines, poles: int, terms: ResidualTerms) -> float:
    """Two of every pole; two of every residue, and the residual terms, for every independent response."""
    return 2 * poles + (2 * poles + terms.parameters) * lines.responses


def misfit_worth(lines: Lines, level: float, poles: int, terms: ResidualTerms) -> float:
    """Return the misfit at which a model reaches a BIC of `level`.

    Parameters
    ----------
    level : float
        BIC.
    poles : int
        Number of poles of the model.
    terms : ResidualTerms
        Of the model.

    Returns
    -------
    float
        Sum of squared errors in units of the deviations; negative where no misfit is low enough.
    """
    n = lines.independent
    penalty = _parameters(lines, poles, terms) * np.log(n)
    return float(lines.values * np.exp((level - penalty) / n) - lines.hidden)


def pole_penalty(lines: Lines) -> float:
    """Return the BIC penalty for one pole: two parameters, and a complex residue for every response."""
    return float((2.0 + 2.0 * lines.responses) * np.log(lines.independent))


def support(fitted: PoleFit, lines: Lines) -> NDArray[np.float64]:
    """Rise of BIC, at most, if each pole were dropped: (J,) ndarray.

    An upper bound, because the other poles are not refitted; a pole with a negative value has to be dropped.
    """
    n, now = lines.independent, fitted.projection
    rise: NDArray[np.float64] = n * np.log1p(now.loss / (now.misfit + lines.hidden)) - pole_penalty(lines)
    return rise


def drop_unsupported(lines: Lines, fitted: PoleFit, share: float = 0.0) -> PoleFit:
    """Drop, weakest first, the poles that BIC does not support with the others held.

    Parameters
    ----------
    share : float
        Margin as a share of a pole's BIC penalty: 0 drops all unsupported poles, -0.5 only clearly unsupported
        ones.
    """
    penalty = pole_penalty(lines)
    while len(fitted.poles):
        rise = support(fitted, lines)
        below = int((rise < share * penalty).sum())
        if below == 0:
            break
        # the bounds hold for one pole at a time, so no more than a quarter of them are dropped at once
        fitted = _at(lines, np.delete(fitted.poles, np.argsort(rise)[: max(below // 4, 1)]), fitted.terms)
    return fitted


def _without_unsupported(lines: Lines, fitted: PoleFit) -> PoleFit:
    """Drop poles that BIC does not support, and refit the others."""
    left = drop_unsupported(lines, fitted)
    start = fitted.projection if left is fitted else None
    return fit(lines, left.poles, left.terms, tolerance=ROUGH_FALL_OF_MISFIT, max_iterations=8, start=start)


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
        Number of weakest poles whose removal is tried before the order is accepted.
    """
    free = _at(lines, fitted.poles[~fitted.stuck | _outstanding(lines, fitted)], fitted.terms)
    lesser = unresolved(lines, free.poles, free.projection.residues)
    best = fit(lines, free.poles[~lesser], fitted.terms, tolerance=ROUGH_FALL_OF_MISFIT, max_iterations=8)
    best = _without_unsupported(lines, best)
    while True:
        best = drop_unresolved(lines, best)
        smaller = _smaller(lines, best, candidates)
        if smaller is None:
            return best
        best = smaller


def _outstanding(lines: Lines, fitted: PoleFit) -> NDArray[np.bool_]:
    """Strong poles, (J,): even at a bound of the search they are dropped only after a refit."""
    strong: NDArray[np.bool_] = support(fitted, lines) > STRONG_POLE_SUPPORT * pole_penalty(lines)
    return strong


def drop_unresolved(lines: Lines, fitted: PoleFit) -> PoleFit:
    """Drop poles that the lines cannot separate and refit the others, until all can be separated."""
    while (lesser := unresolved(lines, fitted.poles, fitted.projection.residues)).any():
        fitted = fit(lines, fitted.poles[~lesser], fitted.terms, tolerance=ROUGH_FALL_OF_MISFIT, max_iterations=8)
    return fitted


def attempt(
    lines: Lines,
    poles: NDArray[np.complex128],
    terms: ResidualTerms,
    level: float,
    *,
    start: Projection | None = None,
) -> PoleFit | None:
    """Fit an alternative model; the fit stops early where its BIC cannot fall below `level`.

    Parameters
    ----------
    poles : (J,) complex ndarray
        Start, rad/s, upper half plane.
    level : float
        BIC to fall below.
    start : Projection, optional
        The projection at `poles`, if it is known already.

    Returns
    -------
    PoleFit or None
        None where its BIC does not fall below `level`.
    """
    target = misfit_worth(lines, level, len(poles), terms)
    trial = fit(lines, poles, terms, tolerance=ROUGH_FALL_OF_MISFIT, max_iterations=18, start=start, target=target)
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
    """Candidates for removal: the poles that explain least, then the ill-determined ones.

    One of two poles at the same peak explains much as long as the other is held; its damping, though, is hardly
    determined.

    Parameters
    ----------
    count : int
        Number of poles taken from those that explain least.

    Returns
    -------
    list of int
        Places of the poles in `fitted`, at most `count` + 2.
    """
    rise, penalty = support(fitted, lines), pole_penalty(lines)
    rise[fitted.stuck] = -np.inf
    listed = [int(j) for j in np.argsort(rise)[:count] if rise[j] < 8.0 * penalty]
    uncertain = relative_deviations(fitted, lines)[:, 1]
    place = fitted.poles.imag / (2.0 * np.pi)
    uncertain[(place < lines.frequency[0]) | (place > lines.frequency[-1])] = 0.0  # background poles
    listed += [
        int(j)
        for j in np.argsort(uncertain)[::-1][:2]
        if uncertain[j] > 0.1 and rise[j] < 60.0 * penalty and j not in listed
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
    fitted : PoleFit
        Start, with residual terms of its own.
    choices : tuple of ResidualTerms
        Tried besides those of `fitted`.
    """
    best = fitted
    for terms in choices:
        if terms != fitted.terms:
            at = project(lines, fitted.poles, terms)
            trial = attempt(lines, fitted.poles, terms, bic(best, lines), start=at)
            best = trial if trial is not None else best
    return best
