"""A twin with some effects fixed at given values, and some declared quantities taken from their tolerance."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import EffectCard
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects, Linearisation, Tangent, TwinModel


@dataclass(frozen=True)
class HeldEffects:
    """A `analysis.twin_model.TwinModel` whose effects in `held` are always on and never candidates.

    Attributes
    ----------
    twin : TwinModel
    held : mapping
        Values of these effects.
    released : frozenset of str
        Declared quantities that are no longer free within their tolerance: effects that replace them are
        candidates instead. As long as a quantity has a tolerance, such an effect is none: it would be counted
        twice.
    """

    twin: TwinModel
    held: Effects
    released: frozenset[str] = frozenset()

    @classmethod
    def around(cls, twin: TwinModel) -> "HeldEffects":
        """Return `twin` with no effect held; itself where it is such a twin already."""
        return twin if isinstance(twin, cls) else cls(twin, NO_EFFECTS)

    @property
    def box(self) -> MaterialBox:
        """Materials within which the twin may be asked."""
        return self.twin.box

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """The candidates that are left."""
        known = self.tolerance_cards
        return {
            name: card
            for name, card in self.twin.cards.items()
            if name not in self.held and card.replaces not in known
        }

    @property
    def tolerance_cards(self) -> Mapping[str, EffectCard]:
        """Declared quantities of the twin that are free within their tolerance."""
        replaced = {self.twin.cards[name].replaces for name in self.held if name in self.twin.cards}
        known = self.twin.tolerance_cards
        return {name: card for name, card in known.items() if name not in self.released | replaced}

    def releasing(self, quantities: Iterable[str]) -> "HeldEffects":
        """Return the same with those of some declared quantities released that an effect replaces."""
        replaced = {card.replaces for name, card in self.twin.cards.items() if name not in self.held}
        return replace(self, released=self.released | (replaced & set(quantities)))

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> "HeldEffects":
        """Return the same with the twin in the units that these laws make."""
        return replace(self, twin=self.twin.counted(laws, [*self.held, *effects]))

    def frf(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> NDArray[np.complex128]:
        """Transfer of one sweep with the held effects on.

        Parameters
        ----------
        frequency : (F,) ndarray
            Hz.
        effects : mapping
            Values of further effects that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; a steady temperature at 1 V by default.

        Returns
        -------
        (K, F) complex ndarray

        Raises
        ------
        ValueError
            As `analysis.twin_model.TwinModel.linearise`.
        """
        return self.twin.frf(laws, frequency, {**self.held, **effects}, point)

    def linearise(
        self,
        laws: LocalLaws,
        frequency: Real,
        effects: Effects = NO_EFFECTS,
        point: SweepPoint | None = None,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer of one sweep and its derivatives with the held effects on.

        Parameters
        ----------
        frequency : (F,) ndarray
            Hz.
        effects : mapping
            Values of further effects that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; a steady temperature at 1 V by default.
        tangents : sequence of Tangent
            Parameters by which to differentiate.

        Raises
        ------
        ValueError
            As `analysis.twin_model.TwinModel.linearise`.
        """
        return self.twin.linearise(laws, frequency, {**self.held, **effects}, point, tangents)
