"""A panel one of whose patches listens while the others play."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.material import MaterialLaws
from app.twins.panel_twin import PanelTwin


@dataclass(frozen=True)
class ListeningPanel:
    """A panel whose patches drive, but for one, whose charge is measured.

    Attributes
    ----------
    twin : PanelTwin
    laws : MaterialLaws
        Of the panel's plate.
    sensor : int
        The patch used as sensor.
    """

    twin: PanelTwin
    laws: MaterialLaws
    sensor: int

    @property
    def driven(self) -> list[int]:
        """The other patches."""
        return [n for n in range(self.twin.reduced.capacitance.size) if n != self.sensor]

    def transfer(self, temperature: float, frequency: Real) -> Complex:
        """Charge of the listening patch per volt on each of the others.

        Parameters
        ----------
        temperature : float
            Degrees Celsius.
        frequency : (F,) ndarray
            Hz.

        Returns
        -------
        (N - 1, F) complex ndarray
            C/V.
        """
        material = self.laws.at(temperature)
        constants = (material.youngs_modulus, material.poisson_ratio, material.loss_factor)
        e, nu, eta = (float(value[0]) for value in constants)
        whole = self.twin.reduced.compliance(e, nu, eta, frequency)
        chosen: Complex = whole[self.sensor, self.driven]
        return chosen

    def law_sigma(self, temperature: float) -> float:
        """By how much one standard deviation of the law of E moves the reading.

        Parameters
        ----------
        temperature : float
            Degrees Celsius; beyond the law, that of its end.

        Returns
        -------
        float
            K; infinite where E does not depend on the temperature.
        """
        temperature = float(np.clip(temperature, *self.laws.temperature_range))
        spread = float(
            self.laws.sigma(temperature).youngs_modulus[0] / self.laws.at(temperature).youngs_modulus[0]
        )
        slope = abs(float(self.laws.local(temperature).slope[0]))
        return spread / slope if slope > 0.0 else np.inf
