"""Which of some effects it was, by two campaigns: the one that left the question open, and the planned one.

Each effect is fitted to each campaign alone. Laws, readings and declared quantities are each campaign's own; the
effect's amplitudes are the same in both. With estimates a and b of covariances A and B, the evidence of both is
the product of theirs times N(a - b; 0, A + B)/p(c), p the prior at the joint estimate c (Laplace's approximation).

Measurements ranked by what they are expected to settle per hour of a laboratory.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Parameter, Values
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.state import GapState
from analysis.gap.plan.measurement import Measurement
from analysis.gap.plan.separation import ENOUGH, Question
from analysis.gap.search.score_test import score_test
from analysis.gap.thresholds import CLASS_NATS
from analysis.twin_model import TwinModel

NOTHING = "nothing"
STARTS = 4
"""Sites from which an effect with a place is fitted where none is known, the best to first order."""


@dataclass(frozen=True)
class Told:
    """What one campaign says of one effect.

    Attributes
    ----------
    effect : str
        `NOTHING` for the twin without any of them.
    cards : tuple of Parameter
        Of its P amplitudes.
    values : (P,) ndarray
        Of the amplitudes.
    covariance : (P, P) ndarray
    log_evidence : float
        Of the twin with it, nats, reduced for the twin's own error and for what the best fit leaves.
    """

    effect: str
    cards: tuple[Parameter, ...]
    values: Real
    covariance: Real
    log_evidence: float

    def beside(self, other: "Told", turned: bool) -> "Told":
        """Join what another campaign says of the same effect, whose amplitudes are `turned` there or not."""
        sign = -1.0 if turned else 1.0
        apart, spread = self.values - sign * other.values, self.covariance + other.covariance
        weight = np.linalg.solve(spread, apart)
        joint = self.values - self.covariance @ weight
        sigma = np.array([card.sigma for card in self.cards])
        prior = -0.5 * float(((joint / sigma) ** 2).sum()) - float(np.log(sigma).sum())
        agree = -0.5 * float(apart @ weight) - 0.5 * float(np.linalg.slogdet(spread)[1])
        covariance = self.covariance - self.covariance @ np.linalg.solve(spread, self.covariance)
        nats = self.log_evidence + other.log_evidence + agree - prior
        return Told(self.effect, self.cards, joint, covariance, nats)

    def read(self, effect: str, parameter: str, value: float, sigma: float) -> float:
        """Log likelihood of a parameter read by hand; without its effect it would be zero.

        Parameters
        ----------
        effect, parameter : str
        value, sigma : float
            Read, and its standard deviation.

        Returns
        -------
        float
            Nats, up to a constant.
        """
        expected, spread = 0.0, sigma
        if effect == self.effect:
            place = [card.name for card in self.cards].index(parameter)
            expected = float(self.values[place])
            spread = float(np.hypot(sigma, np.sqrt(self.covariance[place, place])))
        return float(-0.5 * ((value - expected) / spread) ** 2 - np.log(spread))


@dataclass(frozen=True)
class Decision:
    """Answer to a question.

    Attributes
    ----------
    nats : mapping of str to float
        Log evidence of each effect, up to a common constant.
    """

    nats: Mapping[str, float]

    @property
    def settled(self) -> str | None:
        """The effect that it was, or `NOTHING`; None where another one is within a factor of twenty."""
        best, *others = sorted(self.nats, key=lambda name: -self.nats[name])
        if others and self.nats[best] - self.nats[others[0]] < CLASS_NATS:
            return None
        return best


def told(
    model: TwinModel, sweeps: GapSweeps, base: GapState, effects: Sequence[str], executor: Executor
) -> tuple[Told, ...]:
    """Fit the twin without, and with each of some effects, alone beside the others of `base`, to one campaign.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    base : GapState
        From which the fits start.
    effects : sequence of str
    executor : Executor
        Sweeps are linearised on it.

    Returns
    -------
    tuple of Told
        `NOTHING` first.
    """
    rest = {name: values for name, values in base.effects.items() if name not in effects}
    plain = fit_gap(model, sweeps, base.with_effects(rest), tuple(rest), executor)
    fits = [_best(model, sweeps, base, plain, rest, model.cards[name], executor) for name in effects]
    left = min(max(1.0, fit.total / fit.dof) for fit in (plain, *fits))
    errors = left * sweeps.overstated
    nothing = Told(NOTHING, (), np.zeros(0), np.zeros((0, 0)), plain.log_evidence / errors)
    named = zip(effects, fits, strict=True)
    return (nothing, *(_told(model.cards[name], fit, errors) for name, fit in named))


def decided(
    first: Sequence[Told],
    second: Sequence[Told] = (),
    turned: Sequence[str] = (),
    readings: Sequence[tuple[str, str, float, float]] = (),
) -> Decision:
    """Weigh effects by one or two campaigns, and by what was read by hand.

    Parameters
    ----------
    first, second : sequence of Told
        Of the same effects in the same order; `second` may be empty.
    turned : sequence of str
        Effects whose amplitudes have the other sign in the second campaign.
    readings : sequence of (effect, parameter, value, standard deviation)

    Returns
    -------
    Decision
    """
    joint = list(first)
    if second:
        joint = [a.beside(b, a.effect in turned) for a, b in zip(first, second, strict=True)]
    return Decision({one.effect: one.log_evidence + sum(one.read(*r) for r in readings) for one in joint})


def _best(
    model: TwinModel,
    sweeps: GapSweeps,
    base: GapState,
    plain: GapFit,
    rest: Mapping[str, Values],
    card: EffectCard,
    executor: Executor,
) -> GapFit:
    """Fit an effect from its values in `base`, or from the best of its sites and of the places of others there."""
    known = base.effects.get(card.name)
    if known is not None:
        starts, state = [dict(known)], base
    else:
        screening = score_test(model, sweeps, plain, executor, effects=(card.name,), standing=base.effects)
        best = sorted(screening.at_sites(card.name), key=lambda one: -one.gain)[:STARTS]
        starts = [card.zero(screening.columns[one.columns[0]].shapes) for one in best]
        state = plain.state
    names = (*rest, card.name)
    fits = [
        fit_gap(model, sweeps, state.with_effects({**rest, card.name: start}), names, executor) for start in starts
    ]
    return max(fits, key=lambda fit: fit.log_evidence)


def _told(card: EffectCard, fit: GapFit, errors: float) -> Told:
    wanted = {(card.name, p.name) for p in card.amplitudes}
    places = [k for k, name in enumerate(fit.free.names) if name in wanted]
    values = np.array([fit.state.effects[card.name][p.name] for p in card.amplitudes])
    covariance = fit.stated.own[np.ix_(places, places)]
    return Told(card.name, card.amplitudes, values, covariance, fit.log_evidence / errors)


BLIND = 0.2
"""Weight of a blind spot: nobody saw the effect; of one that was found only the name is open."""


@dataclass(frozen=True)
class Expected:
    """What one measurement is expected to say.

    Attributes
    ----------
    measurement : Measurement
    before, after : tuple of float
        Separation of the answers to each question by the recorded campaign, and with the measurement, sigma.
    weights : tuple of float
        Of the questions.
    """

    measurement: Measurement
    before: tuple[float, ...]
    after: tuple[float, ...]
    weights: tuple[float, ...]

    @property
    def gain(self) -> float:
        """Separation that it adds, each question counted up to `ENOUGH`, and by its weight, sigma."""
        rows = zip(self.weights, self.before, self.after, strict=True)
        return sum(weight * max(min(after, ENOUGH) - min(before, ENOUGH), 0.0) for weight, before, after in rows)

    @property
    def per_hour(self) -> float:
        """The same per hour."""
        return self.gain / self.measurement.hours

    @property
    def margin(self) -> float:
        """Smallest separation of what it settles, sigma: of two as good per hour the surer is better."""
        return min((self.after[k] for k in self.settles), default=0.0)

    @property
    def settles(self) -> tuple[int, ...]:
        """Questions that it settles and the recorded campaign does not, by their places."""
        pairs = enumerate(zip(self.before, self.after, strict=True))
        return tuple(k for k, (before, after) in pairs if before < ENOUGH <= after)


@dataclass(frozen=True)
class Plan:
    """Questions, and measurements that may answer them.

    Attributes
    ----------
    questions : tuple of Question
    ranked : tuple of Expected
        Most separation per hour first; of those that settle as much in more than one place, the best place only.
    notes : tuple of str
        Measurements that could not be simulated, for people.
    """

    questions: tuple[Question, ...]
    ranked: tuple[Expected, ...]
    notes: tuple[str, ...] = ()

    @property
    def winner(self) -> Expected | None:
        """The measurement to be made next; None where none adds anything."""
        return self.ranked[0] if self.ranked and self.ranked[0].gain > 0.0 else None


def weights(questions: Sequence[Question]) -> tuple[float, ...]:
    """Return what each question counts."""
    return tuple(BLIND if one.rival is None else 1.0 for one in questions)


def ranked(questions: Sequence[Question], expected: Sequence[Expected], notes: Sequence[str] = ()) -> Plan:
    """Rank measurements; of each kind that has several places, the best place is kept.

    A measurement that settles a question comes before all that settle none: half an answer an hour is none.

    Parameters
    ----------
    questions : sequence of Question
    expected : sequence of Expected
    notes : sequence of str

    Returns
    -------
    Plan
    """
    ordered = sorted(expected, key=lambda one: (not one.settles, -round(one.per_hour, 1), -one.margin))
    best: dict[str, Expected] = {}
    for one in ordered:
        best.setdefault(one.measurement.key, one)
    return Plan(tuple(questions), tuple(best.values()), tuple(notes))
