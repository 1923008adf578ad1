"""A campaign linearised once: fits and score tests near one state without another evaluation of the twin."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard, Values
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.normal_equations import GLOBAL, SweepEquations, WhitenedSweep, channel_blocks, whiten_all
from analysis.gap.fitting.sites import sites_beside
from analysis.gap.fitting.state import GapState
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects, Linearisation, ModalParts, Tangent, TwinModel

HELD = 1e-9
"""Standard deviation, as a share of its range, of a shape that is held."""

Key = tuple[str, str, tuple[float, ...]]
"""Effect, parameter, and the values of the effect's shapes; none of an effect that is on."""


@dataclass(frozen=True)
class LinearisedSweeps:
    """Residual of every sweep as a linear function of everything that is fitted.

    It stands in for the twin in `fit_gap` and `score_test`, for the sweeps that it was made of, with any weights.

    Attributes
    ----------
    model : TwinModel
    state : GapState
        Where it is exact.
    white : tuple of WhitenedSweep
        Unweighted columns and residual of every sweep.
    columns : mapping of Key to int
        Of the effects' parameters, after those of laws, readings and gains.
    places : mapping of str to Values
        Shapes at which effects are held that are off in `state`.
    """

    model: TwinModel
    state: GapState
    white: tuple[WhitenedSweep, ...] = field(repr=False)
    columns: Mapping[Key, int] = field(repr=False)
    places: Mapping[str, Values] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        model: TwinModel,
        sweeps: GapSweeps,
        state: GapState,
        executor: Executor,
        *,
        candidates: Collection[str] | None = None,
    ) -> "LinearisedSweeps":
        """Linearise unweighted sweeps by all declared quantities, all effects that are on, and candidates.

        Parameters
        ----------
        model : TwinModel
        sweeps : GapSweeps
        state : GapState
        executor : Executor
            Sweeps are linearised on it.
        candidates : collection of str, optional
            Effects that take part though they are off; by default all. At all their sites they are most of the
            derivatives.

        Returns
        -------
        LinearisedSweeps
        """
        known = {**model.tolerance_cards, **model.cards}
        tangents: list[Tangent] = [(n, p.name, state.on[n]) for n in state.on for p in known[n].parameters]
        for name, sites in sites_beside(model.cards, state.on).items():
            if candidates is None or name in candidates:
                card = model.cards[name]
                tangents += [(name, p.name, card.zero(site)) for site in sites for p in card.amplitudes]
        white = whiten_all(model, sweeps, state, tangents, executor)
        first = GLOBAL + len(state.log_gain)
        return cls(
            model, state, tuple(white), {_key(one, state, model): first + i for i, one in enumerate(tangents)}
        )

    @property
    def box(self) -> MaterialBox:
        """That of the twin."""
        return self.model.box

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """Those of the twin; shapes of effects that are off where this was made are held at `places`."""
        found = dict(self.model.cards)
        for name, place in self.places.items():
            held = [
                replace(p, typical=place[p.name], sigma=HELD * (p.high - p.low)) if p.shape else p
                for p in found[name].parameters
            ]
            found[name] = replace(found[name], parameters=tuple(held))
        return found

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> "LinearisedSweeps":
        """Return itself: it is in units of where it was made."""
        del laws, effects
        return self

    def frf(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        """Transfer of one sweep by the twin, see `TwinModel.frf`.

        Parameters
        ----------
        laws : LocalLaws
        frequency : (F,) ndarray
            Hz.
        effects : mapping
        point : SweepPoint, optional

        Returns
        -------
        (K, F) complex ndarray
        """
        return self.model.frf(laws, frequency, effects, point)

    def linearise(
        self,
        laws: LocalLaws,
        frequency: Real,
        effects: Effects = NO_EFFECTS,
        point: SweepPoint | None = None,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer of one sweep and its derivatives by the twin, see `TwinModel.linearise`.

        Parameters
        ----------
        laws : LocalLaws
        frequency : (F,) ndarray
            Hz.
        effects : mapping
        point : SweepPoint, optional
        tangents : sequence of Tangent

        Returns
        -------
        Linearisation
        """
        return self.model.linearise(laws, frequency, effects, point, tangents)

    def modal_parts(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> ModalParts:
        """Return the parts of single modes by the twin, as `TwinModel.modal_parts`."""
        return self.model.modal_parts(laws, frequency, effects, point)

    def placed(self, places: Mapping[str, Values]) -> "LinearisedSweeps":
        """Return the same with effects that are off held at some places: values of their shapes, by effect."""
        return replace(self, places={**self.places, **places})

    @property
    def tolerance_cards(self) -> Mapping[str, EffectCard]:
        """Those of the twin."""
        return self.model.tolerance_cards

    def equations(self, sweeps: GapSweeps, state: GapState, tangents: Sequence[Tangent]) -> list[SweepEquations]:
        """Form the normal equations of every sweep at another state, to first order, with the weights of `sweeps`.

        Parameters
        ----------
        sweeps : GapSweeps
            Those that this was made of, with any weights.
        state : GapState
        tangents : sequence of Tangent
            As in `linearise_all`.

        Returns
        -------
        list of SweepEquations
        """
        own = GLOBAL + len(state.log_gain)
        wanted = np.array([self.column(one) for one in tangents], dtype=int)
        shared, found = self._shared(state), []
        for sweep, white in enumerate(self.white):
            step = np.concatenate([self._own(sweeps, sweep, state), shared])
            used = np.flatnonzero(step)
            rows, parts = np.concatenate([np.arange(own), wanted]), []
            for part in channel_blocks(len(rows) + 1, *white.predicted.shape):
                here = white.white[:, part]
                residual = here[-1] - np.tensordot(step[used], here[used], 1)
                columns = np.concatenate([here[rows], residual[None]])
                columns[:-1][rows < 0] = 0.0
                weighted = sweeps.weights.weigh(columns, sweep, part) * sweeps.rows[sweep, part]
                parts.append(WhitenedSweep(weighted, white.predicted[part]).equations())
            found.append(SweepEquations.summed(parts))
        return found

    def column(self, tangent: Tangent) -> int:
        """Find the column of a parameter among those of `white`; -1 for a shape that is held."""
        return self.columns.get(_key(tangent, self.state, self.model), -1)

    def _own(self, sweeps: GapSweeps, sweep: int, state: GapState) -> Real:
        """Step of a sweep's own columns, (10,): laws, their derivatives, temperature."""
        group = sweeps.groups.of_sweep[sweep]
        moved = state.circumstances(sweep, sweeps.points[sweep])
        seen = sweeps.smoothness.seen(group, moved.temperature - sweeps.groups.reference[group])
        now, then = (
            np.concatenate([one.laws.ravel(), sweeps.smoothness.errors(one.tilt, one.bend)])
            for one in (state, self.state)
        )
        return np.append(seen @ (now - then), state.away[sweep] - self.state.away[sweep])

    def _shared(self, state: GapState) -> Real:
        """Step of gains and parameters."""
        gains = state.log_gain - self.state.log_gain
        step = np.zeros(len(self.columns))
        first = GLOBAL + len(gains)
        cards = {**self.model.tolerance_cards, **self.model.cards}
        for name, values in {**self.state.on, **state.on}.items():
            # of an effect that is switched off only the amplitudes go to zero
            moving = [p.name for p in cards[name].parameters if name in state.on or not p.shape]
            for parameter in moving:
                place = self.column((name, parameter, values))
                if place >= 0:
                    now, then = (one.on.get(name, {}).get(parameter, 0.0) for one in (state, self.state))
                    step[place - first] = now - then
        return np.concatenate([gains, step])


def _key(tangent: Tangent, state: GapState, model: TwinModel) -> Key:
    name, parameter, values = tangent
    if name in state.on:
        return name, parameter, ()
    return name, parameter, tuple(float(values[p.name]) for p in model.cards[name].parameters if p.shape)
