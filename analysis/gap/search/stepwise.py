"""Which effects: stepwise, at most three, each accepted on the residual and not on its evidence alone."""

from collections.abc import Sequence
from dataclasses import dataclass

from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.search.drop_and_swap import challenge, dropped, standing
from analysis.gap.search.observability import Observability, observability
from analysis.gap.search.refit import Bench, Refit, absent, explained, refit
from analysis.gap.search.score_test import Candidate, Screening
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
    steps, path = _climb(bench, baseline, first, blind)
    fit, last = _supported(bench, baseline, path)
    if not _enough(bench, baseline, fit):
        more, pair = _pair(bench, baseline, first, blind, steps)
        steps += more
        if pair is not None:
            further, path = _climb(bench, pair, bench.screen(pair), blind)
            steps += further
            fit, last = _supported(bench, baseline, path)
    if _enough(bench, baseline, fit):
        fit, last, swaps = challenge(bench, baseline, fit, last, blind)
        steps += [Step((), tuple(refits), refits[0].effects, 0.0, False) for refits in swaps]
    without = {name: dropped(bench, baseline, fit, name) for name in fit.state.effects}
    rivals = {name: standing(bench, fit, last, name, blind) for name in fit.state.effects}
    return Found(baseline, fit, tuple(steps), first, last, seen, without, rivals)


def _enough(bench: Bench, baseline: GapFit, fit: GapFit) -> bool:
    return bench.agrees(fit) or explained(bench, baseline, fit) >= EXPLAINED


def _supported(
    bench: Bench, baseline: GapFit, path: Sequence[tuple[GapFit, Screening]]
) -> tuple[GapFit, Screening]:
    """Return how far along `path` names are supported: to its end if that reaches the noise.

    Else to where enough of the gap is explained: what follows nibbles at a rest that it does not explain.
    """
    fit, screening = path[-1]
    if bench.agrees(fit):
        return fit, screening
    return next((p for p in path if explained(bench, baseline, p[0]) >= EXPLAINED), path[-1])


def _climb(
    bench: Bench, fit: GapFit, screening: Screening, blind: Sequence[str]
) -> tuple[list[Step], list[tuple[GapFit, Screening]]]:
    """Add effects one by one while one is worth it; every twin on the way."""
    steps: list[Step] = []
    path = [(fit, screening)]
    while len(fit.state.effects) < MOST_EFFECTS:
        candidates = [c for c in screening.candidates() if c.effects[0] not in blind]
        worth = [c for c in candidates if c.gain >= bench.least_gain][:REFITTED]
        on = tuple(fit.state.effects)
        refits = refit(bench, fit, [((*on, *c.effects), absent(bench, screening, c)) for c in worth])
        best = next((r for r in refits if r.plausible and r.gain >= bench.least_gain), None)
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
        path.append((fit, screening))
    return steps, path


def _pair(
    bench: Bench, baseline: GapFit, first: Screening, blind: Sequence[str], steps: Sequence[Step]
) -> tuple[list[Step], GapFit | None]:
    """Two effects at once, where no single one explains enough and none after it did."""
    tried = {frozenset(r.effects) for step in steps for r in step.refits if r.fit is not None}
    singles = [c for c in first.candidates() if c.effects[0] not in blind]
    pairs = [c for c in first.pairs(singles) if c.gain >= bench.least_gain and frozenset(c.effects) not in tried]
    if not pairs:
        return [], None
    sets = [(c.effects, absent(bench, first, c)) for c in pairs[:PAIRS_REFITTED]]
    refits = refit(bench, baseline, sets)
    best = next((r for r in refits if r.plausible), None)
    if best is None or best.fit is None:
        return [Step(tuple(pairs), tuple(refits), (), 0.0, False)], None
    share = explained(bench, baseline, best.fit)
    enough = bench.agrees(best.fit) or share >= EXPLAINED
    step = Step(tuple(pairs), tuple(refits), best.effects, share, enough)
    return [step], best.fit if enough else None
