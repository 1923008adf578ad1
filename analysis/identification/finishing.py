"""From approximate poles to modes: final model order by BIC, last fit on all lines, status of every pole.

Standard deviations allow for errors at the peaks. The covariance of a fit takes the errors as known on every line,
but for one factor. Few measured FRFs are so: what a nonlinearity, a window or a low coherence adds is largest at
the peaks, where poles are determined; and if a structure warms up, every FRF has another pole. The residual shows
both: errors at the peaks by their size there (MacKinnon and White, J. Econometrics 29, 1985, HC2), the poles'
scatter over the FRFs by what these errors do not explain of it (DerSimonian and Laird, Controlled Clinical Trials
7, 1986). Either counts where it is more than chance, over all poles or at this one: three FRFs tell so little of a
scatter that what chance adds, were it counted where it is positive, would make deviations a quarter too large.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.special
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.judgement.resolution import half_distances, lines_near
from analysis.identification.judgement.status import judge
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.missing import add_missing, residual, split
from analysis.identification.modes import DampingPrior, Modes
from analysis.identification.order import choose_terms, covariance, eliminate, relative_deviations
from analysis.identification.pole_search import PoleFit, fit
from analysis.identification.settings import Settings

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


HALF_WIDTHS_USED = 10.0
"""Lines used, in half widths on either side of a pole: 99 % of what determines it."""

FEWEST_LINES = 8
"""Lines used at least."""

SHARE_IN_OTHER_FRFS = 0.1
"""Share of a mode outside the FRF that shows it best, from which its scatter over the FRFs is estimated."""

CHANCE_OF_ALL, CHANCE_OF_ONE = 0.02, 0.01
"""Probabilities with which errors of one size on all lines pass for more, over all poles and at one of them."""


def variance_factors(lines: Lines, last: PoleFit, left: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the factors, one at least, on the variances of log |pole| and log damping ratio.

    Parameters
    ----------
    lines : Lines
        All lines that the fit was made on, K FRFs.
    last : PoleFit
        Of J poles.
    left : (K, F) complex ndarray
        Residual of the fit.

    Returns
    -------
    (J, 2) ndarray
    """
    normalised = left / lines.deviation
    size = float(np.sqrt((np.abs(normalised) ** 2).mean()))
    factors = np.ones((len(last.poles), 2))
    if not size > 0.0:
        return factors
    found: dict[int, _Pole] = {}
    for j, (pole, residue) in enumerate(zip(last.poles, last.projection.residues.T, strict=True)):
        near = lines_near(lines, pole, HALF_WIDTHS_USED, FEWEST_LINES)
        shape = 1.0 / (lines.s[near] - pole) / lines.deviation[:, near]
        if (np.abs(residue) > 0.0).all():
            found[j] = _Pole.of(shape, residue, lines.s[near] - pole, normalised[:, near] / size, lines.redundancy)
    if not found:
        return factors
    poles = list(found.values())
    freedom = np.array([[one.freedom, one.several_freedom, one.several_freedom] for one in poles])
    within = np.array([one.within for one in poles])
    within = np.where(_more_than_chance(within, freedom[:, 0]), np.maximum(within, 1.0), 1.0)
    ratios = np.array([one.scatter / (one.expected * w) for one, w in zip(poles, within, strict=True)])
    counts = np.array([_more_than_chance(ratios[:, c], freedom[:, 1 + c]) for c in range(2)]).T
    for j, one, w, ratio, count in zip(found, poles, within, ratios, counts, strict=True):
        between = np.where(count, np.maximum(ratio - 1.0, 0.0), 0.0) * one.expected * w
        factors[j] = w + one.of_scatter * between
    return factors


def _more_than_chance(ratio: NDArray[np.float64], freedom: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell which ratios (J,), of as many degrees of freedom as each has, are above 1 by more than chance."""
    total = float(freedom.sum())
    if not total > 0.0:
        return np.zeros(len(ratio), dtype=bool)
    if float(freedom @ ratio) > scipy.special.chdtri(total, CHANCE_OF_ALL):
        return freedom > 0.0
    alone = scipy.special.chdtri(np.maximum(freedom, 1e-9), CHANCE_OF_ONE)
    return np.asarray((freedom > 0.0) & (freedom * ratio > alone))


@dataclass(frozen=True)
class _Pole:
    """What the residual near one pole says of its errors.

    Attributes
    ----------
    within : float
        Mean square of the residual where the pole is determined; 1 for errors of one size on all lines.
    freedom : float
        Degrees of freedom of `within`.
    scatter : (2,) ndarray
        Of log |pole| and log damping ratio over the FRFs, weighted.
    expected : float
        The same by errors of one size.
    several_freedom : float
        Degrees of freedom of `scatter`; 0 where one FRF has nearly all of the mode.
    of_scatter : float
        Factor on the pole's variance per variance of what it scatters.
    """

    within: float
    freedom: float
    scatter: NDArray[np.float64]
    expected: float
    several_freedom: float
    of_scatter: float

    @classmethod
    def of(
        cls,
        shape: NDArray[np.complex128],
        residue: NDArray[np.complex128],
        away: NDArray[np.complex128],
        r: NDArray[np.complex128],
        redundancy: float,
    ) -> "_Pole":
        """Take it from the residual r near a pole.

        With the pole the model changes by b = R/(s - pole)^2; c is what remains of it beside 1/(s - pole), which
        the residue takes up, both over the deviations. The residual r of an FRF moves its own pole by
        sum(c* r)/sum|c|^2; what r still is then gives the size of the errors.
        """
        a = shape / np.linalg.norm(shape, axis=1, keepdims=True)
        c = residue[:, None] * shape / away
        c -= a * (a.conj() * c).sum(axis=1, keepdims=True)
        weight = np.abs(c) ** 2
        own = weight.sum(axis=1)  # inverse variance of the pole in each FRF
        moved = (c.conj() * r).sum(axis=1) / own
        moved -= (own * moved).sum() / own.sum()
        free = np.maximum(1.0 - np.abs(a) ** 2 - weight / own[:, None], 0.1)  # a line draws the model to itself
        within = float((weight * np.abs(r - c * moved[:, None]) ** 2 / free).sum() / own.sum())
        freedom = 2.0 * float(own.sum()) ** 2 / float((weight**2).sum()) / redundancy
        u = np.abs(residue) ** 2 / (np.abs(residue) ** 2).sum()  # not own: the fit is drawn to FRFs it describes
        several = 1.0 - float((u**2).sum())
        moved -= (u * moved).sum()
        return cls(
            within=within,
            freedom=freedom,
            scatter=np.array([(u * moved.imag**2).sum(), (u * moved.real**2).sum()]),
            expected=max(float((u * (1.0 - u) * 0.5 * redundancy / own).sum()), np.finfo(float).tiny),
            several_freedom=several / (1.0 - several) if several > SHARE_IN_OTHER_FRFS else 0.0,
            of_scatter=2.0 * float((own**2).sum() / own.sum()) / redundancy / max(several, SHARE_IN_OTHER_FRFS),
        )


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
    apart = half_distances(lines, last, left)
    status, reason = judge(lines, last, settings.mains, spread, apart)
    relative = np.stack([apart / np.abs(last.poles), apart / -last.poles.real])
    spread = spread + (relative**2).T[:, :, None] * np.eye(2)
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
