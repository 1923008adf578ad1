"""Relocation: an effect with a place is fitted again from other sites, beside the other effects found."""

from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.search.context import SearchContext
from analysis.gap.search.drop_and_swap import dropped
from analysis.gap.search.refit import absent, at_few_temperatures, started_from
from analysis.gap.search.score_test import score_test
from analysis.gap.thresholds import SITES_REFITTED


def relocated(context: SearchContext, baseline: GapFit, fit: GapFit) -> GapFit:
    """Fit every effect that has several sites again from the best of them, and return the best fit.

    The first effect of several is placed while the signal of the others is still in the residual. A fit moves it
    to the nearest maximum of the evidence only, which may be another place than that of the effect.

    Parameters
    ----------
    context : SearchContext
    baseline : GapFit
        Without effects.
    fit : GapFit
        With the effects found.

    Returns
    -------
    GapFit
        `fit` where no other place is better.
    """
    for name in fit.state.effects:
        if len(context.model.cards[name].sites) > 1:
            fit = _placed_again(context, fit, dropped(context, baseline, fit, name), name)
    return fit


def _placed_again(context: SearchContext, fit: GapFit, rest: GapFit, name: str) -> GapFit:
    """Return the best of `fit` and of fits from other sites of an effect that `rest` lacks."""
    on = tuple(fit.state.effects)
    contest = score_test(context.model, context.sweeps, rest, context.executor, effects=(name,))
    sites = sorted(contest.at_sites(name), key=lambda c: -c.gain)[:SITES_REFITTED]
    few, reference = at_few_temperatures(context, rest)
    best = None
    for site in sites:
        start = started_from(reference, on, absent(context, contest, site))
        enough = -2.0 * best.log_evidence if best else float("inf")
        trial = fit_gap(few.model, few.sweeps, start, on, few.executor, enough=enough)
        best = trial if best is None or trial.log_evidence > best.log_evidence else best
    if best is None:
        return fit
    seen = best
    if few is not context:
        start = rest.state.corrected(context.sweeps, reference.state, best.state, few.sweeps)
        best = fit_gap(context.model, context.sweeps, start, on, context.executor)
    if best.log_evidence <= fit.log_evidence:
        return fit
    few.fits.keep(on, seen)
    context.fits.keep(on, best)
    return best
