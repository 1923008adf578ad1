"""Protocol of a panel with a temperature of its own at every place."""

from dataclasses import dataclass
from typing import Protocol

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_shapes
from analysis.focusing.energy import FieldSpace


@dataclass(frozen=True)
class WarmAnswer:
    """A panel's answer at one field of temperatures.

    Attributes
    ----------
    amplitude : (N, F, r) ndarray
        Generalised coordinates of the field of every actuator, per V or N.
    charge : (N, N, F) ndarray
        Of every actuator (first), as a sensor, per volt on another, C/V; of forces, m/N.
    """

    amplitude: Complex
    charge: Complex

    def __post_init__(self) -> None:
        check_shapes(self, amplitude="N F r", charge="N N F")
        check_finite(self, "amplitude", "charge")


class WarmPanel(Protocol):
    """Model of a panel with a field of temperatures."""

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes, with their inner products."""

    @property
    def points(self) -> Real:
        """Where temperatures are given, (Q, 2), m."""

    def tilted(self, temperature: float, across: tuple[float, float]) -> Real:
        """Temperatures (Q,), °C, of a panel evenly warmer toward the largest x and y.

        Parameters
        ----------
        temperature : float
            In the middle of the box around the plate, °C.
        across : (float, float)
            Temperature at largest x and y minus that at smallest x and y, K.
        """

    def answer(self, temperature: Real, frequency: Real) -> WarmAnswer:
        """Fields and charges at a field of temperatures.

        Parameters
        ----------
        temperature : (Q,) ndarray, °C
            At `points`.
        frequency : (F,) ndarray, Hz

        Raises
        ------
        ValueError
            Where a part of the panel leaves the range of the laws.
        """
