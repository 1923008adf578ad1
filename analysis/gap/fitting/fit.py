"""Joint fit of laws, readings, gains and effects: Levenberg-Marquardt with a Schur complement."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from analysis.arrays import Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.bounded_step import bounded_step
from analysis.gap.fitting.gap_fit import GapFit, Held, Uncertainty
from analysis.gap.fitting.normal_equations import GLOBAL, VALUES, SweepEquations, linearise_all
from analysis.gap.fitting.schur_complement import LocalStep, schur_complement
from analysis.gap.fitting.state import FreeParameters, GapState, clipped_laws
from analysis.gap.thresholds import LEAVES_NOISE, MOST_STEPS, PREDICTION_MARGIN, SETTLED
from analysis.twin_model import Tangent, TwinModel

LARGEST_STEP = np.array([0.3, 0.05, 0.7])
"""Largest step of log E, nu and log eta in one iteration: with larger ones resonances pass each other."""

BACKTRACKED = 0.4
"""Share to which a step that increased the objective is shortened before damping is tried."""

ASTRAY = 1.0 / BACKTRACKED**4
"""Times the objective before a step from which the shortened one would increase it, too, and is not tried: what
second order adds to a residual counts with the fourth power of a step."""

BENT = 0.5
"""Share of the predicted decrease below which a step is taken again along its curve: near-collinear unknowns
(gain, d31 and permittivity; modulus, thickness and lengths) move far together, and their second order remains."""

MOST_BENT = 10.0
"""Times the first prediction that the second may be: beyond it, second order is no description of the curve."""

SHAPE_STEP = 0.25
"""Largest step of a shape parameter in one iteration, in standard deviations of its prior."""

IDLE, IDLE_LAWS = 0.3, np.array([6e-4, 1e-4, 1e-3])
"""Predicted decrease over the scatter of chi2, and steps of log E, nu and log eta, below which a fit of declared
quantities without effects has settled. Two like patches that differ (one thicker, one thinner) change a response
in second order only; a fit goes to and fro there for as many steps as it is given, and the laws do not follow."""

ROUGH, ROUGHLY_SETTLED = 3.0, 300.0
"""chi2 per number above which a fit first moves with the declared quantities held, and the predicted decrease, per
chi2 per number, at which they are freed: they are most of the tangents, and far from the data they only follow."""

NEAR, NEAR_ENOUGH = 0.05, 0.005
"""Relative change of the derivative by log E up to which those by declared quantities are taken from where they
were computed last: they are most of a linearisation's cost, and change as little. Up to the second, a fit that has
settled with them is not linearised again: what they come to changes by as little."""

SLOW = 0.3
"""Share of the last predicted decrease that the next may be while known derivatives are used: beyond it they are
computed anew, which takes as long as three steps without."""

AGAIN = 10.0
"""Times the predicted decrease at which a fit has settled that all derivatives anew may promise: half a nat, where
evidences are compared by six."""

ROUNDS, FELL = 4, 0.7
"""Largest number of times that the tolerances are weighed, and how far chi2 has to fall for another time."""

SETTLED_FAR, SETTLED_FAR_ALONE = 1e-2, 1e-1
"""Predicted decrease, as a share of the objective, at which a fit that leaves more than `ROUGH` is settled where
declared quantities are free; and without effects, where it is only what others start from. What is missing there
bends quantities that hardly differ (gain, d31, permittivity) for as many steps as one allows."""

CREEPS = 0.1
"""Share of what chi2 exceeds the noise by that a damped step has to take from it, where more than noise is left
and declared quantities are free: with a second effect missing, they go on for dozens of steps of a per cent."""

OF_EXCESS = 1e-3
"""Predicted decrease, as a share of what chi2 exceeds the noise by, at which a fit of effects beside declared
quantities has settled: of what is missing, an effect of this share is not told from them."""


MOST_KNOWN = 3
"""Points whose derivatives by declared quantities are remembered: a search begins its fits at its best twin, and
at where that was before declared quantities followed what was missing."""


class KnownDerivatives:
    """Points that were linearised by declared quantities, too: fits of a search to the same sweeps share them."""

    def __init__(self) -> None:
        self._points: list[list[SweepEquations]] = []

    def keep(self, equations: list[SweepEquations]) -> None:
        """Remember a point; the one that was kept longest is forgotten."""
        self._points = [*self._points[1 - MOST_KNOWN :], equations]

    def nearest(self, equations: list[SweepEquations]) -> tuple[float, list[SweepEquations]]:
        """Return how far the nearest point is, as `NEAR`, and the point; infinitely far where there is none."""
        if any(one.columns is None for one in equations):
            return np.inf, []
        found: tuple[float, list[SweepEquations]] = (np.inf, [])
        for point in self._points:
            pairs = zip(equations, point, strict=True)
            away = max(here.changed_from(there) for here, there in pairs)
            if away < found[0]:
                found = away, point
        return found


@dataclass(frozen=True)
class _Trial:
    state: GapState
    equations: list[SweepEquations]
    objective: float
    readings: Real
    smoothness: float
    prior: float
    declared: float
    known: list[SweepEquations] | None
    """Equations of the point at which derivatives by declared quantities were computed; None without such."""
    away: float = 0.0
    """Relative change of the derivative by log E since then."""
    borrowed: bool = False
    """Whether they were computed by another fit."""
    whole: bool = True
    """Whether `equations` have derivatives by declared quantities; a step that is refused needs none."""
    damping: float = 0.0
    """With which to go on from here: where less was refused, it would be refused again."""

    @property
    def stale(self) -> bool:
        """Whether derivatives by declared quantities are those of another point."""
        return self.known is not None and self.known is not self.equations

    def under(self, free: FreeParameters) -> "_Trial":
        """Return the same point, linearised once, with its priors weighed anew."""
        prior, declared = free.penalties(free.read(self.state.on))
        data = self.objective - self.prior - self.declared
        return replace(self, objective=data + prior + declared, prior=prior, declared=declared)


def fit_gap(
    model: TwinModel,
    sweeps: GapSweeps,
    start: GapState,
    effects: Sequence[str],
    executor: Executor,
    *,
    gain_free: bool = True,
    laws_free: bool = True,
    declared_free: bool = True,
    target: float = SETTLED,
    most_steps: int = MOST_STEPS,
    enough: float = np.inf,
    margin: float = PREDICTION_MARGIN,
    enough_held: float = np.inf,
    known: KnownDerivatives | None = None,
) -> GapFit:
    """Fit laws, readings, gains, declared quantities and all parameters of `effects`.

    Other effects of `start` are held.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    start : GapState
        Start values, with all effects that are on.
    effects : sequence of str
        Effects whose parameters are fitted.
    executor : Executor
        Sweeps are linearised on it.
    gain_free, laws_free : bool
        Whether gains and declared quantities, and laws, are fitted; for held-out data they may be kept from
        another fit.
    declared_free : bool
        Whether declared quantities are fitted where gains are; for a fit that leaves much.
    target : float
        Predicted decrease of chi2 at which to stop, for a fit that reaches the noise.
    most_steps : int
        Largest number of linearisations.
    enough : float
        The fit stops, unsettled, once it is predicted not to reach this objective, minus twice a log evidence.
    margin : float
        Times the predicted decrease that is allowed for this.
    enough_held : float
        The fit stops, unsettled, if its objective is above this before declared quantities are freed.
    known : KnownDerivatives, optional
        By declared quantities, of earlier fits of the same model to the same sweeps: used where they hold.

    Returns
    -------
    GapFit

    Raises
    ------
    ValueError
        Where the model cannot be evaluated at the start.
    """
    free = FreeParameters.of(model.cards, effects, model.tolerance_cards if gain_free and declared_free else {})
    start = start.with_tolerances(model.tolerance_cards)
    values = np.clip(free.read(start.on), free.low, free.high)
    start = replace(start, laws=clipped_laws(model.box, start.laws)).with_values(free.write(start.on, values))
    held = FreeParameters.of(model.cards, effects, {}) if free.tolerances else free
    known = KnownDerivatives() if known is None else known
    descent = _Descent(model, sweeps, executor, gain_free, laws_free, target, most_steps, enough, margin, known)
    passes, left, done, before = 0, 1.0, False, None
    best = descent.evaluate(start, held)
    if free.tolerances and best.objective > ROUGH * sweeps.numbers:
        best, _, passes = replace(descent, target=ROUGHLY_SETTLED).along(best, held)
        before = Held(best.state, best.objective)
        if best.objective > enough_held:
            return replace(_result(sweeps, best, held, gain_free, laws_free, False, passes), held=before)
    for turn in range(ROUNDS if free.tolerances else 1):
        if free.tolerances:
            left = _left(sweeps, best)
            free = replace(free, trusted=sweeps.overstated * left)
            # only the first point was linearised without the declared quantities' tangents
            best = best.under(free) if turn else descent.freed(best, free)
        best, done, more = descent.to_the_end(best, free)
        passes += more
        # what the fit leaves weighs the tolerances: once it leaves much less, they are fitted again
        if _left(sweeps, best) > FELL * left:
            break
    found = _result(sweeps, best, free, gain_free, laws_free, done, passes)
    return replace(found, held=before)


def _left(sweeps: GapSweeps, at: _Trial) -> float:
    """Return chi2 per number without the declared quantities' own, at least 1."""
    return max(1.0, (at.objective - at.declared) / sweeps.numbers)


@dataclass(frozen=True)
class _Descent:
    """Levenberg-Marquardt iterations to some sweeps; parameters as of `fit_gap`."""

    model: TwinModel
    sweeps: GapSweeps
    executor: Executor
    gain_free: bool
    laws_free: bool
    target: float
    most_steps: int
    enough: float
    margin: float
    known: KnownDerivatives

    def freed(self, held: _Trial, free: FreeParameters) -> _Trial:
        """Free the declared quantities of a point that was linearised without them."""
        away, there = self.known.nearest(held.equations)
        if away > NEAR:
            return self.evaluate(held.state, free)
        return replace(self._joined(held.state, free, held.equations, there, away), borrowed=True)

    def to_the_end(self, best: _Trial, free: FreeParameters) -> tuple[_Trial, bool, int]:
        """Iterate from `best`: return the final point, whether it settled, and the number of linearisations.

        Near the data, and with derivatives of another fit, a point at which it settles with known derivatives is
        linearised by everything, and the iteration goes on from there until little is left to gain.
        """
        best, done, passes = self.along(best, free)
        near = not self._leaves_more(best) if free.effects else not self._rough(best)
        if best.away > NEAR_ENOUGH and done and (near or best.borrowed) and passes < self.most_steps:
            rest = replace(self, target=AGAIN * self.target) if near else self
            best = replace(self.evaluate(best.state, free), damping=best.damping)
            best, done, more = rest.along(best, free)
            passes += more
        return best, done, passes

    def along(self, best: _Trial, free: FreeParameters) -> tuple[_Trial, bool, int]:
        """Do what `to_the_end` does, with known derivatives of declared quantities wherever they hold."""
        damping, share, passes, done, refused, last = best.damping, 1.0, 1, False, False, np.inf
        while passes < self.most_steps:
            step = self._step(best, free, damping)
            settled, rough = self._settled(best, free), self._rough(best)
            idle = free.tolerances and not free.effects and step.idle(self.sweeps)
            if step.predicted_decrease < settled or idle:
                done = True
                break
            if damping == 0.0 and best.objective - self.margin * step.predicted_decrease > self.enough:
                break
            passes += 1
            if damping == 0.0 and share == 1.0:
                if best.stale and step.predicted_decrease > SLOW * last:
                    best, last = self.evaluate(best.state, free), np.inf
                    continue
                last = step.predicted_decrease
            trial = self._tried(best, free, step.times(share))
            if trial is not None and share == 1.0 and damping == 0.0 and _bends(best, trial, step):
                curved = self._step(step.bent(best, trial), free, damping)
                again = None
                if curved.predicted_decrease < MOST_BENT * step.predicted_decrease:
                    passes += 1
                    again = self._tried(best, free, curved)
                if again is not None and again.objective < trial.objective:
                    trial = again
            if trial is not None and trial.objective <= best.objective:
                fallen = best.objective - trial.objective
                damped = refused or damping > 0.0 or share < 1.0
                # less damping than was refused a moment ago would be refused again
                lower = damping if refused else 0.0 if damping < 1e-3 else damping / 10.0
                best = trial if trial.whole else self.evaluate(trial.state, free)
                damping, share, refused = lower, 1.0, False
                # at a bound, and where something is missing, predictions are not accurate
                little = (1.0 if rough and free.tolerances else 0.3) * settled
                if fallen < little or (damped and self._creeps(best, free, fallen)):
                    done = True
                    break
            elif step.predicted_decrease < 10.0 * settled:
                done = True
                break
            elif best.away > NEAR_ENOUGH:
                # derivatives from elsewhere may be why: a sensor beside its place stayed 0.3 mm from it, damped
                best, last, share = self.evaluate(best.state, free), np.inf, 1.0
            elif share == 1.0 and damping == 0.0 and not _astray(best, trial):
                # shorten the step first: with nearly collinear unknowns, damping changes its direction
                share = BACKTRACKED
            else:
                damping, share, refused = max(10.0 * damping, 1e-2), 1.0, True
                if damping > 1e6:
                    break
        return replace(best, damping=damping), done, passes

    def evaluate(self, state: GapState, free: FreeParameters) -> _Trial:
        """Linearise at a state."""
        equations = self._linearised(state, free.names)
        kept = free.tolerances and all(one.columns is not None for one in equations)
        if kept:
            self.known.keep(equations)
        return self._trial(state, free, equations, equations if kept else None)

    def _near(self, state: GapState, free: FreeParameters, best: _Trial) -> _Trial:
        """Linearise at a state, with known derivatives by declared quantities; where they do not hold, without."""
        if best.known is None:
            return self.evaluate(state, free)
        parts = self._linearised(state, free.names[: free.effects])
        pairs = list(zip(parts, best.known, strict=True))
        away = max(part.changed_from(there) for part, there in pairs)
        if away > NEAR:
            return replace(self._trial(state, free, parts, None), whole=False)
        return replace(self._joined(state, free, parts, best.known, away), borrowed=best.borrowed)

    def _joined(
        self,
        state: GapState,
        free: FreeParameters,
        parts: list[SweepEquations],
        known: list[SweepEquations],
        away: float,
    ) -> _Trial:
        """Join derivatives by declared quantities that were computed at a point `away`."""
        count, shared = free.tolerances, GLOBAL + len(state.log_gain)
        joined = [part.with_last(there, count, shared) for part, there in zip(parts, known, strict=True)]
        return replace(self._trial(state, free, joined, known), away=away)

    def _trial(
        self,
        state: GapState,
        free: FreeParameters,
        equations: list[SweepEquations],
        known: list[SweepEquations] | None,
    ) -> _Trial:
        readings = (state.away / self.sweeps.reading_sigma) ** 2
        prior, declared = free.penalties(free.read(state.on))
        errors = self.sweeps.smoothness.errors(state.tilt, state.bend)
        smoothness = float(errors @ errors)
        objective = sum(e.chi2 for e in equations) + float(readings.sum()) + smoothness + prior + declared
        return _Trial(state, equations, objective, readings, smoothness, prior, declared, known)

    def _linearised(self, state: GapState, names: Sequence[tuple[str, str]]) -> list[SweepEquations]:
        tangents: list[Tangent] = [(name, parameter, state.on[name]) for name, parameter in names]
        return linearise_all(self.model, self.sweeps, state, tangents, self.executor, keep=True)

    def _settled(self, at: _Trial, free: FreeParameters) -> float:
        """Predicted decrease at which a fit has settled at a point."""
        # where the residual is many sigma, the tolerance grows: fractions of a nat need no other linearisation
        settled = self.target * max(1.0, at.objective / self.sweeps.numbers)
        if free.tolerances and free.effects:
            settled = max(settled, OF_EXCESS * (at.objective - self.sweeps.numbers))
        if self._rough(at) and (free.tolerances or not free.effects):
            settled = max(settled, (SETTLED_FAR if free.effects else SETTLED_FAR_ALONE) * at.objective)
        return settled

    def _tried(self, best: _Trial, free: FreeParameters, step: "_Step") -> _Trial | None:
        """Evaluate a step; None where the model refuses the point, which counts as too long a step."""
        try:
            trial = self._near(_moved(self.model, self.sweeps, best.state, free, step), free, best)
        except ValueError:
            return None
        return trial if np.isfinite(trial.objective) else None

    def _step(self, at: _Trial, free: FreeParameters, damping: float) -> "_Step":
        return _Step.of(self.sweeps, at, free, damping, self.gain_free, self.laws_free)

    def _creeps(self, at: _Trial, free: FreeParameters, fallen: float) -> bool:
        """Whether declared quantities only follow what is missing: a damped step takes little of what is left.

        Without effects a fit goes on: what it leaves is what evidence is measured from.
        """
        left = at.objective - self.sweeps.numbers
        return bool(free.tolerances and free.effects) and self._leaves_more(at) and fallen < CREEPS * left

    def _leaves_more(self, at: _Trial) -> bool:
        """Whether a point leaves more than noise."""
        return at.objective > LEAVES_NOISE * self.sweeps.numbers

    def _rough(self, at: _Trial) -> bool:
        """Whether a fit that could move declared quantities leaves much."""
        fitted = bool(self.model.tolerance_cards) and self.gain_free
        return fitted and at.objective > ROUGH * self.sweeps.numbers


@dataclass(frozen=True)
class _Step:
    """A step of gains and parameters (I + P,), of each sweep's own columns (T, 10), and of the laws."""

    common: Real
    own: Real
    local: LocalStep
    predicted_decrease: float

    @classmethod
    def of(
        cls,
        sweeps: GapSweeps,
        at: _Trial,
        free: FreeParameters,
        damping: float,
        gain_free: bool,
        laws_free: bool,
    ) -> "_Step":
        head = schur_complement(sweeps, at.equations, at.state, damping=damping, frozen=not laws_free)
        values, gains = free.read(at.state.on), np.zeros(head.gains)
        precision = np.concatenate([gains, free.precision(values)])
        matrix = head.matrix + np.diag(precision)
        gradient = head.gradient - precision * np.concatenate([gains, values - free.centre])
        reach = np.where(free.shapes, SHAPE_STEP * free.sigma, np.inf)
        low = np.concatenate([gains - 0.5, np.maximum(free.low - values, -reach)])
        high = np.concatenate([gains + 0.5, np.minimum(free.high - values, reach)])
        moving = np.concatenate([head.seen & gain_free, ~free.shapes])
        step = bounded_step(matrix, gradient, moving, low, high, damping)
        standing = free.standing(values, step[head.gains :])
        if standing.any():
            moving = np.concatenate([head.seen & gain_free, ~free.shapes | standing])
            step = bounded_step(matrix, gradient, moving, low, high, damping)
        predicted_decrease = head.predicted_decrease + float(2.0 * gradient @ step - step @ matrix @ step)
        follow = head.follow(step)
        return cls(step, head.columns @ follow, head.parts(follow), predicted_decrease)

    def times(self, share: float) -> "_Step":
        return replace(self, common=share * self.common, local=self.local.times(share), own=share * self.own)

    def idle(self, sweeps: GapSweeps) -> bool:
        """Whether it changes chi2 by less than its scatter, and the laws by less than tolerances leave open."""
        if self.predicted_decrease > IDLE * np.sqrt(2.0 * sweeps.numbers):
            return False
        return bool((np.abs(self.local.laws) < IDLE_LAWS).all())

    def bent(self, begun: _Trial, ended: _Trial) -> _Trial:
        """Return where the step began, with equations that know where it ended."""
        parts = zip(begun.equations, ended.equations, self.own, strict=True)
        equations = [e.bent(np.concatenate([own, self.common]), then.residual) for e, then, own in parts]
        return replace(begun, equations=equations)


def _astray(begun: _Trial, ended: _Trial | None) -> bool:
    """Whether a step went so far that a shorter one in the same direction is none."""
    return ended is not None and ended.objective > ASTRAY * begun.objective


def _bends(begun: _Trial, ended: _Trial, step: _Step) -> bool:
    """Whether a step fell short of what first order promised, so that a second look along it pays."""
    if any(one.columns is None for one in begun.equations):
        return False
    return begun.objective - ended.objective < BENT * step.predicted_decrease


def _moved(model: TwinModel, sweeps: GapSweeps, state: GapState, free: FreeParameters, step: _Step) -> GapState:
    gains, local = len(state.log_gain), step.local
    values = free.read(state.on) + step.common[gains:]
    laws = clipped_laws(model.box, state.laws + np.clip(local.laws, -LARGEST_STEP, LARGEST_STEP))
    tilt, bend = sweeps.smoothness.deviations(local.errors)
    moved = replace(
        state,
        laws=laws,
        tilt=state.tilt + tilt,
        bend=state.bend + bend,
        away=state.away + local.away,
        log_gain=state.log_gain + step.common[:gains],
    )
    return moved.with_values(free.write(state.on, np.clip(values, free.low, free.high)))


def _result(
    sweeps: GapSweeps,
    at: _Trial,
    free: FreeParameters,
    gain_free: bool,
    laws_free: bool,
    settled: bool,
    passes: int,
) -> GapFit:
    values = free.read(at.state.on)
    wall = (values <= free.low) | (values >= free.high)
    head = schur_complement(sweeps, at.equations, at.state, frozen=not laws_free)
    fitted = free.effects + int((head.seen & gain_free).sum())
    if laws_free:  # one error is fitted per reading and per declared quantity: numbers and unknowns cancel
        fitted += 3 * len(sweeps.groups.size)
    dof = float(sweeps.numbers - fitted)
    excess = max((at.objective - at.prior) / dof, 1.0) * sweeps.overstated_with(free.moved_error(values))
    stated = schur_complement(sweeps, at.equations, at.state, weight=1.0 / excess, frozen=not laws_free)
    return GapFit(
        state=at.state,
        free=free,
        information=head.without_gains(gain_free).matrix,
        noise=Uncertainty.of(head, free, values, gain_free),
        stated=Uncertainty.of(stated, free, values, gain_free),
        chi2=np.array([(np.abs(e.residual) ** 2).sum(-1) for e in at.equations]),
        readings=at.readings if laws_free else np.zeros(sweeps.count),
        smoothness=at.smoothness if laws_free else 0.0,
        dof=dof,
        prior=at.prior,
        declared=at.declared,
        residual=np.array([e.residual for e in at.equations]),
        predicted=np.array([e.predicted for e in at.equations]),
        alone=np.array([_alone(e, p.source) for e, p in zip(at.equations, sweeps.points, strict=True)]),
        settled=settled,
        on_wall=tuple(name for name, there in zip(free.names, wall, strict=True) if there),
        passes=passes,
    )


def _alone(equations: SweepEquations, source: int) -> Real:
    """Return a sweep's information matrix of its material and its gain, (4, 4)."""
    columns = [*range(VALUES.stop), GLOBAL + source]
    return equations.matrix[np.ix_(columns, columns)]
