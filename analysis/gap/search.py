"""Which effects: stepwise, at most three, each accepted on the residual and not on its evidence alone."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from analysis.gap.effect_card import Values
from analysis.gap.fit import GapFit
from analysis.gap.observability import Observability, observability
from analysis.gap.refit import Bench, Refit, refit
from analysis.gap.screen import Candidate, Screening
from analysis.gap.thresholds import (
    CLASS_NATS,
    EXPLAINED,
    LEAST_GAIN,
    LEAST_SHARE,
    MOST_EFFECTS,
    PAIRS_REFITTED,
    REFITTED,
    SWAP_SHARE,
    SWAPS_REFITTED,
)


@dataclass(frozen=True)
class Step:
    """One step of the search.

    Attributes
    ----------
    candidates : tuple of Candidate
        All of them, screened, the most promising first.
    refits : tuple of Refit
        The best of them fitted in full, the best first.
    chosen : tuple of str
        Effects of the twin after the step.
    share : float
        Of the excess there was before the step.
    accepted : bool
    """

    candidates: tuple[Candidate, ...]
    refits: tuple[Refit, ...]
    chosen: tuple[str, ...]
    share: float
    accepted: bool


@dataclass(frozen=True)
class Found:
    """Where the search ended.

    Attributes
    ----------
    baseline, fit : GapFit
        Without effects, and with those found.
    steps : tuple of Step
    first, last : Screening
        At the baseline and at `fit`.
    seen : tuple of Observability
        Of every effect, at the baseline.
    without : mapping of str to GapFit
        The twin without one of the effects found, all else fitted again.
    rivals : mapping of str to mapping
        For each effect found: log evidence of every other in its place, relative to it, nats.
    """

    baseline: GapFit
    fit: GapFit
    steps: tuple[Step, ...]
    first: Screening
    last: Screening
    seen: tuple[Observability, ...]
    without: dict[str, GapFit]
    rivals: dict[str, dict[str, float]]

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the twin, in the order they were found."""
        return tuple(self.fit.state.effects)


def search(bench: Bench, baseline: GapFit) -> Found:
    """Find the effects that the twin of `baseline` lacks."""
    bench.report("screen", 0.0)
    first = bench.screen(baseline)
    seen = observability(first, bench.model.cards)
    blind = tuple(o.effect for o in seen if not o.observable)
    steps, fit, last = _climb(bench, baseline, first, blind)
    if not bench.agrees(fit) and explained(bench, baseline, fit) < EXPLAINED:
        more, pair, screening = _pair(bench, baseline, first, blind, steps)
        steps += more
        if pair is not None and screening is not None:
            further, fit, last = _climb(bench, pair, screening, blind)
            steps += further
    fit, last, without, rivals = _challenge(bench, baseline, fit, last, blind, steps)
    return Found(baseline, fit, tuple(steps), first, last, seen, without, rivals)


def explained(bench: Bench, before: GapFit, after: GapFit) -> float:
    """Share of the excess of `before` that `after` explains; 0 where there was none."""
    excess = bench.excess(before)
    return (before.total - after.total) / excess if excess > 0.0 else 0.0


def _climb(
    bench: Bench, fit: GapFit, screening: Screening, blind: Sequence[str]
) -> tuple[list[Step], GapFit, Screening]:
    """Add effects one by one while one is worth it."""
    steps: list[Step] = []
    while len(fit.state.effects) < MOST_EFFECTS:
        candidates = [c for c in screening.candidates() if c.effects[0] not in blind]
        worth = [c for c in candidates if c.gain >= LEAST_GAIN][:REFITTED]
        on = tuple(fit.state.effects)
        refits = refit(bench, fit, [((*on, *c.effects), start(bench, screening, c)) for c in worth])
        best = next((r for r in refits if r.plausible and r.gain >= LEAST_GAIN), None)
        if best is None or best.fit is None:
            steps.append(Step(tuple(candidates), tuple(refits), on, 0.0, False))
            break
        share = explained(bench, fit, best.fit)
        bystander = not bench.agrees(best.fit) and share < LEAST_SHARE
        steps.append(Step(tuple(candidates), tuple(refits), best.effects, share, not bystander))
        if bystander:
            break
        fit = best.fit
        bench.report("screen", 0.0)
        screening = bench.screen(fit)
    return steps, fit, screening


def _pair(
    bench: Bench, baseline: GapFit, first: Screening, blind: Sequence[str], steps: Sequence[Step]
) -> tuple[list[Step], GapFit | None, Screening | None]:
    """Two effects at once, where no single one explains enough and none after it did."""
    tried = {frozenset(r.effects) for step in steps for r in step.refits if r.fit is not None}
    singles = [c for c in first.candidates() if c.effects[0] not in blind]
    pairs = [c for c in first.pairs(singles) if c.gain >= LEAST_GAIN and frozenset(c.effects) not in tried]
    if not pairs:
        return [], None, None
    sets = [(c.effects, start(bench, first, c)) for c in pairs[:PAIRS_REFITTED]]
    refits = refit(bench, baseline, sets)
    best = next((r for r in refits if r.plausible), None)
    if best is None or best.fit is None:
        return [Step(tuple(pairs), tuple(refits), (), 0.0, False)], None, None
    share = explained(bench, baseline, best.fit)
    enough = bench.agrees(best.fit) or share >= EXPLAINED
    step = Step(tuple(pairs), tuple(refits), best.effects, share, enough)
    return [step], (best.fit if enough else None), (bench.screen(best.fit) if enough else None)


def start(bench: Bench, screening: Screening, candidate: Candidate) -> dict[str, Values]:
    """Values from which a candidate's fit starts: absent, its shapes at the best site.

    From there the first step takes laws, gain and effects along together; starting with the amplitudes of the
    screen and the laws of a twin without them would be further from the solution.
    """
    return {
        screening.columns[i].effect: bench.model.cards[screening.columns[i].effect].zero(
            screening.columns[i].shapes
        )
        for i in candidate.columns
    }


def _challenge(
    bench: Bench, baseline: GapFit, fit: GapFit, last: Screening, blind: Sequence[str], steps: list[Step]
) -> tuple[GapFit, Screening, dict[str, GapFit], dict[str, dict[str, float]]]:
    """Drop each effect, and put every other in its place, until none is better off."""
    for _ in range(MOST_EFFECTS):
        on = tuple(fit.state.effects)
        without = {name: _dropped(bench, baseline, fit, name) for name in on}
        idle = [name for name in on if fit.log_evidence - without[name].log_evidence < LEAST_GAIN]
        if idle:
            fit = max((without[name] for name in idle), key=lambda f: f.log_evidence)
            last = bench.screen(fit)
            continue
        rivals = {name: _rivals(last, name, blind) for name in on}
        better = _swapped(bench, fit, last, without, rivals, steps) if len(on) > 1 else None
        if better is None:
            return fit, last, without, rivals
        fit, last = better, bench.screen(better)
    on = tuple(fit.state.effects)
    without = {name: _dropped(bench, baseline, fit, name) for name in on}
    return fit, last, without, {name: _rivals(last, name, blind) for name in on}


def _dropped(bench: Bench, baseline: GapFit, fit: GapFit, name: str) -> GapFit:
    rest = {other: values for other, values in fit.state.effects.items() if other != name}
    return bench.fit(replace(baseline.state, effects=rest), tuple(rest)) if rest else baseline


def _rivals(last: Screening, name: str, blind: Sequence[str]) -> dict[str, float]:
    """Log evidence of other effects in the place of `name`, relative to it, to first order."""
    contest = {c.effects[0]: c.gain for c in last.without(name).candidates()}
    return {other: gain - contest[name] for other, gain in contest.items() if other != name and other not in blind}


def _swapped(
    bench: Bench,
    fit: GapFit,
    last: Screening,
    without: dict[str, GapFit],
    rivals: dict[str, dict[str, float]],
    steps: list[Step],
) -> GapFit | None:
    """Fit the rivals that come near, and return the best set that beats the present one; None if none does."""
    best = None
    for name, others in rivals.items():
        gain = fit.log_evidence - without[name].log_evidence
        near = [other for other, behind in others.items() if behind > -SWAP_SHARE * gain]
        near = sorted(near, key=lambda other: -others[other])[:SWAPS_REFITTED]
        if not near:
            continue
        contest = last.without(name)
        chosen = {c.effects[0]: start(bench, contest, c) for c in contest.candidates() if c.effects[0] in near}
        on = tuple(without[name].state.effects)
        refits = refit(bench, without[name], [((*on, other), chosen[other]) for other in near])
        steps.append(Step((), tuple(refits), refits[0].effects, 0.0, False))
        for trial in refits:
            if trial.fit is None or not trial.plausible:
                continue
            others[trial.effects[-1]] = trial.fit.log_evidence - fit.log_evidence
            if trial.fit.log_evidence > (fit.log_evidence + CLASS_NATS if best is None else best.log_evidence):
                best = trial.fit
    return best
