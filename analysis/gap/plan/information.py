"""What a campaign says about some effects, laws, readings, gains and declared quantities eliminated."""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from analysis.arrays import Real
from analysis.effect_card import EffectCard
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.state import GapState
from analysis.gap.search.score_test import Column
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


def _columns(
    model: TwinModel, state: GapState, trusted: float, asked: Sequence[str]
) -> tuple[tuple[Column, ...], int]:
    """Return the columns, and how many of them are not in question."""
    on, nuisances = state.on, []
    for name, card in model.tolerance_cards.items():
        if name in on:
            nuisances += [
                Column(name, 0, replace(p, sigma=p.sigma * trusted**-0.5), on[name][p.name], {})
                for p in card.parameters
            ]
    for name in state.effects:
        if name not in asked:
            nuisances += _on(model.cards[name], on[name])
    wanted: list[Column] = []
    for name in dict.fromkeys(asked):
        card = model.cards[name]
        if name in on:
            wanted += _on(card, on[name])
        else:
            wanted += [Column(name, k, p, 0.0, site) for k, site in enumerate(card.sites) for p in card.amplitudes]
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
