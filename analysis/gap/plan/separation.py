"""What a comparison leaves open, and how far a campaign sets the answers apart, in standard deviations.

Linearised at the twin as found. One effect is taken as true with the values found; the other imitates it as
well as it can, with all else free: the square root of the expected difference of chi2 is the distance. The smaller
of both directions counts. Signals whose cosine stays above `CLASS_COSINE` are one class however large they are, so
that a distance counts in proportion to its share of the signal, up to `ENOUGH` at that cosine.

What a campaign says about some effects, laws, readings, gains and declared quantities eliminated.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from scipy.linalg import eigh

from analysis.arrays import Real
from analysis.effect_card import EffectCard, Values
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.sites import sites_beside
from analysis.gap.fitting.state import GapState
from analysis.gap.plan.measurement import Readings
from analysis.gap.report import GapReport
from analysis.gap.search.score_test import Column
from analysis.gap.thresholds import CLASS_COSINE, LEAST_KEPT
from analysis.twin_model import Tangent, TwinModel


@dataclass(frozen=True)
class Information:
    """Information on the parameters of some effects.

    Attributes
    ----------
    columns : tuple of Column
        Parameters of effects that are on, shapes included, and amplitudes of the others at each of their sites.
    matrix : (Q, Q) ndarray
        Inverse covariance, everything else eliminated; in units of all errors: noise, the twin's own, and what
        the fit left.
    known : (Q, Q) ndarray
        The same with the plate's temperatures exactly known, as observability counts it.
    raw : (Q, Q) ndarray
        Before the elimination.
    """

    columns: tuple[Column, ...]
    matrix: Real
    known: Real
    raw: Real

    def of(self, effect: str, site: int | None = None) -> list[int]:
        """Find the indices of an effect's columns, at one of its sites or at all."""
        return [i for i, c in enumerate(self.columns) if c.effect == effect and site in (None, c.site)]

    def sites(self, effect: str) -> list[int]:
        """Sites of an effect."""
        return sorted({self.columns[i].site for i in self.of(effect)})

    def beside(self, other: Self) -> Self:
        """Add what another campaign says, whose laws, readings and declared quantities are its own."""
        if [(c.effect, c.site, c.card.name) for c in self.columns] != [
            (c.effect, c.site, c.card.name) for c in other.columns
        ]:
            raise ValueError("information on different parameters cannot be added")
        return replace(
            self,
            matrix=self.matrix + other.matrix,
            known=self.known + other.known,
            raw=self.raw + other.raw,
        )

    def turned(self, effects: Sequence[str]) -> Self:
        """Return it for a campaign in which the amplitudes of `effects` have the other sign."""
        sign = np.array([-1.0 if c.effect in effects and not c.card.shape else 1.0 for c in self.columns])
        both = sign[:, None] * sign
        return replace(self, matrix=self.matrix * both, known=self.known * both, raw=self.raw * both)


@dataclass(frozen=True)
class LinearisedCampaign:
    """Sweeps linearised for the parameters in question; channels can be left out without doing it again.

    Attributes
    ----------
    sweeps : GapSweeps
    state : GapState
    white : tuple of WhitenedSweep
    columns : tuple of Column
        First those of `nuisances`, then those in question.
    nuisances : int
        Number of parameters of declared quantities, and of effects that are on and not in question.
    left : float
        chi2 per number that the fit left, at least 1: the new campaign will leave as much.
    """

    sweeps: GapSweeps
    state: GapState
    white: tuple[WhitenedSweep, ...]
    columns: tuple[Column, ...]
    nuisances: int
    left: float

    @classmethod
    def at(
        cls,
        model: TwinModel,
        sweeps: GapSweeps,
        state: GapState,
        fit: GapFit,
        asked: Sequence[str],
        executor: Executor,
    ) -> Self:
        """Linearise sweeps with the tangents of all that is free and of the effects in question.

        Parameters
        ----------
        model : TwinModel
        sweeps : GapSweeps
            Recorded, or planned: then only their noise counts.
        state : GapState
        fit : GapFit
            Of the recorded sweeps: says how far declared quantities are trusted, and what is left.
        asked : sequence of str
            Effects in question.
        executor : Executor
            Sweeps are linearised on it.

        Returns
        -------
        LinearisedCampaign

        Raises
        ------
        ValueError
            Where the model refuses the state.
        """
        columns, nuisances = _columns(model, state, fit.free.trusted, asked)
        cards = {**model.tolerance_cards, **model.cards}
        tangents: list[Tangent] = [
            (c.effect, c.card.name, state.on.get(c.effect, cards[c.effect].zero(c.shapes))) for c in columns
        ]
        white = whiten_all(model, sweeps, state, tangents, executor)
        compressed = tuple(
            replace(one, coefficients=w.predicted) for one, w in zip(sweeps.compressed, white, strict=True)
        )
        left = max(1.0, fit.total / fit.dof)
        return cls(replace(sweeps, compressed=compressed), state, tuple(white), columns, nuisances, left)

    def information(
        self, channels: Sequence[int] | None = None, sharper: Mapping[tuple[str, str], float] | None = None
    ) -> Information:
        """Eliminate all that is not in question.

        Parameters
        ----------
        channels : sequence of int, optional
            Outputs that are recorded; all by default.
        sharper : mapping, optional
            Standard deviations of parameters of declared quantities that are measured again.

        Returns
        -------
        Information
        """
        taken = np.isin(np.arange(len(self.sweeps.channels)), self._all if channels is None else channels)
        rows = self.sweeps.rows & taken[:, None]
        seen = replace(self.sweeps, rows=rows)
        white = [replace(one, white=one.white * rows[k]) for k, one in enumerate(self.white)]
        equations = [one.equations() for one in white]
        errors = seen.overstated * self.left
        head = schur_complement(seen, equations, self.state, weight=1.0 / errors)
        known = schur_complement(seen, equations, self.state, weight=1.0 / errors, readings=False)
        n, gains = self.nuisances, head.gains
        precision = [_precision(one, sharper or {}) for one in self.columns[:n]]
        return Information(
            self.columns[n:],
            _without(head.without_gains().matrix, n, np.array(precision)),
            _without(known.without_gains().matrix, n, np.array(precision)),
            head.raw[gains + n :, gains + n :],
        )

    @property
    def _all(self) -> Sequence[int]:
        return range(len(self.sweeps.channels))


SAME = {"plate_lag": "thermal_lag"}
"""Declared quantities that are an effect, too: of the plate's lag, which has a tolerance on one ramp, two tell."""


def _columns(
    model: TwinModel, state: GapState, trusted: float, asked: Sequence[str]
) -> tuple[tuple[Column, ...], int]:
    """Return the columns, and how many of them are not in question."""
    on, nuisances = state.on, []
    for name, card in model.tolerance_cards.items():
        if name in on and SAME.get(name) not in asked:
            nuisances += [
                Column(name, 0, replace(p, sigma=p.sigma * trusted**-0.5), on[name][p.name], {})
                for p in card.parameters
            ]
    for name in state.effects:
        if name not in asked:
            nuisances += _on(model.cards[name], on[name])
    wanted, sites = list[Column](), sites_beside(model.cards, on)
    for name in dict.fromkeys(asked):
        card = model.cards[name]
        if name in on:
            wanted += _on(card, on[name])
        else:
            wanted += [
                Column(name, k, p, 0.0, site) for k, site in enumerate(sites[name]) for p in card.amplitudes
            ]
    return (*nuisances, *wanted), len(nuisances)


def _on(card: EffectCard, values: Mapping[str, float]) -> list[Column]:
    shapes = {p.name: values[p.name] for p in card.parameters if p.shape}
    return [Column(card.name, 0, p, values[p.name], shapes) for p in card.parameters]


def _precision(column: Column, sharper: Mapping[tuple[str, str], float]) -> float:
    sigma = sharper.get((column.effect, column.card.name), np.inf)
    return float(column.card.sigma**-2.0 + sigma**-2.0)


def _without(matrix: Real, count: int, precision: Real) -> Real:
    """Eliminate the first `count` unknowns under their priors."""
    if not count:
        return matrix
    scale = 1.0 / np.sqrt(precision)
    block = matrix[:count, :count] * scale[:, None] * scale + np.eye(count)
    cross = scale[:, None] * matrix[:count, count:]
    left = matrix[count:, count:] - cross.T @ np.linalg.solve(block, cross)
    return np.asarray(0.5 * (left + left.T))


RIVALS = 3
"""Rivals of one effect that are asked about: those further down are less like it."""


@dataclass(frozen=True)
class Question:
    """One thing that a comparison left open.

    Attributes
    ----------
    effect : str
        Found, or not observable.
    rival : str or None
        Effect that the data cannot tell from it; None where the question is whether `effect` is there.
    values : mapping
        Of `effect` as found; empty where there is no rival: then one standard deviation of its prior counts.
    """

    effect: str
    rival: str | None = None
    values: Values = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """Return ``look-alike`` or ``blind spot``."""
        return "blind spot" if self.rival is None else "look-alike"

    @property
    def effects(self) -> tuple[str, ...]:
        """Return the effects that it is about."""
        return (self.effect,) if self.rival is None else (self.effect, self.rival)


ENOUGH = 5.0
"""Separation at which a question counts as settled, sigma: the difference in chi2 then is 25 +- 10, and a class is
left at 6 (`CLASS_NATS`)."""
LEAST_SHARE = float(np.sqrt(1.0 - CLASS_COSINE**2))
"""Share of a signal that must be its own for another name not to be of its class."""
NO_READINGS: Readings = {}


def separation(
    question: Question,
    information: Information,
    readings: Readings = NO_READINGS,
    recorded: Information | None = None,
) -> float:
    """Separation of the answers to a question.

    Parameters
    ----------
    question : Question
    information : Information
        Of one campaign, or the sum of several.
    readings : mapping
        Of what is measured by hand besides.
    recorded : Information, optional
        Of the recorded campaign, in which the rival imitates the effect; `information` by default.

    Returns
    -------
    float
        Standard deviations: of the two effects' signals, or of one prior standard deviation of an effect in
        question against nothing. 0 for an effect of which the campaign keeps less than what is observable.
    """
    if question.rival is None:
        return _presence(question.effect, information, readings)
    values = question.values
    mine = [i for i in information.of(question.effect) if not information.columns[i].card.shape]
    found = np.array([values[information.columns[i].card.name] for i in mine])
    both_ways = []
    for site in information.sites(question.rival):
        theirs = information.of(question.rival, site)
        rival = _imitation(recorded or information, mine, found, theirs)
        one_way = _left(information, mine, found, theirs, readings)
        other_way = _left(information, theirs, rival, mine, readings)
        both_ways.append(min(one_way, other_way))
    return min(both_ways)


def _left(information: Information, true: list[int], values: Real, others: list[int], readings: Readings) -> float:
    """Distance that others, and what is read by hand, leave of the signal of `true` with `values`."""
    matrix = information.matrix
    power = float(values @ matrix[np.ix_(true, true)] @ values)
    pull = matrix[np.ix_(others, true)] @ values
    precision = [_prior(information, i) + _read(information, i, readings) for i in others]
    explained = float(pull @ np.linalg.solve(matrix[np.ix_(others, others)] + np.diag(precision), pull))
    measured = sum(v**2 * _read(information, i, readings) for i, v in zip(true, values, strict=True))
    left, whole = max(power - explained, 0.0) + float(measured), power + float(measured)
    if whole <= 0.0:
        return 0.0
    share = np.sqrt(left / whole)  # the sine of the angle between both signals
    distance = float(np.sqrt(left))
    return distance if share >= LEAST_SHARE else min(distance, ENOUGH * float(share) / LEAST_SHARE)


def _imitation(information: Information, true: list[int], values: Real, others: list[int]) -> Real:
    """Values of others that imitate `true` with `values` best."""
    matrix = information.matrix
    block = matrix[np.ix_(others, others)] + np.diag([_prior(information, i) for i in others])
    return np.asarray(np.linalg.solve(block, matrix[np.ix_(others, true)] @ values))


def _presence(effect: str, information: Information, readings: Readings) -> float:
    best = 0.0
    for site in information.sites(effect):
        places = [i for i in information.of(effect, site) if not information.columns[i].card.shape]
        block = np.ix_(places, places)
        sigma = np.array([information.columns[i].card.sigma for i in places])
        scale = sigma[:, None] * sigma
        read = np.diag([_read(information, i, readings) for i in places])
        seen = _largest(scale * information.known[block], scale * information.raw[block])
        measured = scale * read
        size = _largest(measured + (scale * information.matrix[block] if seen >= LEAST_KEPT else 0.0))
        best = max(best, size)
    return best


def _largest(matrix: Real, against: Real | None = None) -> float:
    """Square root of the largest x'matrix x / x'against x."""
    if against is None:
        against = np.eye(len(matrix))
    trace = float(np.trace(against))
    if trace <= 0.0:
        return 0.0
    regular = against + 1e-12 * trace * np.eye(len(against))
    return float(np.sqrt(max(float(eigh(matrix, regular, eigvals_only=True)[-1]), 0.0)))


def _prior(information: Information, place: int) -> float:
    return float(information.columns[place].card.sigma ** -2.0)


def _read(information: Information, place: int, readings: Readings) -> float:
    column = information.columns[place]
    sigma = readings.get((column.effect, column.card.name), np.inf)
    return float(sigma**-2.0)


def open_questions(report: GapReport, cards: Sequence[str]) -> tuple[Question, ...]:
    """List what a comparison left open, look-alikes first.

    With the verdict ``unknown`` the hints are asked about: each against the candidates that explain the next most.

    Parameters
    ----------
    report : GapReport
    cards : sequence of str
        Effects that can be computed; others are left out.

    Returns
    -------
    tuple of Question
    """
    known = set(cards)
    found: Mapping[str, Values] = report.state.effects
    asked = [
        Question(effect.name, rival, dict(found[effect.name]))
        for effect in report.effects
        if effect.name in known and effect.name in found
        for rival in _rivals(report, effect.name, effect.equivalent)
        if rival in known and rival not in found
    ]
    asked += [Question(one.effect) for one in report.not_observable if one.effect in known and not one.felt]
    return tuple(asked)


def _rivals(report: GapReport, effect: str, equivalent: Sequence[str]) -> Sequence[str]:
    if equivalent or report.verdict != "unknown":
        return equivalent[:RIVALS]
    fitted = [row for row in report.candidates if row.fitted is not None and row.effect != effect]
    return [row.effect for row in sorted(fitted, key=lambda row: -(row.fitted or 0.0))[:RIVALS]]
