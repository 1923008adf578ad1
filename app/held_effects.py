"""A twin with some effects switched on for good: whoever asks it moves the others only."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.gap.effect_card import EffectCard
from analysis.gap.model import Effects, GapModel, Linearisation, SweepPoint, Tangent
from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox


@dataclass(frozen=True)
class HeldEffects:
    """A `analysis.gap.model.GapModel` whose effects in `held` are always on and never candidates.

    Attributes
    ----------
    twin : GapModel
    held : mapping
        Values of these effects.
    """

    twin: GapModel
    held: Effects

    @property
    def box(self) -> MaterialBox:
        """Materials within which the twin may be asked."""
        return self.twin.box

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """The candidates that are left."""
        return {name: card for name, card in self.twin.cards.items() if name not in self.held}

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> "HeldEffects":
        """Return the same with the twin in the units that these laws make."""
        return replace(self, twin=self.twin.counted(laws, [*self.held, *effects]))

    def frf(
        self, point: SweepPoint, laws: LocalLaws, effects: Effects, frequency: NDArray[np.float64]
    ) -> NDArray[np.complex128]:
        """Transfer, the held effects among those that are on."""
        return self.twin.frf(point, laws, {**self.held, **effects}, frequency)

    def linearise(
        self,
        point: SweepPoint,
        laws: LocalLaws,
        effects: Effects,
        frequency: NDArray[np.float64],
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer and its derivatives, the held effects among those that are on."""
        return self.twin.linearise(point, laws, {**self.held, **effects}, frequency, tangents)
