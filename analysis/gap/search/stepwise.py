"""Stepwise search: a few effects, each accepted by the remaining residual, not by evidence alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.search.candidate import Candidate
from analysis.gap.search.context import SearchContext, explained
from analysis.gap.search.drop_and_swap import Loss, drop_and_swap, lost, relative_evidence
from analysis.gap.search.observability import Observability, observability
from analysis.gap.search.refit import Refit, absent, at_few_temperatures, refit
from analysis.gap.search.relocation import best_image, relocated
from analysis.gap.search.score_test import ScoreTest
from analysis.gap.search.widened_search import widened_starts
from analysis.gap.thresholds import (
    EXPLAINED,
    LEAST_SHARE,
    MOST_EFFECTS,
    PAIRS_REFITTED,
    REFITTED,
)


@dataclass(frozen=True)
class Step:
    """One step of the search.

    Attributes
    ----------
    candidates : tuple of Candidate
        All candidates, largest predicted gain first.
    refits : tuple of Refit
        The best of them fitted in full, the best first.
    chosen : tuple of str
        Effects of the twin after the step.
    share : float
        Share of the excess before the step that it explains.
    accepted : bool
    """

    candidates: tuple[Candidate, ...]
    refits: tuple[Refit, ...]
    chosen: tuple[str, ...]
    share: float
    accepted: bool


@dataclass(frozen=True)
class SearchResult:
    """Result of the search.

    Attributes
    ----------
    baseline, fit : GapFit
        Without effects, and with those found.
    steps : tuple of Step
    first, last : ScoreTest
        At the baseline and at `fit`.
    seen : tuple of Observability
        Of every effect, at the baseline.
    losses : mapping of str to Loss
        What the twin loses without each of the effects found.
    rivals : mapping of str to mapping
        For each effect found: log evidence of every other effect instead of it, relative to it, nats.
    """

    baseline: GapFit
    fit: GapFit
    steps: tuple[Step, ...]
    first: ScoreTest
    last: ScoreTest
    seen: tuple[Observability, ...]
    losses: dict[str, Loss]
    rivals: dict[str, dict[str, float]]

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the twin, in the order they were found."""
        return tuple(self.fit.state.effects)


def stepwise_search(context: SearchContext, baseline: GapFit) -> SearchResult:
    """Find the effects that the twin of `baseline` lacks."""
    context.report("screen", 0.0)
    first = context.score_test(baseline)
    seen = observability(first, context.model.cards)
    blind = tuple(o.effect for o in seen if not o.observable)
    steps, path = _climb_from_far(context, baseline, first, blind)
    fit, last = _supported(context, baseline, path)
    if len(fit.state.effects) > 1 and not _enough(context, baseline, fit):
        moved = relocated(context, baseline, fit)
        if moved is not fit:
            fit, last = moved, context.score_test(moved)
    if not _enough(context, baseline, fit):
        more, pair = _pair(context, baseline, first, blind, steps)
        steps += more
        if pair is not None:
            further, path = _climb(context, pair, context.score_test(pair), blind)
            steps += further
            fit, last = _supported(context, baseline, path)
    while _enough(context, baseline, fit):
        before = fit
        fit, last, swaps = drop_and_swap(context, baseline, fit, last, blind)
        steps += [Step((), tuple(refits), refits[0].effects, 0.0, False) for refits in swaps if refits]
        if fit is before or context.agrees(fit):
            break
        # an effect that stood for others is gone: what is left may have a name
        further, path = _climb(context, fit, last, blind)
        steps += further
        fit, last = path[-1]
        if len(path) == 1:
            break
    losses = {name: lost(context, baseline, fit, name) for name in fit.state.effects}
    rivals = {name: relative_evidence(context, fit, last, name, blind) for name in fit.state.effects}
    return SearchResult(baseline, fit, tuple(steps), first, last, seen, losses, rivals)


def _enough(context: SearchContext, baseline: GapFit, fit: GapFit) -> bool:
    return context.agrees(fit) or explained(context, baseline, fit) >= EXPLAINED


def _supported(
    context: SearchContext, baseline: GapFit, path: Sequence[tuple[GapFit, ScoreTest]]
) -> tuple[GapFit, ScoreTest]:
    """Return the point on `path` up to which effects are supported: its end if that reaches the noise.

    Else the first point that explains enough of the gap: later effects reduce the rest without explaining it.
    """
    fit, screening = path[-1]
    if context.agrees(fit):
        return fit, screening
    return next((p for p in path if explained(context, baseline, p[0]) >= EXPLAINED), path[-1])


def _climb_from_far(
    context: SearchContext, baseline: GapFit, first: ScoreTest, blind: Sequence[str]
) -> tuple[list[Step], list[tuple[GapFit, ScoreTest]]]:
    """Do what `_climb` does; from far, at a few temperatures until not much more than noise is left.

    Where a fit leaves a hundred sigma, a few temperatures tell the next effect as well as all of them, and what
    it comes to, but for the laws, is only what the next fit starts from.
    """
    few, begun = at_few_temperatures(context, baseline)
    if few is context or not context.far(baseline):
        return _climb(context, baseline, first, blind)
    ratio = context.sweeps.numbers / few.sweeps.numbers
    steps, path = _climb(few, begun, first.scaled(1.0 / ratio), blind, to_noise=False)
    steps = [replace(step, refits=tuple(r.estimate(ratio) for r in step.refits)) for step in steps]

    def at_all(fit: GapFit) -> tuple[GapFit, ScoreTest]:
        start = baseline.state.corrected(context.sweeps, begun.state, fit.state, few.sweeps)
        full = context.fit(start, tuple(fit.state.effects))
        return full, context.score_test(full, for_rivals=context.agrees(full))

    reached = path[-1][0]
    if not reached.state.effects:
        return steps, [(baseline, first)]
    on = [at_all(reached)]
    if not context.leaves_more(on[0][0]):
        more, on = _climb(context, *on[0], blind)
        steps += more
    supported = _supported(few, begun, path)[0]
    if supported is not reached and not context.agrees(on[-1][0]):
        on = [at_all(supported)]
    return steps, [(baseline, first), *on]


def _climb(
    context: SearchContext, fit: GapFit, screening: ScoreTest, blind: Sequence[str], *, to_noise: bool = True
) -> tuple[list[Step], list[tuple[GapFit, ScoreTest]]]:
    """Add effects one by one while one is accepted; return the steps and the twin after each."""
    steps: list[Step] = []
    path = [(fit, screening)]
    while len(fit.state.effects) < MOST_EFFECTS:
        on = tuple(fit.state.effects)
        candidates = [c for c in screening.candidates() if c.effects[0] not in blind]
        wide = [] if _foreseen(context, fit, candidates) else widened_starts(context, fit, blind)
        if wide:
            candidates = [one.candidate for one in wide]
            starts = {one.effects: one.state for one in wide}
            refits = refit(context, fit, [(names, {}) for names in starts], starts)
        else:
            worth = [c for c in candidates if c.gain >= context.least_gain()][:REFITTED]
            refits = refit(context, fit, [((*on, *c.effects), absent(context, screening, c)) for c in worth])
        best = next((r for r in refits if _is_worth(context, fit, r)), None)
        if best is None or best.fit is None:
            steps.append(Step(tuple(candidates), tuple(refits), on, 0.0, False))
            break
        placed = best_image(context, best.fit, best.effects[-1])
        share = explained(context, fit, placed)
        unsupported = not context.agrees(placed) and share < LEAST_SHARE
        steps.append(Step(tuple(candidates), tuple(refits), best.effects, share, not unsupported))
        if unsupported:
            break
        fit = placed
        if not (to_noise or context.leaves_more(fit)):
            path.append((fit, screening))  # screened anew where the climb goes on, at all temperatures
            break
        context.report("screen", 0.0)
        screening = context.score_test(fit)
        path.append((fit, screening))
    return steps, path


def _is_worth(context: SearchContext, before: GapFit, found: Refit) -> bool:
    """Whether an effect gains enough beside those before it, whose form may cause a part of the gain."""
    if found.fit is None or not found.plausible:
        return False
    return found.gain >= context.least_gain(found.fit) + context.form_gain(before, found.effects[-1])


def _foreseen(context: SearchContext, fit: GapFit, candidates: Sequence[Candidate]) -> bool:
    """Whether one candidate explains enough of the gap to first order already: fits then begin near enough."""
    return bool(candidates) and 2.0 * candidates[0].gain >= EXPLAINED * context.excess(fit)


def _pair(
    context: SearchContext, baseline: GapFit, first: ScoreTest, blind: Sequence[str], steps: Sequence[Step]
) -> tuple[list[Step], GapFit | None]:
    """Add two effects at once, if neither one effect nor effects added one by one explain enough."""
    tried = {frozenset(r.effects) for step in steps for r in step.refits if r.fit is not None}
    singles = [c for c in first.candidates() if c.effects[0] not in blind]
    pairs = [
        c for c in first.pairs(singles) if c.gain >= context.least_gain() and frozenset(c.effects) not in tried
    ]
    if not pairs:
        return [], None
    sets = [(c.effects, absent(context, first, c)) for c in pairs[:PAIRS_REFITTED]]
    refits = refit(context, baseline, sets)
    best = next((r for r in refits if r.plausible), None)
    if best is None or best.fit is None:
        return [Step(tuple(pairs), tuple(refits), (), 0.0, False)], None
    share = explained(context, baseline, best.fit)
    enough = context.agrees(best.fit) or share >= EXPLAINED
    step = Step(tuple(pairs), tuple(refits), best.effects, share, enough)
    return [step], best.fit if enough else None
