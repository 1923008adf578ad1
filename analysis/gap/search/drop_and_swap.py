"""Drop and swap: each effect found is removed, and replaced by each other effect, and the fits are compared."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

from analysis.effect_card import Values
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.search.confidence import unknown_evidence
from analysis.gap.search.context import SearchContext
from analysis.gap.search.refit import Refit, absent, first_order, refit
from analysis.gap.search.score_test import Candidate, ScoreTest
from analysis.gap.thresholds import BEHIND, CLASS_NATS, LIKELIER, MOST_EFFECTS, SWAP_SHARE, SWAPS_REFITTED


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
        losses = {name: lost(context, baseline, fit, name) for name in on}
        idle = [name for name in on if losses[name].gain < context.least_gain(fit)]
        if idle:
            fit = max((dropped(context, baseline, fit, name) for name in idle), key=lambda f: f.log_evidence)
            last = context.score_test(fit)
            continue
        better = _swapped(context, baseline, fit, last, losses, blind, trials)
        if better is None:
            break
        fit, last = better, context.score_test(better)
    return fit, last, trials


def dropped(context: SearchContext, baseline: GapFit, fit: GapFit, name: str, *, roughly: bool = False) -> GapFit:
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
    roughly : bool
        As in `SearchContext.fit`.

    Returns
    -------
    GapFit
    """
    return context.fit_without(fit.state, name, roughly=roughly) if len(fit.state.effects) > 1 else baseline


@dataclass(frozen=True)
class Loss:
    """What a twin loses without one of its effects.

    Attributes
    ----------
    gain : float
        Log evidence of the twin with the effect over that without it, all else fitted again, nats.
    unknown : float
        Log evidence, without the effect, of an unknown discrepancy over noise, nats.
    """

    gain: float
    unknown: float

    @classmethod
    def between(cls, context: SearchContext, fit: GapFit, without: GapFit, ratio: float = 1.0) -> Self:
        """Compare two fits of the same sweeps, for `ratio` times as many."""
        unknown = unknown_evidence(context.sweeps, without.residual, without.state)
        return cls(ratio * (fit.log_evidence - without.log_evidence), ratio * unknown)


def lost(context: SearchContext, baseline: GapFit, fit: GapFit, name: str) -> Loss:
    """Say what a twin loses without one of its effects; from a few temperatures where these leave no doubt.

    Parameters are those of `dropped`.
    """
    far = _Few.without(context, baseline, fit, name)
    if far is None:
        return Loss.between(context, fit, dropped(context, baseline, fit, name))
    return Loss.between(far.context, far.whole, far.rest, far.ratio)


@dataclass(frozen=True)
class _Few:
    """Fits to a few temperatures with all effects and without one, which leave no doubt that it is needed."""

    context: SearchContext
    whole: GapFit
    rest: GapFit
    ratio: float
    """Of the numbers of all sweeps to those of the few."""

    @classmethod
    def without(cls, context: SearchContext, baseline: GapFit, fit: GapFit, name: str) -> "_Few | None":
        """Leave one effect out; None where all sweeps are to be asked."""
        few, _ = context.at_few_temperatures(fit.state)
        if len(fit.state.effects) == 1 or few is context or not context.far(baseline):
            return None
        whole = few.fit(fit.state.restricted(context.sweeps, few.sweeps), tuple(fit.state.effects))
        there = few.fit_without(whole.state, name, roughly=True)
        if not few.leaves_more(there):
            return None
        return cls(few, whole, there, context.sweeps.numbers / few.sweeps.numbers)

    @property
    def gain(self) -> float:
        """Log evidence of the effect, nats."""
        return self.whole.log_evidence - self.rest.log_evidence

    def exchanged(self, name: str, added: Mapping[str, Values]) -> Refit:
        """Fit another effect in the place of one, from where laws and declared quantities stand with all of them.

        From where they stand without the effect, far off, a fit does not find its way.
        """
        rest = self.whole.state.without(name).promoted(self.context.model.cards)
        effects, most = {**rest.effects, **added}, BEHIND * self.whole.total
        names, start = tuple(effects), self.whole.state.with_effects(effects)
        fit = self.context.attempt(start, names, enough=most, enough_held=most)
        return Refit.of(self.context, self.rest, names, fit)


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
        if other == name or other in blind or context.model.cards[other].after == name:
            continue
        known = context.fits.known(rest | {other})
        relative[other] = known.log_evidence - fit.log_evidence if known else gain - contest[name]
    return relative


def _swapped(
    context: SearchContext,
    baseline: GapFit,
    fit: GapFit,
    last: ScoreTest,
    losses: Mapping[str, Loss],
    blind: Sequence[str],
    trials: list[list[Refit]],
) -> GapFit | None:
    """Fit the close alternatives; return the best set if it is better than the present one, else None."""
    best, enough = None, fit.log_evidence + LIKELIER * context.overstated(fit)
    for name in fit.state.effects:
        contest = last.without(name)
        rest = tuple(one for one in fit.state.effects if one != name)
        relative = relative_evidence(context, fit, last, name, blind)
        begin = _contenders(context, contest, name, rest, relative, SWAP_SHARE * losses[name].gain)
        near = list(begin)
        aside = {(*rest, other): context.set_aside((*rest, other), enough) for other in near}
        far = _Few.without(context, baseline, fit, name) if near else None
        if far is not None:
            tried = [far.exchanged(name, first_order(context, contest, begin[other])) for other in near]
            trials.append([trial.estimate(far.ratio) for trial in tried])
            near = [trial.effects[-1] for trial in tried if trial.gain > far.gain]
        if near:
            without = dropped(context, baseline, fit, name, roughly=far is not None)
            on = tuple(without.state.effects)
            sets = [((*on, other), absent(context, contest, begin[other])) for other in near]
            refits = refit(context, without, sets)
            trials.append(refits)
            for trial in refits:
                if trial.fit is not None and trial.plausible and trial.fit.log_evidence > enough:
                    best, enough = trial.fit, trial.fit.log_evidence
        for names, before in aside.items():
            now = context.fits.known(names)
            if before is not None and (now is None or now.log_evidence < before.log_evidence):
                context.fits.keep(names, before)
    return best


def _contenders(
    context: SearchContext,
    contest: ScoreTest,
    name: str,
    rest: tuple[str, ...],
    relative: Mapping[str, float],
    behind: float,
) -> dict[str, Candidate]:
    """Close alternatives to an effect that were not fitted, or not from the place where it stands; the best first.

    Of several sites a fit begins at the best to first order without the effect: where that is far from the place
    of what is missing, it ends at another one.
    """
    offered = {c.effects[0]: c for c in contest.candidates()}
    near = {}
    for other, nats in relative.items():
        one, own_sites = offered[other], len(context.model.cards[other].sites)
        if context.fits.known((*rest, other)) is not None and nats <= 0.0:
            promised = one.gain - offered[name].gain
            if contest.columns[one.columns[0]].site < own_sites or promised < nats + CLASS_NATS:
                continue
            nats = promised
        if nats > -behind:
            near[other] = nats
    best = sorted(near, key=lambda other: -near[other])[:SWAPS_REFITTED]
    return {other: offered[other] for other in best}
