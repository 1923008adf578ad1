"""Candidates fitted in full: first on a few temperatures, then, if they deserve it, on all of them."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

from analysis.effect_card import Values
from analysis.gap.data.noise import NoiseCheck
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.state import GapState
from analysis.gap.fitting.whiteness import whiteness
from analysis.gap.search.score_test import Candidate, Screening, screen
from analysis.gap.thresholds import (
    COARSE_TEMPERATURES,
    LEAST_GAIN,
    REFIT_SHARE,
    WHITENESS,
    Z_FLOOR,
    Z_NAMED,
)
from analysis.twin_model import TwinModel

Progress = Callable[[str, float], None]


@dataclass(eq=False)
class Bench:
    """What every step of the search works with; no value, for it remembers the fits to all sweeps.

    Attributes
    ----------
    model : TwinModel
    sweeps : GapSweeps
    noise : NoiseCheck
    executor : Executor
    report : callable
        Told a stage's name and the share of it done.
    """

    model: TwinModel
    sweeps: GapSweeps
    noise: NoiseCheck
    executor: Executor
    report: Progress = field(default=lambda stage, share: None)
    _fits: dict[frozenset[str], GapFit] = field(init=False, repr=False, default_factory=dict)

    def fit(self, start: GapState, effects: Sequence[str]) -> GapFit:
        """Fit laws, readings, gain and `effects` to all sweeps, unless that was done before."""
        found = self.known(effects)
        if found is None:
            found = fit_gap(self.model, self.sweeps, start, effects, self.executor)
            self.keep(effects, found)
        return found

    def known(self, effects: Iterable[str]) -> GapFit | None:
        """Return the fit of `effects`, in any order, to all sweeps; None if there is none yet."""
        return self._fits.get(frozenset(effects))

    def keep(self, effects: Iterable[str], fit: GapFit) -> None:
        """Remember the fit of `effects` to all sweeps."""
        self._fits[frozenset(effects)] = fit

    def screen(self, fit: GapFit) -> Screening:
        """Score test of all candidates at `fit`."""
        return screen(self.model, self.sweeps, fit, self.executor)

    @property
    def least_gain(self) -> float:
        """Log evidence that an effect must bring, nats, as the likelihood counts them."""
        return LEAST_GAIN * self.sweeps.overstated

    def z(self, fit: GapFit) -> float:
        """Excess of a fit's chi2 over noise and the twin's own error, in its standard deviations."""
        return self.noise.z(fit.total - min(self.sweeps.allowed, max(self.excess(fit), 0.0)), fit.dof)

    def excess(self, fit: GapFit) -> float:
        """Chi2 beyond what noise leaves."""
        return fit.total + float(self.noise.sharp.sum()) - fit.dof

    def agrees(self, fit: GapFit) -> bool:
        """Whether a fit leaves nothing but noise and the twin's own error, which need not be white."""
        if self.z(fit) > (Z_NAMED if fit.state.effects else Z_FLOOR):
            return False
        return self.excess(fit) <= self.sweeps.allowed or max(whiteness(self.sweeps, fit.residual)) <= WHITENESS

    @property
    def coarse_groups(self) -> list[int]:
        """A few temperatures, evenly over the range, first and last among them."""
        count = len(self.sweeps.groups.reference)
        if count < 1.5 * COARSE_TEMPERATURES:
            return list(range(count))
        return sorted({round(i * (count - 1) / (COARSE_TEMPERATURES - 1)) for i in range(COARSE_TEMPERATURES)})


@dataclass(frozen=True)
class Refit:
    """A set of effects fitted.

    Attributes
    ----------
    effects : tuple of str
    gain : float
        Log evidence over the fit it started from, nats; estimated from a few temperatures where `fit` is None.
    fit : GapFit or None
        Of all sweeps.
    """

    effects: tuple[str, ...]
    gain: float
    fit: GapFit | None

    @property
    def plausible(self) -> bool:
        """Fitted, and no amplitude at the end of its range, where physics says stop and the data go on.

        Zero is no such end: a dashpot may be absent beside its spring.
        """
        if self.fit is None:
            return False
        free, values = self.fit.free, self.fit.free.read(self.fit.state.effects)
        return not any(
            name in self.fit.on_wall and not card.shape and value != 0.0
            for name, card, value in zip(free.names, free.cards, values, strict=True)
        )


def explained(bench: Bench, before: GapFit, after: GapFit) -> float:
    """Share of the excess of `before` that `after` explains; 0 where there was none."""
    excess = bench.excess(before)
    return (before.total - after.total) / excess if excess > 0.0 else 0.0


def absent(bench: Bench, screening: Screening, candidate: Candidate) -> dict[str, Values]:
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


def refit(bench: Bench, base: GapFit, sets: Sequence[tuple[tuple[str, ...], dict[str, Values]]]) -> list[Refit]:
    """Fit each set of effects, best first; `sets` gives for each the start of the effects that `base` lacks.

    Those that gain less than a share of the best on a few temperatures are not fitted to the others, and those
    that could not gain it are given up on the way and left out.
    """
    known = [(names, fit) for names, _ in sets if (fit := bench.known(names)) is not None]
    done = [Refit(names, fit.log_evidence - base.log_evidence, fit) for names, fit in known]
    sets = [(names, added) for names, added in sets if bench.known(names) is None]
    if not sets:
        return sorted(done, key=lambda r: -r.gain)
    few, reference = _coarse(bench, base)
    scale = bench.sweeps.numbers / few.numbers
    best = max((r.gain / scale for r in done if r.plausible), default=0.0)
    tried = []
    for place, (names, added) in enumerate(sets):
        enough = -2.0 * (reference.log_evidence + REFIT_SHARE * best)
        fit = fit_gap(bench.model, few, _started(reference, names, added), names, bench.executor, enough=enough)
        trial = Refit(names, fit.log_evidence - reference.log_evidence, fit)
        best = max(best, trial.gain) if trial.plausible else best
        tried.append(trial)
        bench.report("refits", 0.5 * (place + 1) / len(sets))
    for place, trial in enumerate(tried):
        done += _in_full(bench, base, reference, few, trial, trial.gain >= REFIT_SHARE * best)
        bench.report("refits", 0.5 + 0.5 * (place + 1) / len(sets))
    return sorted(done, key=lambda r: (r.fit is None, -r.gain))


def _coarse(bench: Bench, base: GapFit) -> tuple[GapSweeps, GapFit]:
    """Return the sweeps at a few temperatures and the fit of `base` to them; all where there are but few."""
    groups = bench.coarse_groups
    if len(groups) == len(bench.sweeps.groups.reference):
        return bench.sweeps, base
    few = bench.sweeps.only_groups(groups)
    kept = base.state.restricted(groups, few.original_places(bench.sweeps))
    return few, fit_gap(bench.model, few, kept, tuple(base.state.effects), bench.executor)


def _in_full(
    bench: Bench, base: GapFit, reference: GapFit, few: GapSweeps, trial: Refit, deserved: bool
) -> list[Refit]:
    """Fit to all sweeps what was fitted to a few of them; nothing of what was given up on the way."""
    names, fit = trial.effects, trial.fit
    if fit is None or not (deserved or fit.settled):
        return []
    if few is bench.sweeps:
        bench.keep(names, fit)
        return [trial]
    if not deserved:
        return [Refit(names, trial.gain * bench.sweeps.numbers / few.numbers, None)]
    start = base.state.corrected(bench.sweeps.groups, reference.state, fit.state, few.groups)
    full = bench.fit(start, names)
    return [Refit(names, full.log_evidence - base.log_evidence, full)]


def _started(base: GapFit, names: Sequence[str], added: dict[str, Values]) -> GapState:
    effects = {name: base.state.effects.get(name, added.get(name, {})) for name in names}
    return replace(base.state, effects={name: dict(values) for name, values in effects.items()})
