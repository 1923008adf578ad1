"""Search for effects beside a discrepancy: what a twin lacks, where no twin comes down to the noise.

Each set of effects is fitted beside the scatter of resonances that it leaves itself. An effect that is right makes
the scatter of many modes smaller at once: its evidence is about the number of modes times the logarithm of the
scatter before over that after. So no residual has to be noise for a name to be sure.
"""

from collections.abc import Collection, Container, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
from scipy.linalg import qr

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard
from analysis.gap.data.sweeps import GapSweeps, LineWeights
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit, Uncertainty
from analysis.gap.fitting.linearised_sweeps import LinearisedSweeps
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import SchurComplement, schur_complement
from analysis.gap.fitting.sites import sites_beside
from analysis.gap.fitting.state import GapState
from analysis.gap.imperfect.discrepancy import Discrepancy, DiscrepancyShape
from analysis.gap.imperfect.random_effects import JudgedSet, RandomEffects
from analysis.gap.search.context import SearchContext
from analysis.gap.search.observability import observability
from analysis.gap.search.score_test import ScoreTest, score_test
from analysis.gap.thresholds import CLASS_NATS, LEAST_GAIN
from analysis.twin_model import Tangent

MOST_EFFECTS = 6
"""Largest number of effects beside a discrepancy: its evidence, unlike that of noise, grows by chance only."""
TRIED = 8
"""Number of candidates of a score test that are tried on the linearised campaign, each with its own scatter."""
FITTED = 2
"""Number of them that are fitted with the twin itself."""
MOST_SEARCHED = 48
"""Number of channels that are searched: far more than modes that overlap, so that others tell the same again. All
200 of a laser's grid took 4.7 GB; these, 2.9."""
FAR = 0.5
"""Scatter of frequencies, in half widths of a resonance, above which sets are fitted with the twin itself,
whatever they gain to first order."""
LEAST_SIGMAS = 2.0
"""Amplitude of an effect over its standard deviation below which it is none, whatever its evidence: that counts
the modes which an effect brings nearer, and gave a spot of 0.4 +- 0.3 % beside a mass a probability of 0.82."""
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
    """

    context: SearchContext
    fit: GapFit
    shape: DiscrepancyShape
    scatter: Discrepancy

    @property
    def effects(self) -> tuple[str, ...]:
        """Effects of the twin, in the order they were found."""
        return tuple(self.fit.state.effects)

    def at(self, state: GapState) -> "Imperfect":
        """Return the same with other values of what was fitted."""
        prior, declared = self.fit.free.penalties(self.fit.free.read(state.on))
        return replace(self, fit=replace(self.fit, state=state, prior=prior, declared=declared))

    def idle(self, cards: Mapping[str, EffectCard]) -> bool:
        """Whether an effect was fitted to nothing: its place is then none, and costs no evidence."""
        values = self.fit.state.effects
        return any(not any(one[p.name] for p in cards[name].amplitudes) for name, one in values.items())

    def size(self, name: str) -> float:
        """Amplitudes of an effect over their standard deviations beside the discrepancy, taken together."""
        free = self.fit.free
        of_effect = enumerate(zip(free.names, free.cards, strict=True))
        places = [k for k, ((effect, _), card) in of_effect if effect == name and not card.shape]
        amplitudes = free.read(self.fit.state.on)[places]
        own = self.fit.stated.own[np.ix_(places, places)]
        return float(np.sqrt(amplitudes @ np.linalg.solve(own, amplitudes)))

    @property
    def far(self) -> bool:
        """Whether resonances are off by so much of their half width that they are not where first order ends."""
        half = 0.5 * float(np.exp(self.fit.state.laws[:, 2].mean()))
        return self.scatter.frequency > FAR * half


@dataclass(frozen=True)
class ImperfectResult:
    """Result of a search beside a discrepancy.

    Attributes
    ----------
    baseline, final : Imperfect
        Without effects, and with those found.
    scatter : tuple of Discrepancy
        Of their modes.
    last : ScoreTest
        At `final`.
    gains : mapping of str to float
        Log evidence of each effect found over the best twin without it, nats.
    rivals : mapping of str to mapping
        For each effect found: log evidence of every other effect instead of it, relative to it, nats.
    """

    baseline: Imperfect
    final: Imperfect
    scatter: tuple[Discrepancy, Discrepancy]
    last: ScoreTest
    gains: dict[str, float]
    rivals: dict[str, dict[str, float]]


class ImperfectSearch:
    """Stepwise search in which each set of effects is judged beside the scatter of modes that it leaves.

    Candidates are compared on the campaign linearised at the present twin, with all candidates' derivatives; only
    the best is fitted with the twin itself.

    Of many channels a part is searched, and all of them are fitted at the end.

    Attributes
    ----------
    plain : SearchContext
        Unweighted, of the channels that are searched.
    """

    def __init__(self, whole: SearchContext, baseline: GapFit, known: GapFit | None = None) -> None:
        """Fit the twin without effects beside what it leaves, and `known`, with effects, from which to go on."""
        heard = _telling(whole.sweeps, baseline.predicted)
        self._whole = whole
        self.plain = whole if heard is None else whole.of(whole.sweeps.only_channels(heard))
        self._baseline = self._settled(baseline, heard)
        self._begun = self._baseline if known is None else self._settled(known, heard)

    def _settled(self, fit: GapFit, heard: list[int] | None) -> Imperfect:
        if heard is not None:
            fit = replace(fit, predicted=fit.predicted[:, heard], residual=fit.residual[:, heard])
        return settled_from_first_order(self.plain, fit)

    def run(self) -> ImperfectResult:
        """Add effects while there is evidence for one more, then leave out and exchange each."""
        near = self._neighbours(self._begun)
        plain = near.judged if near.at is self._baseline else self._judged(self._baseline)
        alone = near.here if near.at is self._baseline else plain.here()
        blind = near.blind()
        while len(near.at.effects) < MOST_EFFECTS:
            better = self._better(near, near.extended(blind))
            if better is None:
                break
            near = better
        for _ in range(MOST_EFFECTS):
            gains = near.gains()
            idle = [n for n, gain in gains.items() if gain < LEAST_GAIN or near.at.size(n) < LEAST_SIGMAS]
            idle += near.at.fit.become_another
            if idle:
                near = self._neighbours(self._fitted(near, near.left(min(idle, key=gains.__getitem__))))
                continue
            rivals, swapped = near.contested(blind)
            better = self._better(near, swapped, CLASS_NATS)
            if better is None:
                break
            near = better
        else:
            gains, (rivals, _) = near.gains(), near.contested(blind)
        baseline = self._likeliest(self._baseline, plain, alone)
        final = baseline if near.at is self._baseline else self._likeliest(near.at, near.judged, near.here)
        return ImperfectResult(baseline, final, (alone.scatter, near.here.scatter), near.screening, gains, rivals)

    def over_scatter(self) -> float | None:
        """Log evidence of the effects begun with over none, nats; None where without them modes do not scatter."""
        judged = self._judged(self._begun)
        here = judged.here()
        alone = judged.without(self._begun.effects, here)
        return here.evidence - alone.evidence if judged.scatters(alone) else None

    def _likeliest(self, at: Imperfect, judged: RandomEffects, found: JudgedSet) -> Imperfect:
        """Move a fit, which weighs what modes share, to where all unknowns are likeliest beside random effects."""
        whole = self._whole
        if whole is not self.plain:
            white = whiten_all(whole.model, whole.sweeps, at.fit.state, (), whole.executor)
            predicted, residual = np.array([w.predicted for w in white]), np.array([w.white[-1] for w in white])
            at = settled(whole, at.fit.state, predicted, residual, at.fit.determined, rounds=1)
            judged = self._judged(at)
        first = at.at(judged.moved(found))
        try:
            return first.at(self._judged(first).moved(found))
        except ValueError:  # beyond what the twin is certified for
            return at

    def _better(
        self, near: "_Neighbours", tried: Sequence["_Trial"], least: float = LEAST_GAIN
    ) -> "_Neighbours | None":
        """Fit the most promising sets with the twin, until one is better by `least` nats; None if none is."""
        best = sorted(tried, key=lambda trial: -trial.gain)
        promising = [trial for trial in best if trial.gain > 0.5 * least]
        if near.at.far:  # first order tells little
            promising = best
        for trial in promising[:FITTED]:
            fitted = self._fitted(near, trial.state)
            gone = [name for name in near.at.effects if name not in fitted.effects]
            if fitted.fit.become_another:  # what has no name here must not get that of what explains less
                least = max(least, self._neighbours(fitted, gone).over(near))
            if not fitted.fit.plausible or fitted.idle(self.plain.model.cards):
                continue
            # most sets are refused, and all candidates are most of the cost
            found = self._neighbours(fitted, gone)
            if found.over(near) >= least:
                return self._neighbours(fitted, here=found.here)
        return None

    def _neighbours(
        self, at: Imperfect, candidates: Collection[str] | None = None, here: JudgedSet | None = None
    ) -> "_Neighbours":
        """Linearise at a twin by some candidates, by default all; `here`: what the twin comes to, if known."""
        self.plain.report("beside a discrepancy", min(0.2 * len(at.effects), 0.8))
        judged = self._judged(at, candidates)
        return _Neighbours(at, self.plain.seen_by(judged.linear), judged, here or judged.here())

    def _judged(self, at: Imperfect, candidates: Collection[str] | None = ()) -> RandomEffects:
        plain = self.plain if at.context.sweeps.heard else self._whole
        linear = LinearisedSweeps.of(
            plain.model, plain.sweeps, at.fit.state, plain.executor, candidates=candidates
        )
        return RandomEffects.of(linear, plain.sweeps)

    def _fitted(self, near: "_Neighbours", state: GapState) -> Imperfect:
        """Fit a set of effects with the twin itself, from where the campaign linearised near it leaves it."""
        first = near.settled(state)
        context, at = self.plain.weighted(first.context.sweeps.weights), near.at
        state = first.fit.state.promoted(context.model.cards)
        names = tuple(state.effects)
        try:
            fit = context.fit(state, names)
        except ValueError:  # first order went beyond what the twin is certified for: begin where it is absent
            known, cards = at.fit.state.effects, context.model.cards
            values = {name: known.get(name, cards[name].zero(state.effects[name])) for name in names}
            fit = context.fit(at.fit.state.with_effects(values), names)
        residual = context.sweeps.weights.undone(fit.residual)
        return settled(self.plain, fit.state, fit.predicted, residual, fit.determined, rounds=TWIN_ROUNDS - 1)


def _telling(sweeps: GapSweeps, predicted: Complex) -> list[int] | None:
    """Return the channels of a prediction (T, K, n) that tell most of all, `MOST_SEARCHED` of them; None for all.

    Pivots of a QR factorisation, in units of the noise: each is the one that those before it describe worst.
    """
    count = len(sweeps.channels)
    if count <= MOST_SEARCHED:
        return None
    white = [one.whitened(its) for one, its in zip(sweeps.compressed, predicted, strict=True)]
    flat = np.moveaxis(np.array(white), 1, 2).reshape(-1, count)
    pivots = qr(np.concatenate([flat.real, flat.imag]), mode="r", pivoting=True)[1]
    return sorted(pivots[:MOST_SEARCHED].tolist())


@dataclass(frozen=True)
class _Trial:
    """A set of effects near that of a twin, on the campaign linearised there.

    Attributes
    ----------
    state : GapState
        From which it is fitted.
    gain : float
        Log evidence over the twin's, nats, less the logarithm of the number of places at which the added effect
        was tried. Where a place is fitted, the evidence contains its uncertainty.
    """

    state: GapState
    gain: float


@dataclass(frozen=True)
class _Neighbours:
    """Sets of effects near that of a twin, on the campaign linearised there."""

    at: Imperfect
    plain: SearchContext
    judged: RandomEffects
    here: JudgedSet

    @cached_property
    def screening(self) -> ScoreTest:
        """Score test of all candidates beside the scatter."""
        return _screened(self.plain.weighted(self.at.context.sweeps.weights), self.at.fit)

    def blind(self) -> set[str]:
        """Tell which effects the campaign does not show beside noise; whether beside more, evidence tells."""
        screening = _screened(self.plain, self.at.fit)
        seen = observability(screening, self.plain.model.cards, self.plain.sweeps.level_count)
        return {one.effect for one in seen if not one.observable}

    def extended(self, blind: Container[str]) -> list[_Trial]:
        """Try sets with one effect more, those of most evidence at the present scatter."""
        return [trial for _, trial in self._ranked((), blind)]

    def left(self, name: str) -> GapState:
        """State of the twin with one effect switched off."""
        return self.at.fit.state.without(name)

    def gains(self) -> dict[str, float]:
        """Log evidence of each effect over the set without it, nats."""
        return {
            name: self.here.evidence - self.judged.without((name,), self.here).evidence for name in self.at.effects
        }

    def over(self, before: "_Neighbours") -> float:
        """Log evidence over another set, nats.

        On the campaign linearised here, where the sets differ by one effect: of one set, far from the data, it
        differs by tens of nats between two twins.
        """
        new = [name for name in self.at.effects if name not in before.at.effects]
        gone = [name for name in before.at.effects if name not in self.at.effects]
        if len(new) == 1 and not gone:
            return self.here.evidence - self.judged.without(new, self.here).evidence
        if len(new) == 1 and len(gone) == 1:
            for _, trial in self._ranked(new, (), gone):
                return -trial.gain
        return self.here.evidence - before.here.evidence

    def contested(self, blind: Container[str]) -> tuple[dict[str, dict[str, float]], list[_Trial]]:
        """Log evidence of each other effect in the place of each, relative to it, and the sets tried for it."""
        rivals: dict[str, dict[str, float]] = {}
        swapped = []
        for name in self.at.effects:
            ranked = self._ranked((name,), blind)
            rivals[name] = {other: trial.gain for other, trial in ranked}
            swapped += [trial for _, trial in ranked[:TRIED]]
        return rivals, swapped

    def _ranked(
        self, left_out: Collection[str], blind: Container[str], only: Collection[str] = ()
    ) -> list[tuple[str, _Trial]]:
        """Other effects at their best sites, beside all that are on but some; the best with their own scatter."""
        near = self.judged.without(left_out, self.here) if left_out else self.here
        on, cards = [name for name in self.at.effects if name not in left_out], self.plain.model.cards
        kept, screened = self.at.fit.state, {}
        for name in left_out:
            kept = kept.without(name)
        starts = sites_beside(cards, self.at.fit.state.effects)
        for name in only or starts:
            card = cards[name]
            if name in blind or (card.after and card.after not in on):
                continue
            sites = [(self.judged.screened(name, site, near, left_out), site) for site in starts[name]]
            screened[name] = max(sites, key=lambda one: one[0].evidence)
        found = []
        for place, name in enumerate(sorted(screened, key=lambda name: -screened[name][0].evidence)):
            (one, site), card = screened[name], cards[name]
            if place < TRIED:
                one = self.judged.with_effect(name, site, near, left_out)
            amplitudes = dict(zip((p.name for p in card.amplitudes), one.values, strict=True))
            gain = one.evidence - float(np.log(len(starts[name]))) - self.here.evidence
            state = replace(kept, effects={**kept.effects, name: {**card.zero(site), **amplitudes}})
            found.append((name, _Trial(state, gain)))
        return sorted(found, key=lambda one: -one[1].gain)

    def settled(self, state: GapState) -> Imperfect:
        """Fit a set of effects on the linearised campaign, what is off here held at its place."""
        added = {name: values for name, values in state.effects.items() if name not in self.at.fit.state.effects}
        weights = self.at.context.sweeps.weights
        linear = cast(LinearisedSweeps, self.plain.model)
        here = self.plain.seen_by(linear.placed(added))
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
    linear = LinearisedSweeps.of(plain.model, plain.sweeps, begun.state, plain.executor, candidates=())
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
