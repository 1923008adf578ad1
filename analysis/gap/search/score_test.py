"""Score test of all candidates at once, with one linearisation of the sweeps; gains inside their ranges.

At a fit, the tangents of every candidate (all amplitudes, at every site) join the normal equations; laws, readings
and gain are eliminated. The remaining part of a candidate's tangents is independent of everything else in the
twin; the residual's projection on it gives the candidate's evidence to first order.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import Parameter, Values
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import linearise_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.sites import sites_beside
from analysis.twin_model import Tangent, TwinModel

REWEIGHTED = 4
"""Largest number of times that a step is solved with the prior's width where the last one ended."""


@dataclass(frozen=True)
class Column:
    """One tangent of a score test.

    Attributes
    ----------
    effect : str
    site : int
        Index of the site on the effect's card; 0 for an effect that is on.
    card : Parameter
    at : float
        Value of the parameter at which it was computed.
    shapes : mapping
        Values of the effect's shapes there.
    """

    effect: str
    site: int
    card: Parameter
    at: float
    shapes: Values


@dataclass(frozen=True)
class Candidate:
    """Predicted gain of one effect, or of a pair, to first order.

    Attributes
    ----------
    effects : tuple of str
    gain : float
        Laplace evidence over the present twin, nats, less log of the number of sites tried.
    step : tuple of float
        Of each of `columns`.
    columns : tuple of int
    size : float
        Size in sigma of the part of the signal that only this candidate explains, at `step`.
    fit : float
        Log likelihood over the present twin, at `step`, nats.
    """

    effects: tuple[str, ...]
    gain: float
    step: tuple[float, ...]
    columns: tuple[int, ...]
    size: float
    fit: float = 0.0


@dataclass(frozen=True)
class ScoreTest:
    """Normal equations of every candidate at one fit, with laws, readings and gain eliminated.

    Attributes
    ----------
    columns : tuple of Column
        First all parameters of the declared quantities and of the effects that are on, then the amplitudes of the
        others.
    active : tuple of str
        Declared quantities with a tolerance, and effects that are on.
    matrix, read, raw : (Q, Q) ndarray
        J'J with laws, readings and gain eliminated; with laws and gain eliminated, for exactly known temperatures;
        and before elimination.
    gradient : (Q,) ndarray
        J'r, eliminated.
    """

    columns: tuple[Column, ...]
    active: tuple[str, ...]
    matrix: Real = field(repr=False)
    read: Real = field(repr=False)
    raw: Real = field(repr=False)
    gradient: Real = field(repr=False)

    @property
    def inactive(self) -> tuple[str, ...]:
        """Effects that are off."""
        return tuple(dict.fromkeys(c.effect for c in self.columns if c.effect not in self.active))

    def of(self, effect: str, site: int | None = None) -> list[int]:
        """Find the indices of an effect's columns, at one of its sites or at all."""
        return [i for i, c in enumerate(self.columns) if c.effect == effect and site in (None, c.site)]

    def sites(self, effect: str) -> list[int]:
        """Sites of an effect."""
        return sorted({self.columns[i].site for i in self.of(effect)})

    def given(self, effects: Sequence[str]) -> tuple[Real, Real]:
        """Matrix and gradient with all parameters of `effects` eliminated under their priors."""
        return self._without(effects, self.matrix, self.gradient)

    def kept(self, effects: Sequence[str]) -> Real:
        """Matrix with laws, gain and `effects` eliminated, for exactly known temperatures."""
        return self._without(effects, self.read, self.gradient)[0]

    def _without(self, effects: Sequence[str], matrix: Real, gradient: Real) -> tuple[Real, Real]:
        known = [i for name in effects for i in self.of(name)]
        if not known:
            return matrix, gradient
        sigma = np.array([self.columns[i].card.precision(self.columns[i].at) ** -0.5 for i in known])
        block = matrix[np.ix_(known, known)] * sigma[:, None] * sigma + np.eye(len(known))
        cross = sigma[:, None] * matrix[known]
        away = np.array([self.columns[i].at - self.columns[i].card.centre for i in known])
        pull = sigma * gradient[known] - away / sigma
        solved = np.linalg.solve(block, np.column_stack([cross, pull]))
        left = matrix - cross.T @ solved[:, :-1]
        return 0.5 * (left + left.T), gradient - cross.T @ solved[:, -1]

    def scaled(self, factor: float) -> "ScoreTest":
        """Return the test that `factor` times the data would give, all like these."""
        rows = {name: factor * getattr(self, name) for name in ("matrix", "read", "raw", "gradient")}
        return replace(self, **rows)

    def without(self, effect: str) -> "ScoreTest":
        """Return the test with an active effect removed: its signal back in the residual, and it is a candidate.

        To first order only: its shapes are not changed.
        """
        mine = [i for i in self.of(effect) if not self.columns[i].card.shape]
        left = [i for i, c in enumerate(self.columns) if c.effect != effect or not c.card.shape]
        block = np.ix_(left, left)
        gradient = self.gradient + self.matrix[:, mine] @ np.array([self.columns[i].at for i in mine])
        return ScoreTest(
            columns=tuple(replace(self.columns[i], at=0.0) if i in mine else self.columns[i] for i in left),
            active=tuple(name for name in self.active if name != effect),
            matrix=self.matrix[block],
            read=self.read[block],
            raw=self.raw[block],
            gradient=gradient[left],
        )

    def candidates(self) -> list[Candidate]:
        """Each inactive effect at its best site, largest predicted gain first."""
        given = self.given(self.active)
        best = [max(self._at_sites(name, *given), key=lambda c: c.gain) for name in self.inactive]
        return sorted(best, key=lambda c: -c.gain)

    def at_sites(self, effect: str) -> list[Candidate]:
        """Return an inactive effect at each of its sites."""
        return self._at_sites(effect, *self.given(self.active))

    def _at_sites(self, effect: str, matrix: Real, gradient: Real) -> list[Candidate]:
        sites = self.sites(effect)
        return [self.candidate((effect,), self.of(effect, s), matrix, gradient, len(sites)) for s in sites]

    def pairs(self, singles: Sequence[Candidate]) -> list[Candidate]:
        """All pairs out of `singles`, each at its best site, largest predicted gain first."""
        matrix, gradient = self.given(self.active)
        found = [
            self.candidate(a.effects + b.effects, [*a.columns, *b.columns], matrix, gradient, 1)
            for i, a in enumerate(singles)
            for b in singles[i + 1 :]
        ]
        return sorted(found, key=lambda c: -c.gain)

    def candidate(
        self, effects: tuple[str, ...], columns: Sequence[int], matrix: Real, gradient: Real, sites: int
    ) -> Candidate:
        """Laplace evidence of some columns fitted jointly, inside their ranges.

        Parameters
        ----------
        effects : tuple of str
        columns : sequence of int
            Indices of the q columns.
        matrix : (Q, Q) ndarray
            As from `given`.
        gradient : (Q,) ndarray
        sites : int
            Number of sites tried: its logarithm is subtracted from the evidence.

        Returns
        -------
        Candidate
        """
        places = list(columns)
        cards = [self.columns[i].card for i in places]
        inner, pull = matrix[np.ix_(places, places)], gradient[places]
        low = np.array([card.low - self.columns[i].at for i, card in zip(places, cards, strict=True)])
        high = np.array([card.high - self.columns[i].at for i, card in zip(places, cards, strict=True)])
        natural, sigma = np.zeros(len(places)), np.zeros(len(places))
        for _ in range(REWEIGHTED):
            before = sigma
            sigma = np.array(
                [card.precision(at) ** -0.5 for card, at in zip(cards, natural.tolist(), strict=True)]
            )
            if np.array_equal(sigma, before):
                break
            scaled = inner * sigma[:, None] * sigma + np.eye(len(places))
            natural = sigma * solve_inside(scaled, sigma * pull, low / sigma, high / sigma)
        size = float(np.sqrt(max(float(natural @ inner @ natural), 0.0)))
        fit = float(pull @ natural) - 0.5 * size**2
        prior = sum(card.penalty(at) for card, at in zip(cards, natural.tolist(), strict=True))
        wider = sum(2.0 * np.log(wide / card.sigma) for wide, card in zip(sigma, cards, strict=True))
        gain = fit - 0.5 * (prior + float(np.linalg.slogdet(scaled)[1]) - wider)
        return Candidate(effects, float(gain - np.log(sites)), tuple(natural.tolist()), tuple(places), size, fit)


def score_test(
    model: TwinModel,
    sweeps: GapSweeps,
    fit: GapFit,
    executor: Executor,
    *,
    effects: Sequence[str] | None = None,
    standing: Mapping[str, Values] | None = None,
) -> ScoreTest:
    """Linearise a fit with the tangents of every candidate, and eliminate laws, readings and gain.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    fit : GapFit
    executor : Executor
        Sweeps are linearised on it.
    effects : sequence of str, optional
        Candidates; by default all effects that are off, but for a second one whose first is off, too.
    standing : mapping of str to mapping, optional
        Values of effects at whose places candidates are tried, too; by default those that are on.

    Returns
    -------
    ScoreTest

    Raises
    ------
    ValueError
        Where the model refuses the state of the fit.
    """
    on = fit.state.on
    cards = {**model.tolerance_cards, **model.cards}
    # priors of declared quantities count as in the fit
    trusted = dict.fromkeys(fit.state.declared, fit.free.trusted ** (-0.5))
    columns = [
        Column(
            name,
            0,
            replace(p, sigma=p.sigma * trusted.get(name, 1.0)),
            on[name][p.name],
            {q.name: on[name][q.name] for q in cards[name].parameters if q.shape},
        )
        for name in on
        for p in cards[name].parameters
    ]
    for name, sites in sites_beside(model.cards, on, standing).items():
        card = model.cards[name]
        if not card.after or card.after in on if effects is None else name in effects:
            columns += [Column(name, k, p, 0.0, site) for k, site in enumerate(sites) for p in card.amplitudes]
    tangents: list[Tangent] = [
        (c.effect, c.card.name, on.get(c.effect, cards[c.effect].zero(c.shapes))) for c in columns
    ]
    equations = linearise_all(model, sweeps, fit.state, tangents, executor)
    head = schur_complement(sweeps, equations, fit.state)
    left, gains = head.without_gains(), head.gains
    return ScoreTest(
        columns=tuple(columns),
        active=tuple(on),
        matrix=left.matrix,
        read=schur_complement(sweeps, equations, fit.state, readings=False).without_gains().matrix,
        raw=head.raw[gains:, gains:],
        gradient=left.gradient,
    )


def solve_inside(matrix: Real, pull: Real, low: Real, high: Real) -> Real:
    """Maximise pull'x - x'matrix x / 2 over low <= x <= high.

    An unknown that leaves the box is set to its bound and the others are solved for again: exact for one unknown,
    approximate for few.

    Parameters
    ----------
    matrix : (q, q) ndarray
        Positive definite.
    pull : (q,) ndarray
    low : (q,) ndarray
    high : (q,) ndarray

    Returns
    -------
    (q,) ndarray
    """
    x = np.zeros(len(pull))
    free = np.ones(len(pull), dtype=bool)
    for _ in range(len(pull)):
        held = matrix[np.ix_(free, ~free)] @ x[~free]
        x[free] = np.linalg.solve(matrix[np.ix_(free, free)], pull[free] - held)
        outside = free & ((x < low) | (x > high))
        if not outside.any():
            break
        x = np.where(outside, np.clip(x, low, high), x)
        free &= ~outside
        if not free.any():
            break
    return x
