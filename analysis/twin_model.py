"""Interface of a twin for fits to data: model updating and the gap workflow.

A twin with some effects fixed at given values, and some declared quantities taken from their tolerance.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard, Values
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint

Effects = Mapping[str, Values]
"""Values of the effects that are switched on, by effect; the others are absent."""

NO_EFFECTS: Effects = MappingProxyType({})
"""The plate as declared."""

Tangent = tuple[str, str, Values]
"""Effect, parameter, and the point at which to differentiate: the effect's values, shapes included.

For an effect that is on, its values in `Effects` count and those given here are ignored.
"""


@dataclass(frozen=True)
class Linearisation:
    """Transfer of one sweep and its derivatives, per unit of the input (no amplifier gain).

    Attributes
    ----------
    transfer : (K, F) complex ndarray
        V/V with one patch driven and others read.
    by_material : (3, K, F) complex ndarray
        By the laws' values: log E, nu, log eta.
    by_slope, by_curvature : (3, K, F) complex ndarray
        By the laws' slopes, per K, and curvatures, per K2, the laws being turned and bent about the oven's
        temperature: what a lag or a gradient makes of them, and zero without such an effect.
    by_temperature : (K, F) complex ndarray
        By the plate's temperature, all laws followed, 1/K.
    by_parameter : (P, K, F) complex ndarray
        By the wanted parameters, in their units.
    """

    transfer: Complex
    by_material: Complex
    by_slope: Complex
    by_curvature: Complex
    by_temperature: Complex
    by_parameter: Complex

    def only_channels(self, channels: Sequence[int]) -> "Linearisation":
        """Return that of some of the channels."""
        kept = list(channels)
        return Linearisation(**{one.name: getattr(self, one.name)[..., kept, :] for one in fields(self)})


@dataclass(frozen=True)
class ModalParts:
    """What single modes of a plate contribute to the transfer of one sweep.

    Attributes
    ----------
    poles : (M,) complex ndarray
        Squared angular frequencies, rad2/s2, from the lowest mode of the plate on: a mode has the same place at
        all temperatures.
    parts : (M, K, F) complex ndarray
        Of each mode to the transfer.
    frequency : (F,) ndarray, Hz
    """

    poles: Complex
    parts: Complex
    frequency: Real

    @property
    def by_pole(self) -> Complex:
        """Derivatives (M, K, F) by relative shifts a of frequencies; i times them by b, half of loss factors."""
        square = (2.0 * np.pi * self.frequency) ** 2
        return np.asarray(-2.0 * (self.poles[:, None] / (self.poles[:, None] - square))[:, None] * self.parts)

    def only_channels(self, channels: Sequence[int]) -> "ModalParts":
        """Return those of some of the channels."""
        return replace(self, parts=self.parts[:, list(channels)])


class TwinModel(Protocol):
    """A twin as estimators see it: laws and effects in, transfer and its derivatives out."""

    @property
    def box(self) -> MaterialBox:
        """Materials within which the model may be asked."""
        ...

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """Its effects; none for a plate as declared."""
        ...

    @property
    def tolerance_cards(self) -> Mapping[str, EffectCard]:
        """Declared quantities that are not exact: free in every fit, and no candidates."""
        ...

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> Self:
        """Return the model with what `effects` count in units of the plain plate in the units that `laws` make.

        Laws over all temperatures, at their present values: a fit changes them, and with them the strain energy
        of the plain plate.
        """
        ...

    def frf(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        """Transfer of one sweep.

        Parameters
        ----------
        frequency : (F,) ndarray, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            As in `linearise`.

        Returns
        -------
        (K, F) complex ndarray
            V/V or, of transducers, SI units per unit of the drive.

        Raises
        ------
        ValueError
            As `linearise`.
        """
        ...

    def linearise(
        self,
        laws: LocalLaws,
        frequency: Real,
        effects: Effects = NO_EFFECTS,
        point: SweepPoint | None = None,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer of one sweep and its derivatives.

        Where `point` tells the drift within the sweep, the transfer at each frequency is that at the temperature
        then, to first order; the derivatives are those at the mean temperature.

        Parameters
        ----------
        frequency : (F,) ndarray
            Hz.
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            Circumstances of the sweep; unless given, a steady temperature, the laws' reference, at 1 V.
        tangents : sequence of Tangent
            Parameters of effects by which to differentiate.

        Raises
        ------
        ValueError
            Outside the box or the band, or for an effect's value outside the range its accuracy is certified for.
        """
        ...

    def modal_parts(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> ModalParts:
        """Parts of the transfer of one sweep by single modes, those in the band and near it.

        Parameters
        ----------
        frequency : (F,) ndarray, Hz
        effects : mapping
            Values of those that are on.
        point : SweepPoint, optional
            As in `linearise`.
        """
        ...


Remade = Callable[[Effects], TwinModel | None]
"""Gives the twin made for values of declared quantities; None where the present one is as good for them."""


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

    def modal_parts(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> ModalParts:
        """Return the parts of single modes with the held effects on, as `TwinModel.modal_parts`."""
        return self.twin.modal_parts(laws, frequency, {**self.held, **effects}, point)
