"""Effects tried on modes, and on temperatures, that they were not fitted to, beside a discrepancy.

An effect that acts on one mode only hides among the scatter of modes; one that is there predicts the others.
"""

from dataclasses import dataclass

import numpy as np

from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.misfit import relative_misfit
from analysis.gap.imperfect.search import Imperfect, ImperfectResult
from analysis.gap.search.context import SearchContext
from analysis.gap.search.held_out import LEAST_TEMPERATURES, HeldOut, Split, fit_and_try

BLOCKS, EVERY = 18, 3
"""Number of blocks of the band, some two modes each, and how many of them there are for each that is held out."""


def tried_elsewhere(plain: SearchContext, found: ImperfectResult) -> tuple[HeldOut, ...]:
    """Try the effects found on a third of the band, and on every second temperature.

    Parameters
    ----------
    plain : SearchContext
        Unweighted, of the sweeps that were searched.
    found : ImperfectResult

    Returns
    -------
    tuple of HeldOut
    """
    ways = ["every third part of the band"]
    if len(plain.sweeps.groups.reference) >= LEAST_TEMPERATURES:
        ways.append("every second temperature")
    return tuple(_tried(plain, what, found) for what in ways)


def _split(sweeps: GapSweeps, what: str) -> Split:
    if "temperature" in what:
        count = len(sweeps.groups.reference)
        even, odd = list(range(0, count, 2)), list(range(1, count, 2))
        return Split(what, sweeps.only_groups(even), sweeps.only_groups(odd), laws_free=True)
    shape = sweeps.rows.shape
    block = np.arange(shape[-1]) * BLOCKS // shape[-1]
    out = np.broadcast_to(block % EVERY == 1, shape)
    return Split(what, sweeps.masked(~out), sweeps.masked(out), laws_free=False)


def _tried(plain: SearchContext, what: str, found: ImperfectResult) -> HeldOut:
    before = _Tried.of(plain, what, found.baseline)
    try:
        after = _Tried.of(plain, what, found.final)
    except ValueError:  # what was learnt leaves the certified range of the twin
        after = before
    chi2, dof = after.test.between
    gap = before.chi2 - before.dof
    return HeldOut(
        what=what,
        baseline_chi2=before.chi2 + chi2,
        final_chi2=after.chi2 + chi2,
        dof=after.dof + dof,
        baseline_misfit=before.misfit,
        final_misfit=after.misfit,
        closure=float(np.clip(1.0 - (after.chi2 - after.dof) / gap, 0.0, 1.0)) if gap > 0.0 else None,
        closure_sigma=None,
        gain=after.log_probability - before.log_probability,
    )


@dataclass(frozen=True)
class _Tried:
    """A twin on data held out: chi2 in units of the noise, misfit, log probability beside its discrepancy."""

    test: GapSweeps
    chi2: float
    dof: float
    misfit: float
    log_probability: float

    @classmethod
    def of(cls, plain: SearchContext, what: str, twin: Imperfect) -> "_Tried":
        sweeps = twin.context.sweeps
        split = _split(sweeps, what)
        fit = fit_and_try(plain.model, sweeps, split, twin.fit, plain.executor)
        places = split.test.original_places(sweeps)
        penalty = twin.shape.only(places).penalty(split.test, twin.scatter)
        return cls(
            test=split.test,
            chi2=float((np.abs(split.test.weights.undone(fit.residual)) ** 2).sum()),
            dof=fit.dof,
            misfit=relative_misfit(split.test, fit),
            log_probability=-0.5 * fit.total - penalty,
        )
