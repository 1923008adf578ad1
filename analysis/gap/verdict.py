"""Verdict on the result of the search."""

from dataclasses import dataclass

from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.report import Verdict
from analysis.gap.search.context import SearchContext
from analysis.gap.search.held_out import HeldOut
from analysis.gap.search.stepwise import SearchResult
from analysis.gap.search.unknown import noise_evidence, unknown_evidence


@dataclass(frozen=True)
class Judgement:
    """A verdict, and the reason as text."""

    verdict: Verdict
    reason: str


def judge(context: SearchContext, found: SearchResult, tried: HeldOut | None) -> Judgement:
    """Decide whether named effects bring the twin down to the noise.

    Where none do, the verdict is unknown, and `analysis.gap.imperfect` may name effects beside what is left. An
    effect is accepted by the remaining residual here: beside noise alone, evidence grows with every effect that
    fits a little.

    Parameters
    ----------
    context : SearchContext
    found : SearchResult
    tried : HeldOut or None
        The split that decides; None where no effect was found.

    Returns
    -------
    Judgement
    """
    silent = context.agrees(found.baseline)
    if not found.effects or tried is None:
        if silent:
            return Judgement("none", "the twin agrees with the data to the noise, no effect adds to it")
        return Judgement("unknown", "there is a gap, and no effect of the library explains it")
    if not tried.holds:
        verdict: Verdict = "none" if silent else "unknown"
        return Judgement(verdict, f"what was found does not hold on data left out ({tried.what})")
    if context.agrees(found.fit) and not _leaves_structure(context, found.fit):
        return Judgement("explained", "with the effects named, twin and data agree to the noise")
    return Judgement("unknown", "with the best effects, more than noise is left")


def _leaves_structure(context: SearchContext, fit: GapFit) -> bool:
    """Whether the residual, beyond the twin's own error, has more evidence for a discrepancy than noise has."""
    if context.excess(fit) <= context.allowed(fit):
        return False
    least = noise_evidence(context.sweeps) * context.overstated(fit)
    return unknown_evidence(context.sweeps, fit.residual, fit.state) >= least
