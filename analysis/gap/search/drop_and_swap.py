"""Drop and swap: each effect found is removed, and replaced by each other effect, and the fits are compared."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.search.context import SearchContext
from analysis.gap.search.refit import Refit, absent, at_few_temperatures, refit, started_from
from analysis.gap.search.score_test import ScoreTest
from analysis.gap.thresholds import CLASS_NATS, MOST_EFFECTS, SWAP_SHARE, SWAPS_REFITTED


def drop_and_swap(
    context: SearchContext, baseline: GapFit, fit: GapFit, last: ScoreTest, blind: Sequence[str]
) -> tuple[GapFit, ScoreTest, list[list[Refit]]]:
    """Remove each effect of a fit, and replace it by every other effect, until no change improves the fit.

    Returns the fit and its screening at the end, and the rivals that were fitted.

    Parameters
    ----------
    context : SearchContext
    baseline : GapFit
        Without effects.
    fit : GapFit
        With the effects found.
    last : ScoreTest
        At `fit`.
    blind : sequence of str
        Effects that are not observable; they are not tried.

    Returns
    -------
    fit : GapFit
        At the end.
    last : ScoreTest
        There.
    trials : list of list of Refit
        Rivals that were fitted.
    """
    trials: list[list[Refit]] = []
    for _ in range(MOST_EFFECTS):
        on = tuple(fit.state.effects)
        without = {name: dropped(context, baseline, fit, name) for name in on}
        idle = [name for name in on if fit.log_evidence - without[name].log_evidence < context.least_gain(fit)]
        if idle:
            fit = max((without[name] for name in idle), key=lambda f: f.log_evidence)
            last = context.score_test(fit)
            continue
        # a single effect was compared with the others when it was chosen
        better = _swapped(context, fit, last, without, blind, trials) if len(on) > 1 else None
        if better is None:
            break
        fit, last = better, context.score_test(better)
    return fit, last, trials


def dropped(context: SearchContext, baseline: GapFit, fit: GapFit, name: str) -> GapFit:
    """Fit the twin without one of its effects.

    Parameters
    ----------
    context : SearchContext
    baseline : GapFit
        Without effects.
    fit : GapFit
        With all effects.
    name : str
        The effect left out.

    Returns
    -------
    GapFit
    """
    rest = {other: values for other, values in fit.state.effects.items() if other != name}
    if not rest:
        return baseline
    names, start = tuple(rest), replace(baseline.state, effects=rest)
    few, begun = at_few_temperatures(context, baseline)
    if few is context or not context.far(baseline):
        return context.fit(start, names)
    # where a few temperatures tell that the effect is no matter of nats, a rough fit to all is enough
    there = few.fit(started_from(begun, names, rest), names)
    start = baseline.state.corrected(context.sweeps, begun.state, there.state, few.sweeps)
    return context.fit(start, names, roughly=few.leaves_more(there))


def relative_evidence(
    context: SearchContext, fit: GapFit, last: ScoreTest, name: str, blind: Sequence[str]
) -> dict[str, float]:
    """Log evidence of every other effect instead of one effect, relative to it.

    To first order at `fit`, or of the full fit where there was one.

    Parameters
    ----------
    context : SearchContext
    fit : GapFit
        With the effect.
    last : ScoreTest
        At `fit`.
    name : str
        The effect.
    blind : sequence of str
        Effects that are not observable; they are left out.

    Returns
    -------
    dict of str to float
        Nats; from the full fit where there was one, else to first order at `fit`.
    """
    contest = {c.effects[0]: c.gain for c in last.without(name).candidates()}
    rest = frozenset(fit.state.effects) - {name}
    relative = {}
    for other, gain in contest.items():
        if other == name or other in blind:
            continue
        known = context.fits.known(rest | {other})
        relative[other] = known.log_evidence - fit.log_evidence if known else gain - contest[name]
    return relative


def _swapped(
    context: SearchContext,
    fit: GapFit,
    last: ScoreTest,
    without: Mapping[str, GapFit],
    blind: Sequence[str],
    trials: list[list[Refit]],
) -> GapFit | None:
    """Fit the close alternatives; return the best set if it is better than the present one, else None."""
    best = None
    for name in fit.state.effects:
        behind = relative_evidence(context, fit, last, name, blind)
        gain = fit.log_evidence - without[name].log_evidence
        near = [other for other, relative in behind.items() if relative > -SWAP_SHARE * gain]
        near = sorted(near, key=lambda other: -behind[other])[:SWAPS_REFITTED]
        if not near:
            continue
        contest = last.without(name)
        begin = {c.effects[0]: absent(context, contest, c) for c in contest.candidates() if c.effects[0] in near}
        on = tuple(without[name].state.effects)
        refits = refit(context, without[name], [((*on, other), begin[other]) for other in near])
        trials.append(refits)
        for trial in refits:
            if trial.fit is None or not trial.plausible:
                continue
            least = fit.log_evidence + CLASS_NATS * context.overstated(fit) if best is None else best.log_evidence
            if trial.fit.log_evidence > least:
                best = trial.fit
    return best
