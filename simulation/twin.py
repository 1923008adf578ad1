"""The digital twin as an experiment sees it: volts on the actuator in, volts on the sensors out."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.experiment import Experiment
from analysis.material import MaterialBox
from simulation.reduced_model import ReducedModel
from simulation.shell.electric_load import ElectricLoad

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Twin:
    """Voltage-to-voltage transfer of a plate with one driven patch and K sensors on real inputs.

    Attributes
    ----------
    reduced : ReducedModel
    actuator : int
        Index of the driven patch.
    sensors : tuple of int
        Indices of the patches that are read, all connected at once.
    load : ElectricLoad
        Across every sensor.
    """

    reduced: ReducedModel
    actuator: int
    sensors: tuple[int, ...]
    load: ElectricLoad

    def __post_init__(self) -> None:
        patches = self.reduced.capacitance.size
        for index in (self.actuator, *self.sensors):
            if not 0 <= index < patches:
                raise ValueError(f"twin: patch index {index} is outside 0 to {patches - 1}")
        if not self.sensors or self.actuator in self.sensors:
            raise ValueError(f"twin: sensors {self.sensors} must be at least one, the actuator not among them")

    @classmethod
    def of(cls, experiment: Experiment, reduced: ReducedModel) -> Self:
        """Join an experiment's electronics to the reduced model of its plate and patches."""
        roles = [patch.role for patch in experiment.patch]
        sensors = tuple(k for k, role in enumerate(roles) if role == "sensor")
        inputs = experiment.acquisition
        load = ElectricLoad(inputs.input_resistance, inputs.input_capacitance)
        return cls(reduced, roles.index("actuator"), sensors, load)

    @property
    def box(self) -> MaterialBox:
        """Where the twin may be asked."""
        return self.reduced.box

    @property
    def band(self) -> tuple[float, float]:
        """Frequencies at which the twin may be asked, Hz."""
        return self.reduced.band

    @property
    def error(self) -> float:
        """Error of the reduced model, see `ReducedModel.error`."""
        return self.reduced.error

    @property
    def _read(self) -> Real:
        return self.reduced.coupling[:, list(self.sensors)]

    @property
    def _joined(self) -> Real:
        """Couplings of the sensors, then of the actuator, (r, K + 1)."""
        return self.reduced.coupling[:, [*self.sensors, self.actuator]]

    @property
    def _capacitance(self) -> Real:
        return self.reduced.capacitance[list(self.sensors)]

    def frf(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """Sensor volts per actuator volt, (K, F); ValueError outside box or band."""
        lines = np.atleast_1d(np.asarray(frequency, float))
        self.reduced.require(youngs_modulus, poisson_ratio, loss_factor, lines)
        modal = self.reduced.modal_form(youngs_modulus, poisson_ratio, loss_factor)
        answer = modal.compliance(self._read, self._joined, lines)
        return self.load.voltages(answer[:, -1], answer[:, :-1], self._capacitance, lines)

    def sensitivities(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> tuple[Complex, Complex]:
        """Transfer (K, F) and its derivatives (3, K, F) with respect to E [1/Pa], nu and eta.

        Y V = -h gives Y V' = -(h' + G' V), with Y of `ElectricLoad.admittance`.
        """
        material = (youngs_modulus, poisson_ratio, loss_factor)
        lines = np.atleast_1d(np.asarray(frequency, float))
        self.reduced.require(*material, lines)
        modal = self.reduced.modal_form(*material)
        changes, weights = self.reduced.stiffness_derivatives(*material)
        answer, slopes = modal.compliance_and_derivatives(self._read, self._joined, changes, lines)
        admittance = self.load.admittance(self._capacitance, answer[:, :-1], lines)
        voltage = self.load.voltages(answer[:, -1], answer[:, :-1], self._capacitance, lines)
        change = slopes[:, :, -1] + np.einsum("dikf,kf->dif", slopes[:, :, :-1], voltage)
        by_line = np.linalg.solve(admittance, change.transpose(2, 1, 0))  # (F, K, changes)
        return voltage, np.asarray(-np.einsum("pd,fkd->pkf", weights, by_line), complex)

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float) -> tuple[Real, Real]:
        """Natural frequencies [Hz], ascending, and loss factors of the elastic modes up to the band's end.

        Hysteretic reading: a pole is w_n**2 (1 + j eta_n). Patches short-circuited. Modes below the band
        are good to a per cent or so: only their tails were trained.
        """
        poles = self.reduced.modal_form(youngs_modulus, poisson_ratio, loss_factor).poles
        elastic = poles[poles.real < (2 * np.pi * self.band[1]) ** 2]
        return np.sqrt(elastic.real) / (2 * np.pi), elastic.imag / elastic.real
