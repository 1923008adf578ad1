"""Search for effects beside a discrepancy: what a twin lacks, where no twin comes down to the noise.

Each set of effects is fitted beside the scatter of resonances that it leaves itself. An effect that is right makes
the scatter of many modes smaller at once: its evidence is about the number of modes times the logarithm of the
scatter before over that after. So no residual has to be noise for a name to be sure.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from analysis.arrays import Complex, Real
from analysis.effect_card import Values
from analysis.gap.data.sweeps import LineWeights
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit, Uncertainty
from analysis.gap.fitting.linearised_sweeps import LinearisedSweeps
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import SchurComplement, schur_complement
from analysis.gap.fitting.state import GapState
from analysis.gap.imperfect.discrepancy import Discrepancy, DiscrepancyShape
from analysis.gap.search.context import SearchContext
from analysis.gap.search.observability import observability
from analysis.gap.search.refit import absent
from analysis.gap.search.score_test import Candidate, ScoreTest, score_test
from analysis.gap.thresholds import CLASS_NATS, LEAST_GAIN
from analysis.twin_model import Tangent

MOST_EFFECTS = 6
"""Largest number of effects beside a discrepancy: its evidence, unlike that of noise, grows by chance only."""
TRIED = 8
"""Number of candidates of a score test that are tried on the linearised campaign, each with its own scatter."""
FITTED = 2
"""Number of them that are fitted with the twin itself."""
FAR = 0.5
"""Scatter of frequencies, in half widths of a resonance, above which sets are fitted with the twin itself,
whatever they gain to first order."""
ROUNDS, SETTLED = 5, 0.1
"""Largest number of times that the scatter is estimated anew, and its relative change at which it is not."""
TWIN_ROUNDS = 2
"""The same for fits of the twin itself, which begin where first order has settled."""


@dataclass(frozen=True)
class Imperfect:
    """A twin with effects, and the discrepancy that it leaves.

    Attributes
    ----------
    context : SearchContext
        Its sweeps are weighted by the discrepancy.
    fit : GapFit
        To these.
    shape : DiscrepancyShape
    scatter : Discrepancy
    tries : int
        Number of places at which its last effect was tried, where it is held at the best of them: the logarithm
        is subtracted from the evidence. Where the place is fitted, the evidence contains its uncertainty.
    """

    context: SearchContext
    fit: GapFit
    shape: DiscrepancyShape
    scatter: Discrepancy
    tries: int = 1

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the twin, in the order they were found."""
        return tuple(self.fit.state.effects)

    @property
    def far(self) -> bool:
        """Whether resonances are off by so much of their half width that they are not where first order ends."""
        half = 0.5 * float(np.exp(self.fit.state.laws[:, 2].mean()))
        return self.scatter.frequency > FAR * half

    @property
    def evidence(self) -> float:
        """Log evidence of twin and discrepancy, up to a constant common to all sets of effects."""
        found = self.fit.log_evidence - self.shape.penalty(self.context.sweeps, self.scatter)
        return found - float(np.log(self.tries))

    def relative(self, gain: float) -> float:
        """Turn a log evidence at this scatter into one with a scatter of its own: Student's, not Gauss', nats."""
        count = self.shape.independent(self.context.sweeps, self.scatter)
        return float(np.copysign(0.5 * count * np.log1p(2.0 * abs(gain) / count), gain))


@dataclass(frozen=True)
class ImperfectResult:
    """Result of a search beside a discrepancy.

    Attributes
    ----------
    baseline, final : Imperfect
        Without effects, and with those found.
    last : ScoreTest
        At `final`.
    gains : mapping of str to float
        Log evidence of each effect found over the best twin without it, nats.
    rivals : mapping of str to mapping
        For each effect found: log evidence of every other effect instead of it, relative to it, nats.
    """

    baseline: Imperfect
    final: Imperfect
    last: ScoreTest
    gains: dict[str, float]
    rivals: dict[str, dict[str, float]]


class ImperfectSearch:
    """Stepwise search in which each set of effects is judged beside the discrepancy that it leaves.

    Candidates are compared on the campaign linearised at the present twin, with all candidates' derivatives; only
    the best is fitted with the twin itself.

    Attributes
    ----------
    plain : SearchContext
        Unweighted.
    """

    def __init__(self, plain: SearchContext, baseline: GapFit, known: GapFit | None = None) -> None:
        """Fit the twin without effects beside what it leaves, and `known`, with effects, from which to go on."""
        self.plain = plain
        self._baseline = settled_from_first_order(plain, baseline)
        self._begun = self._baseline if known is None else settled_from_first_order(plain, known)

    def run(self) -> ImperfectResult:
        """Add effects while there is evidence for one more, then leave out and exchange each."""
        at = self._begun
        near = _Neighbours.of(self.plain, at)
        blind = near.blind()
        while len(at.effects) < MOST_EFFECTS:
            better = self._better(at, near.extended(blind))
            if better is None:
                break
            at, near = better, _Neighbours.of(self.plain, better)
        for _ in range(MOST_EFFECTS):
            gains = near.gains(self._baseline)
            idle = [name for name, gain in gains.items() if gain < LEAST_GAIN]
            if idle:
                dropped = min(idle, key=gains.__getitem__)
                at = self._fitted(at, near.state_without(dropped), at)
                near = _Neighbours.of(self.plain, at)
                continue
            rivals, swapped = near.contested(blind)
            better = self._better(at, swapped, CLASS_NATS)
            if better is None:
                return ImperfectResult(self._baseline, at, near.screening, gains, rivals)
            at, near = better, _Neighbours.of(self.plain, better)
        gains, (rivals, _) = near.gains(self._baseline), near.contested(blind)
        return ImperfectResult(self._baseline, at, near.screening, gains, rivals)

    def _better(self, at: Imperfect, tried: Sequence[Imperfect], least: float = LEAST_GAIN) -> Imperfect | None:
        """Fit the most promising sets with the twin, until one is better by `least` nats; None if none is."""
        best = sorted(tried, key=lambda t: -t.evidence)
        promising = [t for t in best if t.evidence - at.evidence > 0.5 * least]
        if at.far:  # first order tells little
            promising = best
        for trial in promising[:FITTED]:
            found = self._fitted(at, trial.fit.state, trial)
            if found.fit.plausible and found.evidence - at.evidence >= least:
                return found
        return None

    def _fitted(self, at: Imperfect, state: GapState, near: Imperfect) -> Imperfect:
        """Fit a set of effects with the twin itself, from where the campaign linearised at `at` leaves it."""
        context = self.plain.weighted(near.context.sweeps.weights)
        state = state.promoted(context.model.cards)
        names = tuple(state.effects)
        try:
            fit = context.fit(state, names)
        except ValueError:  # first order went beyond what the twin is certified for: begin where it is absent
            known, cards = at.fit.state.effects, context.model.cards
            values = {name: known.get(name, cards[name].zero(state.effects[name])) for name in names}
            fit = context.fit(at.fit.state.with_effects(values), names)
        residual = context.sweeps.weights.undone(fit.residual)
        return settled(self.plain, fit.state, fit.predicted, residual, fit.determined, rounds=TWIN_ROUNDS - 1)


@dataclass(frozen=True)
class _Neighbours:
    """Sets of effects near that of a twin, on the campaign linearised there."""

    at: Imperfect
    plain: SearchContext
    screening: ScoreTest

    @classmethod
    def of(cls, plain: SearchContext, at: Imperfect) -> "_Neighbours":
        plain.report("beside a discrepancy", min(0.2 * len(at.effects), 0.8))
        linear = LinearisedSweeps.of(plain.model, plain.sweeps, at.fit.state, plain.executor)
        here = plain.seen_by(linear)
        return cls(at, here, _screened(here.weighted(at.context.sweeps.weights), at.fit))

    def blind(self) -> set[str]:
        """Tell which effects the campaign does not show beside noise; whether beside more, evidence tells."""
        seen = observability(_screened(self.plain, self.at.fit), self.plain.model.cards)
        return {one.effect for one in seen if not one.observable}

    def extended(self, blind: Container[str]) -> list[Imperfect]:
        """Try sets with one effect more, those that fit best to first order.

        Their evidence need not be above 0 yet: at the scatter without an effect, to explain all of it gains half a
        nat a number, less than its prior may cost.
        """
        worth = [c for c in self.screening.candidates() if c.effects[0] not in blind]
        worth.sort(key=lambda c: -c.fit)
        return [self._with(self.at.fit.state, self.screening, c) for c in worth[:TRIED]]

    def state_without(self, name: str) -> GapState:
        """State of the twin with one effect switched off."""
        return self.at.fit.state.without(name)

    def gains(self, baseline: Imperfect) -> dict[str, float]:
        """Log evidence of each effect over the set without it, nats."""
        effects = self.at.effects
        if len(effects) == 1:  # what is without it is known, not to first order only
            return {effects[0]: self.at.evidence - baseline.evidence}
        return {name: self.at.evidence - self._settled(self.state_without(name)).evidence for name in effects}

    def contested(self, blind: Container[str]) -> tuple[dict[str, dict[str, float]], list[Imperfect]]:
        """Log evidence of each other effect in the place of each, relative to it, and the sets tried for it."""
        rivals: dict[str, dict[str, float]] = {}
        swapped = []
        for name in self.at.effects:
            contest = self.screening.without(name)
            candidates = {c.effects[0]: c for c in contest.candidates() if c.effects[0] not in blind}
            own = candidates.pop(name).gain
            relative = {other: self.at.relative(c.gain - own) for other, c in candidates.items()}
            for other in sorted(relative, key=relative.__getitem__, reverse=True)[:TRIED]:
                trial = self._with(self.state_without(name), contest, candidates[other])
                relative[other] = trial.evidence - self.at.evidence
                swapped.append(trial)
            rivals[name] = relative
        return rivals, swapped

    def _with(self, state: GapState, screening: ScoreTest, candidate: Candidate) -> Imperfect:
        added = absent(self.plain, screening, candidate)
        found = self._settled(replace(state, effects={**state.effects, **added}), added)
        sites = len(self.plain.model.cards[candidate.effects[0]].sites)
        return replace(found, tries=sites)

    def _settled(self, state: GapState, places: dict[str, Values] | None = None) -> Imperfect:
        plain, weights = self.plain, self.at.context.sweeps.weights
        linear = cast(LinearisedSweeps, plain.model)
        here = plain.seen_by(linear.placed(places or {}))
        fit = here.weighted(weights).fit(state, tuple(state.effects))
        return settled(here, fit.state, self.at.fit.predicted, weights.undone(fit.residual), fit.determined)


def _screened(linear: SearchContext, fit: GapFit) -> ScoreTest:
    """Screen all sweeps: a campaign linearised at all of them costs nothing, and has no part."""
    return score_test(linear.model, linear.sweeps, fit, linear.executor)


def settled_from_first_order(plain: SearchContext, begun: GapFit) -> Imperfect:
    """Fit beside the scatter that the fit leaves, from where this settles on the campaign linearised at a fit.

    Parameters
    ----------
    plain : SearchContext
        Unweighted.
    begun : GapFit
        Of the same sweeps.

    Returns
    -------
    Imperfect
    """
    linear = LinearisedSweeps.of(plain.model, plain.sweeps, begun.state, plain.executor, candidates=False)
    near = settled(plain.seen_by(linear), begun.state, begun.predicted, begun.residual, begun.determined)
    residual = near.context.sweeps.weights.undone(near.fit.residual)
    return settled(plain, near.fit.state, begun.predicted, residual, near.fit.determined, rounds=TWIN_ROUNDS)


def settled(
    plain: SearchContext,
    state: GapState,
    predicted: Complex,
    residual: Complex,
    determined: float,
    *,
    rounds: int = ROUNDS,
) -> Imperfect:
    """Fit again, weighted by the scatter that the last fit leaves, until this does not change.

    Parameters
    ----------
    plain : SearchContext
        Unweighted.
    state : GapState
        Of a fit, with the effects to be fitted.
    predicted, residual : (T, K, n) complex ndarray
        Of that fit; the residual in units of the noise.
    determined : float
        As `GapFit.determined`.
    rounds : int
        Largest number of fits.

    Returns
    -------
    Imperfect
    """
    names, last = tuple(state.effects), np.full(3, -np.inf)
    for _ in range(rounds):
        shape = DiscrepancyShape.of(plain.sweeps, predicted, plain.loss_factors(state))
        scatter = shape.scatter(plain.sweeps, residual, determined)
        context = plain.weighted(shape.weights(scatter))
        fit = context.fit(state, names)
        state, determined = fit.state, fit.determined
        residual = context.sweeps.weights.undone(fit.residual)
        now = scatter.logarithms
        if _moved(last, now) < SETTLED:
            break
        last = now
    return Imperfect(context, fit, shape, scatter)


def _moved(before: Real, after: Real) -> float:
    """Largest change of the scatters' logarithms (3,), apart from those that are nothing."""
    floor = np.log(1e-3) + max(before.max(), after.max())
    return float(np.abs(np.maximum(before, floor) - np.maximum(after, floor)).max())


def over_all_sweeps(context: SearchContext, start: GapState, few: Imperfect) -> GapFit:
    """Fit a twin to all sweeps beside the scatter that it leaves at a few temperatures.

    What is common to all temperatures (gains, effects, declared quantities) is held as found at these: beside a
    discrepancy that all sweeps share, further ones tell no more of it.

    Parameters
    ----------
    context : SearchContext
        Of all sweeps, unweighted.
    start : GapState
        Of these, from whose part the fits to a few temperatures began.
    few : Imperfect
        The twin with the effects found, at a few temperatures.

    Returns
    -------
    GapFit
        Its residual and chi2 are in units of the noise; its standard deviations contain the discrepancy.
    """
    if few.context.sweeps.count == context.sweeps.count:
        return _stated(context, few.shape, few, few.fit)
    state = context.spread(start, few.context, few.fit.state)
    white = whiten_all(context.model, context.sweeps, state, (), context.executor)
    shape = DiscrepancyShape.of(
        context.sweeps, np.array([w.predicted for w in white]), context.loss_factors(state)
    )
    sweeps = replace(context.sweeps, weights=shape.weights(few.scatter))
    fit = fit_gap(context.model, sweeps, state, (), context.executor, gain_free=False)
    shape = DiscrepancyShape.of(context.sweeps, fit.predicted, context.loss_factors(fit.state))
    return _stated(context, shape, few, fit)


def _stated(context: SearchContext, shape: DiscrepancyShape, few: Imperfect, fit: GapFit) -> GapFit:
    """State a fit in units of the noise, with standard deviations that contain the discrepancy.

    Laws belong to one temperature each, and share its error with the other lines and channels only; what is common
    to the campaign shares it with all sweeps. The part of the laws' error that is not noise is common to all
    temperatures.
    """
    free, values = few.fit.free, few.fit.free.read(fit.state.on)
    tangents: list[Tangent] = [(name, parameter, fit.state.on[name]) for name, parameter in free.names]
    white = whiten_all(context.model, context.sweeps, fit.state, tangents, context.executor)
    residual = np.array([w.white[-1] for w in white])
    noise = Uncertainty.of(_head(context, white, fit, LineWeights.equal(residual.shape)), free, values, True)
    weighted = _head(context, white, fit, shape.weights(few.scatter))
    together = Uncertainty.of(weighted, free, values, True)
    single = shape.within_a_sweep(context.sweeps).weights(few.scatter)
    alone = Uncertainty.of(_head(context, white, fit, single), free, values, True).alone
    laws = np.sqrt(together.laws**2 - together.alone**2 + alone**2)
    ratio = laws / together.laws
    return replace(
        fit,
        free=free,
        information=weighted.without_gains().matrix,
        prior=few.fit.prior,
        declared=few.fit.declared,
        noise=noise,
        stated=replace(
            together,
            laws=laws,
            alone=noise.alone,
            within=together.within * ratio[:, :, None] * ratio[:, None, :],
            across=together.across * ratio[:, :, None],
        ),
        chi2=(np.abs(residual) ** 2).sum(-1),
        residual=residual,
        predicted=np.array([w.predicted for w in white]),
    )


def _head(
    context: SearchContext, white: list[WhitenedSweep], fit: GapFit, weights: LineWeights
) -> SchurComplement:
    """Form the normal equations of all sweeps with weights."""
    equations = [
        WhitenedSweep(weights.weigh(w.white, sweep), w.predicted).equations() for sweep, w in enumerate(white)
    ]
    return schur_complement(context.sweeps, equations, fit.state)
