"""Full fits of candidates: first at a few temperatures, then, if the gain is large enough, at all."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Self

import numpy as np

from analysis.effect_card import Values
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.state import GapState
from analysis.gap.search.context import SearchContext, explained
from analysis.gap.search.score_test import Candidate, ScoreTest
from analysis.gap.thresholds import BEHIND, LEAVES_NOISE, NEAR_IT, NEAR_MARGIN, PREDICTION_MARGIN, REFIT_SHARE


@dataclass(frozen=True)
class Refit:
    """Fit of a set of effects.

    Attributes
    ----------
    effects : tuple of str
    gain : float
        Log evidence over the fit it started from, nats; estimated from a few temperatures where `fit` is None.
    share : float
        Share of the excess that this fit left that it explains; estimated likewise.
    fit : GapFit or None
        Of all sweeps.
    """

    effects: tuple[str, ...]
    gain: float
    share: float
    fit: GapFit | None

    @classmethod
    def of(cls, context: SearchContext, base: GapFit, names: tuple[str, ...], fit: GapFit) -> Self:
        """Set a fit beside the one it started from."""
        return cls(names, fit.log_evidence - base.log_evidence, explained(context, base, fit), fit)

    def estimate(self, ratio: float) -> "Refit":
        """Return what it tells of `ratio` times as many sweeps."""
        return replace(self, gain=self.gain * ratio, fit=None)

    @property
    def plausible(self) -> bool:
        """Whether it was fitted, and no amplitude is at a bound of its physical range."""
        return self.fit is not None and self.fit.plausible


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


NO_STARTS: Mapping[tuple[str, ...], GapState] = MappingProxyType({})


def absent(context: SearchContext, screening: ScoreTest, candidate: Candidate) -> dict[str, Values]:
    """Values from which a candidate's fit starts: absent, its shapes at the best site.

    From there the first step changes laws, gain and effects jointly. The amplitudes of the score test together
    with the laws of a twin without effects would be further from the solution.

    Parameters
    ----------
    context : SearchContext
    screening : ScoreTest
    candidate : Candidate

    Returns
    -------
    dict of str to Values
        By effect.
    """
    return {
        screening.columns[i].effect: context.model.cards[screening.columns[i].effect].zero(
            screening.columns[i].shapes
        )
        for i in candidate.columns
    }


def first_order(context: SearchContext, screening: ScoreTest, candidate: Candidate) -> dict[str, Values]:
    """Values to which first order takes a candidate, its shapes at the best site, by effect."""
    values = absent(context, screening, candidate)
    for place, step in zip(candidate.columns, candidate.step, strict=True):
        column = screening.columns[place]
        values[column.effect] = {**values[column.effect], column.card.name: column.at + step}
    return values


def refit(
    context: SearchContext,
    base: GapFit,
    sets: Sequence[tuple[tuple[str, ...], dict[str, Values]]],
    starts: Mapping[tuple[str, ...], GapState] = NO_STARTS,
    needed: float = 0.0,
) -> list[Refit]:
    """Fit each set of effects, first at a few temperatures.

    Sets that gain less than a share of the best on a few temperatures are not fitted to all, and fits that cannot
    reach that gain are stopped and left out.

    Parameters
    ----------
    context : SearchContext
    base : GapFit
        From which all start.
    sets : sequence of (tuple of str, dict of str to Values)
        Effects of each set, and the start values of those that `base` lacks.
    starts : mapping
        Of some sets, whole states from which their fits to a few temperatures begin instead.
    needed : float
        Gain, nats, with less of which a set is of no use: its fit is stopped once it cannot reach that.

    Returns
    -------
    list of Refit
        Best first; fits that were given up are left out.
    """
    known = [(names, fit) for names, _ in sets if (fit := context.fits.known(names)) is not None]
    done = [Refit.of(context, base, names, fit) for names, fit in known]
    sets = [(names, added) for names, added in sets if context.fits.known(names) is None]
    if not sets:
        return sorted(done, key=lambda r: -r.gain)
    few, reference = at_few_temperatures(context, base)
    scale = context.sweeps.numbers / few.sweeps.numbers
    best = max(needed / scale, max((r.gain / scale for r in done if r.plausible), default=0.0))
    left, least = np.inf, np.inf
    least_held = np.inf
    far, tried = few.far(reference), []
    for place, (names, added) in enumerate(sets):
        enough = min(-2.0 * (reference.log_evidence + REFIT_SHARE * best), NEAR_IT * left, BEHIND * least)
        beaten = left < np.inf or (far and least < np.inf)
        start = starts[names] if names in starts else started_from(reference, names, added)
        margin = NEAR_MARGIN if beaten else PREDICTION_MARGIN
        fit = few.attempt(start, names, enough=enough, margin=margin, enough_held=BEHIND * least_held)
        if fit.held is not None:
            least_held = min(least_held, fit.held.objective)
        trial = Refit.of(few, reference, names, fit)
        if trial.plausible:
            best, least = max(best, trial.gain), min(least, fit.total)
            if fit.settled and fit.total < LEAVES_NOISE * few.sweeps.numbers:
                left = min(left, fit.total)
        tried.append(trial)
        context.report("refits", 0.5 * (place + 1) / len(sets))
    for place, trial in enumerate(tried):
        near = trial.fit is not None and trial.fit.total <= BEHIND * least
        done += _in_full(context, base, reference, few, trial, near and trial.gain >= REFIT_SHARE * best)
        context.report("refits", 0.5 + 0.5 * (place + 1) / len(sets))
    return sorted(done, key=lambda r: (r.fit is None, -r.gain))


def at_few_temperatures(context: SearchContext, base: GapFit) -> tuple[SearchContext, GapFit]:
    """Return the context of a few temperatures and the fit of `base` there; `context` if there are not many."""
    few, start = context.at_few_temperatures(base.state)
    return (context, base) if few is context else (few, few.fit(start, tuple(base.state.effects)))


def _in_full(
    context: SearchContext, base: GapFit, reference: GapFit, few: SearchContext, trial: Refit, deserved: bool
) -> list[Refit]:
    """Fit to all sweeps a set that was fitted to a few; an empty list if the fit was stopped."""
    names, fit = trial.effects, trial.fit
    if fit is None or not (deserved or fit.settled):
        return []
    if few is context:
        context.fits.keep(names, fit)
        return [trial]
    if not deserved:
        return [trial.estimate(context.sweeps.numbers / few.sweeps.numbers)]
    few.fits.keep(names, fit)  # settled or not, what comes next starts from it there
    start = base.state.corrected(context.sweeps, reference.state, fit.state, few.sweeps)
    full = context.fit(start, names)
    return [Refit.of(context, base, names, full)]


def started_from(base: GapFit, names: Sequence[str], added: dict[str, Values]) -> GapState:
    """Return the state of a fit with effects, some of them added.

    Where `base` lacks much, the fit starts from where its declared quantities had not followed what is missing.

    Parameters
    ----------
    base : GapFit
    names : sequence of str
        All effects of the state.
    added : dict of str to Values
        Values of those that `base` lacks.

    Returns
    -------
    GapState
    """
    start = base.state if base.held is None or base.total <= LEAVES_NOISE * base.dof else base.held.state
    effects = {name: start.effects.get(name, added.get(name, {})) for name in names}
    return replace(start, effects={name: dict(values) for name, values in effects.items()})
