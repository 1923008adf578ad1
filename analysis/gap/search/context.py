"""Search context: data common to all steps of the search, and the fits made so far."""

from collections.abc import Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.gap.data.noise import NoiseCheck
from analysis.gap.data.sweeps import GapSweeps, LineWeights
from analysis.gap.fitting.fit import ROUGHLY_SETTLED, KnownDerivatives, fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.residual_map import whiteness
from analysis.gap.fitting.state import GapState
from analysis.gap.search.score_test import ScoreTest, score_test
from analysis.gap.thresholds import (
    COARSE_TEMPERATURES,
    FAR,
    LEAST_GAIN,
    LEAVES_NOISE,
    PREDICTION_MARGIN,
    SCREENED,
    SCREENED_FAR,
    SETTLED,
    SETTLED_AT_FEW,
    WHITENESS,
    Z_FLOOR,
    Z_NAMED,
)
from analysis.progress import Progress
from analysis.twin_model import TwinModel


class FitCache:
    """Fits to the same sweeps by their set of effects, in any order; it grows during a search."""

    def __init__(self) -> None:
        self._fits: dict[frozenset[str], GapFit] = {}
        self._left: set[tuple[frozenset[str], str]] = set()

    def known(self, effects: Iterable[str]) -> GapFit | None:
        """Return the fit of `effects`; None if there is none yet."""
        return self._fits.get(frozenset(effects))

    def keep(self, effects: Iterable[str], fit: GapFit) -> None:
        """Store the fit of `effects`."""
        self._fits[frozenset(effects)] = fit

    def forget(self, effects: Iterable[str]) -> GapFit | None:
        """Remove and return the fit of `effects`; None if there is none."""
        return self._fits.pop(frozenset(effects), None)

    def first_without(self, effects: Iterable[str], name: str) -> bool:
        """Whether `effects` are asked for the first time as those that are left without another one."""
        left = (frozenset(effects), name)
        first = left not in self._left
        self._left.add(left)
        return first


@dataclass(eq=False)
class SearchContext:
    """Data common to all steps of the search.

    Attributes
    ----------
    model : TwinModel
    sweeps : GapSweeps
    noise : NoiseCheck
    executor : Executor
    report : callable
        Called with a stage's name and the share of it done.
    fits, fits_at_few : FitCache
        Fits made so far, to all sweeps and to those at a few temperatures.
    settled : float
        Predicted decrease of chi2 at which a fit is settled.
    known, known_at_few : KnownDerivatives
        By declared quantities, of the fits likewise.
    """

    model: TwinModel
    sweeps: GapSweeps
    noise: NoiseCheck
    executor: Executor
    report: Progress = field(default=lambda stage, share: None)
    fits: FitCache = field(repr=False, default_factory=FitCache)
    fits_at_few: FitCache = field(repr=False, default_factory=FitCache)
    settled: float = SETTLED
    known: KnownDerivatives = field(repr=False, default_factory=KnownDerivatives)
    known_at_few: KnownDerivatives = field(repr=False, default_factory=KnownDerivatives)

    def fit_from(self, start: GapState, effects: Sequence[str], **options: Any) -> GapFit:
        """Fit anew with `options` of `fit_gap`; derivatives that earlier fits computed nearby are used again."""
        return fit_gap(self.model, self.sweeps, start, effects, self.executor, known=self.known, **options)

    def fit(self, start: GapState, effects: Sequence[str], *, roughly: bool = False) -> GapFit:
        """Fit laws, readings, gain and `effects` to all sweeps; a result in `fits` is used again.

        Roughly: with declared quantities held where they start, for a set that is known to leave much.
        """
        found = self.fits.known(effects)
        if found is None:
            target = ROUGHLY_SETTLED if roughly else self.settled
            found = self.fit_from(start, effects, target=target, declared_free=not roughly)
            self.fits.keep(effects, found)
        return found

    def fit_without(self, whole: GapState, name: str, *, roughly: bool = False) -> GapFit:
        """Fit without one effect of a state, from there.

        Other effects were fitted before that one was added: where a fit to them is known, but better values are
        found from here, it had ended beside the solution, and the effect had only helped it on.
        """
        start = whole.without(name).promoted(self.model.cards)
        names = tuple(start.effects)
        known, first = self.fits.known(names), self.fits.first_without(names, name)
        if known is None or not first:
            return self.fit(start, names, roughly=roughly)
        again = self.fit_from(
            start,
            names,
            target=ROUGHLY_SETTLED if roughly else self.settled,
            declared_free=not roughly,
            enough=-2.0 * (known.log_evidence + self.settled),
        )
        if not again.settled or again.log_evidence <= known.log_evidence + self.settled:
            return known
        self.fits.keep(names, again)
        return again

    def set_aside(self, effects: Sequence[str], enough: float) -> GapFit | None:
        """Forget and return a fit whose log evidence is below `enough`, to fit anew from elsewhere."""
        known = self.fits.known(effects)
        if known is None or known.log_evidence >= enough:
            return None
        self.fits_at_few.forget(effects)
        return self.fits.forget(effects)

    def attempt(
        self,
        start: GapState,
        effects: Sequence[str],
        *,
        enough: float,
        margin: float = PREDICTION_MARGIN,
        enough_held: float = np.inf,
    ) -> GapFit:
        """Do what `fit` does, but stop where `fit_gap` would with these bounds; what was stopped is not kept."""
        found = self.fits.known(effects)
        if found is None:
            found = self.fit_from(
                start, effects, target=self.settled, enough=enough, margin=margin, enough_held=enough_held
            )
            if found.settled:  # one that was given up was so against others
                self.fits.keep(effects, found)
        return found

    def at_few_temperatures(self, start: GapState) -> tuple["SearchContext", GapState]:
        """Return a context for a few temperatures, itself if there are no more, and a state of all there."""
        if self.few:
            return self, start
        part = self.of(self.sweeps.only_groups(self.some_groups()))
        few = replace(part, fits=self.fits_at_few, settled=SETTLED_AT_FEW, known=self.known_at_few)
        return few, start.restricted(self.sweeps, few.sweeps)

    def spread(self, start: GapState, few: "SearchContext", found: GapState) -> GapState:
        """Change a state of all sweeps as a fit to those of `few` changed its part there."""
        if few.sweeps.count == self.sweeps.count:
            return found
        _, begun = self.at_few_temperatures(start)
        changed = start.corrected(self.sweeps, begun, found, few.sweeps)
        return replace(changed, tilt=start.tilt, bend=start.bend)

    def of(self, sweeps: GapSweeps) -> "SearchContext":
        """Return a context of its own for other sweeps."""
        return SearchContext(self.model, sweeps, self.noise, self.executor, self.report, settled=self.settled)

    def weighted(self, weights: LineWeights) -> "SearchContext":
        """Return a context of its own, in which every whitened number counts by its weights."""
        return self.of(replace(self.sweeps, weights=weights))

    def seen_by(self, model: TwinModel) -> "SearchContext":
        """Return a context of its own with another model of the same sweeps."""
        return replace(self.of(self.sweeps), model=model)

    def loss_factors(self, state: GapState) -> Real:
        """Loss factor of every sweep, (T,)."""
        return np.asarray(np.exp(state.laws[self.sweeps.groups.of_sweep, 2]))

    def score_test(self, fit: GapFit, *, for_rivals: bool = False) -> ScoreTest:
        """Score test of all candidates at `fit`; where it leaves much at some temperatures, scaled to all.

        For the rivals of strong effects, known to leave nothing: at as few temperatures as far from the data.
        """
        part = self.sweeps
        if for_rivals:
            part = part.only_groups(self.some_groups(SCREENED_FAR))
        elif self.excess(fit) >= SCREENED * self.sweeps.numbers:
            part = part.only_groups(self.some_groups(SCREENED_FAR if self.far(fit) else COARSE_TEMPERATURES))
        if part.count == self.sweeps.count:
            return score_test(self.model, self.sweeps, fit, self.executor)
        there = replace(fit, state=fit.state.restricted(self.sweeps, part))
        return score_test(self.model, part, there, self.executor).scaled(self.sweeps.numbers / part.numbers)

    def moved_error(self, fit: GapFit) -> float:
        """Error of the twin by moved patches, see `FreeParameters.moved_error`."""
        return fit.free.moved_error(fit.free.read(fit.state.on))

    def form_gain(self, fit: GapFit, added: str = "") -> float:
        """Gain that another effect, `added`, may owe to the form of those of a fit, nats: `EffectCard.form`."""
        total = 0.0
        for name in fit.state.effects:
            form, others = self.model.cards[name].form, tuple(one for one in fit.state.effects if one != name)
            without = self.fits.known(others) if form and name != added else None
            if without is not None and not (added and self.model.cards[added].after == name):
                total += form**2 * max(0.0, fit.log_evidence - without.log_evidence)
        return total

    def allowed(self, fit: GapFit) -> float:
        """chi2 that the twin's own error may cause, that by moved patches and by the form of effects included."""
        moved = self.moved_error(fit) ** 2 * self.sweeps.power
        return self.sweeps.allowed + moved + 2.0 * self.form_gain(fit)

    def overstated(self, fit: GapFit) -> float:
        """As `GapSweeps.overstated`, with the error by moved patches."""
        return self.sweeps.overstated_with(self.moved_error(fit))

    def least_gain(self, fit: GapFit | None = None) -> float:
        """Smallest gain of an effect, nats of the likelihood: by the fit with it, or else by the sweeps alone."""
        return LEAST_GAIN * (self.sweeps.overstated if fit is None else self.overstated(fit))

    def z(self, fit: GapFit) -> float:
        """Excess of a fit's chi2 over noise and the twin's own error, in its standard deviations."""
        return self.noise.z(fit.total - min(self.allowed(fit), max(self.excess(fit), 0.0)), fit.dof)

    def far(self, fit: GapFit) -> bool:
        """Whether a fit leaves so much that its declared quantities only follow what is missing."""
        return self.excess(fit) > FAR * self.sweeps.numbers

    def leaves_more(self, fit: GapFit) -> bool:
        """Whether a fit leaves more than noise, with no need of a test."""
        return fit.total > LEAVES_NOISE * self.sweeps.numbers

    def excess(self, fit: GapFit) -> float:
        """chi2 minus that of noise."""
        return fit.total + float(self.noise.sharp.sum()) - fit.dof

    def agrees(self, fit: GapFit) -> bool:
        """Whether a fit leaves only noise and the twin's own error, which need not be white."""
        if self.z(fit) > (Z_NAMED if fit.state.effects else Z_FLOOR):
            return False
        return self.excess(fit) <= self.allowed(fit) or max(whiteness(self.sweeps, fit.residual)) <= WHITENESS

    @property
    def few(self) -> bool:
        """Whether its temperatures are so few that candidates are fitted to all of them at once."""
        return len(self.some_groups()) == len(self.sweeps.groups.reference)

    def some_groups(self, wanted: int = COARSE_TEMPERATURES) -> list[int]:
        """Return about as many groups as wanted, evenly spread, the first and the last among them."""
        count = len(self.sweeps.groups.reference)
        if count < 1.5 * wanted:
            return list(range(count))
        return sorted({round(i * (count - 1) / (wanted - 1)) for i in range(wanted)})


def explained(context: SearchContext, before: GapFit, after: GapFit) -> float:
    """Share of the excess chi2 of one fit that another fit explains.

    Parameters
    ----------
    context : SearchContext
    before : GapFit
    after : GapFit

    Returns
    -------
    float
        0 where `before` has no excess.
    """
    excess = context.excess(before)
    return (before.total - after.total) / excess if excess > 0.0 else 0.0
