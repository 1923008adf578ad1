"""Stepwise search: a few effects, each accepted by the remaining residual, not by evidence alone.

An effect may move resonances by more than their widths. Then derivatives at the present twin tell neither how
large it is nor which one it is, and fits end beside the solution. Over wider resonances
(`analysis.gap.data.sweeps`) they do, and each candidate is fitted to these first, with declared quantities as
declared, because they would only follow what is missing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.effect_card import EffectCard, Values
from analysis.gap.data.sweeps import widened
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.sites import away, places
from analysis.gap.fitting.state import GapState
from analysis.gap.search.context import SearchContext, explained
from analysis.gap.search.drop_and_swap import Loss, drop_and_swap, dropped, lost, relative_evidence
from analysis.gap.search.observability import Observability, observability
from analysis.gap.search.refit import Refit, Step, absent, at_few_temperatures, refit, started_from
from analysis.gap.search.score_test import Candidate, ScoreTest, score_test
from analysis.gap.thresholds import (
    BEHIND,
    EXPLAINED,
    LEAST_SHARE,
    LEAST_WIDE_SHARE,
    LEAVES_NOISE,
    MOST_EFFECTS,
    MOVED_ELSEWHERE,
    NEAR_MARGIN,
    PAIRS_REFITTED,
    PREDICTION_MARGIN,
    REFITTED,
    SITES_REFITTED,
    WIDENED,
    WIDENED_ERROR,
)


@dataclass(frozen=True)
class WidenedStart:
    """A candidate, and where its fit begins.

    Attributes
    ----------
    candidate : Candidate
        As screened over wider resonances.
    effects : tuple of str
        Those that are on, and the candidate's.
    state : GapState
        That fits wider resonances best.
    left : float
        Objective there.
    """

    candidate: Candidate
    effects: tuple[str, ...]
    state: GapState
    left: float


NEIGHBOUR = 1.5
"""Distances between neighbouring sites up to which an image is on the plate: the sites fill the plate."""


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
    seen = observability(first, context.model.cards, context.sweeps.level_count)
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
        wide = None if _foreseen(context, fit, candidates) else widened_starts(context, fit, blind)
        if wide is not None:
            candidates = [one.candidate for one in wide] or candidates
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
    """Add two effects at once, if neither one effect nor effects added one by one explain enough.

    None where no single one takes a share far from the data: either of a pair would.
    """
    if context.far(baseline) and not steps[0].refits:
        return [], None
    tried = {frozenset(r.effects) for step in steps for r in step.refits if r.fit is not None}
    singles = [c for c in first.candidates() if c.effects[0] not in blind]
    needed = 0.5 * EXPLAINED * max(context.excess(baseline) - context.allowed(baseline), 0.0)
    # far from the data first order tells nothing
    promise = 0.0 if context.far(baseline) else needed / PREDICTION_MARGIN
    least = max(context.least_gain(), promise)
    pairs = [c for c in first.pairs(singles) if c.gain >= least and frozenset(c.effects) not in tried]
    if not pairs:
        return [], None
    sets = [(c.effects, absent(context, first, c)) for c in pairs[:PAIRS_REFITTED]]
    refits = refit(context, baseline, sets, needed=needed)
    best = next((r for r in refits if r.plausible), None)
    if best is None or best.fit is None:
        return [Step(tuple(pairs), tuple(refits), (), 0.0, False)], None
    share = explained(context, baseline, best.fit)
    enough = context.agrees(best.fit) or share >= EXPLAINED
    step = Step(tuple(pairs), tuple(refits), best.effects, share, enough)
    return [step], best.fit if enough else None


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
    """Return the best of `fit` and of fits from other sites of an effect that `rest` lacks.

    Without the first of two alike, the second takes its name: then the second is what `rest` lacks. What is only
    beside the effect is missing, too.
    """
    on = tuple(fit.state.effects)
    missing = [one for one in on if one not in rest.state.effects]
    name = name if name in missing else missing[0]
    beside = {one: fit.state.effects[one] for one in missing}
    contest = score_test(context.model, context.sweeps, rest, context.executor, effects=(name,))
    sites = sorted(contest.at_sites(name), key=lambda c: -c.gain)[:SITES_REFITTED]
    few, reference = at_few_temperatures(context, rest)
    best = None
    for site in sites:
        start = started_from(reference, on, {**beside, **absent(context, contest, site)})
        enough = -2.0 * best.log_evidence if best else float("inf")
        trial = few.fit_from(start, on, enough=enough)
        best = trial if best is None or trial.log_evidence > best.log_evidence else best
    if best is None:
        return fit
    seen = best
    if few is not context:
        start = rest.state.corrected(context.sweeps, reference.state, best.state, few.sweeps)
        best = context.fit_from(start, on)
    if best.log_evidence <= fit.log_evidence:
        return fit
    few.fits.keep(on, seen)
    context.fits.keep(on, best)
    return best


def best_image(context: SearchContext, fit: GapFit, name: str) -> GapFit:
    """Fit an effect with a place again from the mirror images of that place, and return the best fit.

    On a symmetrical plate whatever stands at an image of a place shifts every resonance as much as there. Far
    from the data, where resonances are shifted by more than their widths, the screen sees little else, and a fit
    settles at the nearest image, although the shapes contradict it. One that comes down to the noise may do so,
    too: a spring was found 73 mm beside its place, at the image, with a standard deviation of 3 mm.

    Parameters
    ----------
    context : SearchContext
    fit : GapFit
        With the effect.
    name : str
        Of the effect.

    Returns
    -------
    GapFit
        `fit` where no image is better.
    """
    on = tuple(fit.state.effects)
    images = list(_images(context.model.cards[name], fit.state.effects[name]))
    if not images:
        return fit
    few, reference = at_few_temperatures(context, fit)
    best = reference
    for place in images:
        start = replace(reference.state, effects={**reference.state.effects, name: place})
        enough = -2.0 * best.log_evidence
        try:
            trial = few.fit_from(start, on, target=few.settled, enough=enough, margin=NEAR_MARGIN)
        except ValueError:  # an image off the plate, in a notch of its outline
            continue
        best = trial if trial.settled and trial.log_evidence > best.log_evidence else best
    if best is reference:
        return fit
    few.fits.keep(on, best)
    if few is context:
        return best
    start = fit.state.corrected(context.sweeps, reference.state, best.state, few.sweeps)
    full = context.fit_from(start, on, target=context.settled)
    if full.log_evidence <= fit.log_evidence:
        return fit
    context.fits.keep(on, full)
    return full


def _images(card: EffectCard, values: Values) -> Iterator[dict[str, float]]:
    """Yield an effect's values with its place reflected in the middle lines of the plate."""
    if len(card.sites) < 2 or not card.placed:
        return
    sites = places(card.sites)
    x, y = sites.min(axis=0) + sites.max(axis=0) - np.array([values["x"], values["y"]])
    for image in ({"x": float(x)}, {"y": float(y)}, {"x": float(x), "y": float(y)}):
        turned = {**values, **image}
        if away(sites, turned) <= NEIGHBOUR:
            yield turned


def widened_starts(context: SearchContext, fit: GapFit, blind: Sequence[str]) -> list[WidenedStart] | None:
    """Return where fits of the best candidates begin, the best first; an empty list where none takes a share.

    None near the data, where derivatives there tell more, and at part of the lines, which wider resonances would
    not keep apart from the others.

    Parameters
    ----------
    context : SearchContext
        Of the sweeps of `fit`.
    fit : GapFit
        Which candidates are added to.
    blind : sequence of str
        Effects that these data do not show.
    """
    if not context.far(fit) or not context.few or not context.sweeps.rows.all():
        return None
    wide = context.of(widened(context.sweeps, WIDENED, WIDENED_ERROR))
    on = tuple(fit.state.effects)
    held = fit.state if fit.held is None else fit.held.state
    begun = _fitted(wide, replace(held, declared={}).with_tolerances(context.model.tolerance_cards), on)
    screening = wide.score_test(begun)
    worth = [c for c in screening.candidates() if c.effects[0] not in blind and c.gain > 0.0][:REFITTED]
    most = (1.0 - LEAST_WIDE_SHARE) * begun.objective

    def begin(candidate: Candidate, enough: float) -> WidenedStart:
        names = (*on, *candidate.effects)
        start = begun.state.with_effects({**begun.state.effects, **absent(context, screening, candidate)})
        there = _fitted(wide, start, names, enough)
        return WidenedStart(candidate, names, there.state, there.objective)

    found: list[WidenedStart] = []
    for place, candidate in enumerate(worth):
        found.append(begin(candidate, min(most, BEHIND * min((one.left for one in found), default=np.inf))))
        context.report("wider resonances", (place + 1) / len(worth))
    found.sort(key=lambda one: one.left)
    enough = LEAVES_NOISE * wide.sweeps.numbers
    for place, one in enumerate(found[:MOVED_ELSEWHERE]):
        sites = sorted(screening.at_sites(one.candidate.effects[0]), key=lambda c: -c.gain)[:SITES_REFITTED]
        for candidate in sites[1:]:
            if min(known.left for known in found) > enough:
                there = begin(candidate, min(most, found[place].left))
                found[place] = min(found[place], there, key=lambda known: known.left)
    found.sort(key=lambda one: one.left)
    return [one for one in found if one.left <= min(BEHIND * found[0].left, most)]


def _fitted(wide: SearchContext, start: GapState, effects: Sequence[str], enough: float = np.inf) -> GapFit:
    return fit_gap(
        wide.model,
        wide.sweeps,
        start,
        effects,
        wide.executor,
        target=wide.settled,
        declared_free=False,
        enough=enough,
    )
