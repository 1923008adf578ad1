"""What a twin must offer to the gap workflow."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from analysis.gap.effect_card import EffectCard, Values
from analysis.local_laws import LocalLaws
from analysis.material import MaterialBox

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

Effects = Mapping[str, Values]
"""Values of the effects that are switched on, by effect; the others are absent."""

Tangent = tuple[str, str, Values]
"""Effect, parameter, and the point at which to differentiate: the effect's values, shapes included.

For an effect that is on, its values in `Effects` count and those given here are ignored.
"""


@dataclass(frozen=True)
class SweepPoint:
    """Under what circumstances one sweep was made.

    Attributes
    ----------
    temperature : float
        Mean reading of the oven (or of the plate's own sensor), degrees Celsius.
    rate : float
        dT/dt of the oven, signed, K/s: positive on the way up.
    level : float
        Drive amplitude, V.
    """

    temperature: float
    rate: float
    level: float


@dataclass(frozen=True)
class Linearisation:
    """Transfer of one sweep and its derivatives, per volt on the actuator patch (no amplifier gain).

    Attributes
    ----------
    transfer : (K, F) complex ndarray
        V/V.
    by_material : (3, K, F) complex ndarray
        By the laws' values: log E, nu, log eta.
    by_slope : (3, K, F) complex ndarray
        By the laws' slopes, per K, the laws being turned about the oven's temperature: what a lag or a gradient
        makes of them, and zero without such an effect.
    by_temperature : (K, F) complex ndarray
        By the plate's temperature, all laws followed, 1/K.
    by_parameter : (P, K, F) complex ndarray
        By the wanted parameters, in their units.
    """

    transfer: Complex
    by_material: Complex
    by_slope: Complex
    by_temperature: Complex
    by_parameter: Complex


class GapModel(Protocol):
    """A twin with a library of effects, seen from the gap workflow."""

    @property
    def box(self) -> MaterialBox:
        """Materials within which the model may be asked."""
        ...

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """The candidates."""
        ...

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> Self:
        """Return the model with what `effects` count in units of the plain plate in the units that `laws` make.

        Laws over all temperatures, as they stand: a fit moves them, and with them the plain plate's strain energy.
        """
        ...

    def frf(self, point: SweepPoint, laws: LocalLaws, effects: Effects, frequency: Real) -> Complex:
        """Transfer of one sweep, (K, F); errors as `linearise`."""
        ...

    def linearise(
        self,
        point: SweepPoint,
        laws: LocalLaws,
        effects: Effects,
        frequency: Real,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        """Transfer over `frequency` (F,), Hz, and its derivatives at one sweep.

        ValueError outside the box, or for an effect's value outside the range its accuracy is certified for.
        """
        ...
