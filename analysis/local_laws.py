"""E, nu and eta as functions of temperature near one temperature."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LocalLaws:
    """Second-order expansions of log E, nu and log eta about a reference temperature.

    A plate with gradients of a few kelvins, or one that lags behind its oven, is described by what its laws do
    within those kelvins. All methods accept complex temperatures, for derivatives by complex step.

    Attributes
    ----------
    reference : float
        Degrees Celsius.
    value, slope, curvature : (3,) ndarray
        Of log E [log Pa], nu and log eta: at `reference`, per K and per K2.
    """

    reference: float
    value: NDArray[np.float64]
    slope: NDArray[np.float64]
    curvature: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("value", "slope", "curvature"):
            row = getattr(self, name)
            if row.shape != (3,) or not np.isfinite(row).all():
                raise ValueError(f"local laws: {name} is {row}; three finite numbers wanted")

    @classmethod
    def of_material(
        cls,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        *,
        reference: float = 20.0,
        slope: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> "LocalLaws":
        """Laws through one material, linear in temperature.

        Parameters
        ----------
        youngs_modulus : float
            At `reference`, Pa.
        poisson_ratio : float
            At `reference`.
        loss_factor : float
            At `reference`.
        reference : float
            °C.
        slope : (float, float, float)
            Of log E, nu and log eta, per K.

        Returns
        -------
        LocalLaws
            Without curvature.
        """
        value = np.array([np.log(youngs_modulus), poisson_ratio, np.log(loss_factor)])
        return cls(reference, value, np.array(slope), np.zeros(3))

    def tilted(
        self, slope: NDArray[np.float64], curvature: NDArray[np.float64], temperature: float
    ) -> "LocalLaws":
        """Add a slope and a curvature, turning and bending the laws about a temperature.

        Parameters
        ----------
        slope, curvature : (3,) ndarray
            Per K and per K2.
        temperature : float
            Where values stay, and slopes change by `slope` alone, degrees Celsius.
        """
        away = temperature - self.reference
        return replace(
            self,
            value=self.value - away * (slope - 0.5 * away * curvature),
            slope=self.slope + slope - away * curvature,
            curvature=self.curvature + curvature,
        )

    def grown(self, expansion: float, dimensions_at: float) -> "LocalLaws":
        """Laws of a plate that keeps its dimensions and is as stiff as this one, which grows with temperature.

        A bare plate of constant mass that grows alike in all directions, to g = 1 + expansion (T - dimensions_at)
        times its dimensions, has g times the stiffness: bending E h**3 / L**2, membrane and shear E h all go with
        g, once rotations are counted in units of 1/g.

        Parameters
        ----------
        expansion : float
            Coefficient of thermal expansion, 1/K.
        dimensions_at : float
            Temperature at which the declared dimensions hold, degrees Celsius.
        """
        growth = 1.0 + expansion * (self.reference - dimensions_at)
        of_log = np.array([np.log(growth), expansion / growth, -((expansion / growth) ** 2)])
        by_e = np.array([1.0, 0.0, 0.0])
        return replace(
            self,
            value=self.value + of_log[0] * by_e,
            slope=self.slope + of_log[1] * by_e,
            curvature=self.curvature + of_log[2] * by_e,
        )

    def youngs_modulus(self, temperature: Any) -> Any:
        """E at `temperature` [degrees Celsius], Pa."""
        return np.exp(self._at(0, temperature))

    def poisson_ratio(self, temperature: Any) -> Any:
        """Poisson's ratio at `temperature` [degrees Celsius]."""
        return self._at(1, temperature)

    def loss_factor(self, temperature: Any) -> Any:
        """Loss factor at `temperature` [degrees Celsius]."""
        return np.exp(self._at(2, temperature))

    def rates(self, temperature: float) -> NDArray[np.float64]:
        """How log E, nu and log eta change at `temperature` [degrees Celsius], (3,), per K."""
        rates: NDArray[np.float64] = self.slope + self.curvature * (temperature - self.reference)
        return rates

    def _at(self, law: int, temperature: Any) -> Any:
        away = np.asarray(temperature) - self.reference
        return self.value[law] + away * (self.slope[law] + 0.5 * away * self.curvature[law])
