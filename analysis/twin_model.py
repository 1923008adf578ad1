"""Interface of a twin for fits to data: model updating and the gap workflow."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, Self

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


Remade = Callable[[Effects], TwinModel | None]
"""Gives the twin made for values of declared quantities; None where the present one is as good for them."""
