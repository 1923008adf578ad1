"""What the recorder reads of a plate: sensor volts per actuator volt, and its derivatives."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from simulation.composition import STEP
from simulation.effect_operators import EffectOperators
from simulation.local_solution import LocalSolution
from simulation.plate_state import PlateState
from simulation.shell.electric_load import ElectricLoad

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Reading:
    """Sensors on their inputs, and the factor and constant that effects put on their signals.

    Attributes
    ----------
    voltage : (K, F) complex ndarray
        Across the sensors, per actuator volt.
    factor : (F,) complex ndarray
    response : (K, F) complex ndarray
        voltage times factor, plus the feedthrough.
    drive : (P, F) complex ndarray
        Volts on all patches per actuator volt.
    admittance : (F, K, K) complex ndarray
        Of `ElectricLoad.admittance`.
    sensors : list of int
    """

    voltage: Complex
    factor: Complex
    response: Complex
    drive: Complex
    admittance: Complex
    sensors: list[int]

    @classmethod
    def of(
        cls,
        solved: LocalSolution,
        state: PlateState,
        load: ElectricLoad,
        ops: EffectOperators,
        roles: tuple[int, list[int]],
    ) -> Self:
        """Read a solved plate."""
        actuator, sensors = roles
        compliance = solved.compliance()
        admittance = load.admittance(
            ops.capacitance[sensors], compliance[np.ix_(sensors, sensors)], solved.frequency
        )
        charge = compliance[sensors, actuator].T[..., None]
        voltage = np.asarray(-np.linalg.solve(admittance, charge)[..., 0].T, complex)
        factor = np.exp(state.log_gain + 1j * state.phase)
        drive = np.zeros((len(compliance), solved.frequency.size), complex)
        drive[actuator], drive[sensors] = 1.0, voltage
        return cls(voltage, factor, voltage * factor + state.feedthrough, drive, admittance, sensors)

    @property
    def sense(self) -> Complex:
        """How much the charge of each patch counts in each voltage, (K, P, F).

        Y V = -h gives Y V' = -(h' + G' V): minus the inverse of Y, on changes of compliance times `drive`.
        """
        sense = np.zeros((len(self.sensors), *self.drive.shape), complex)
        sense[:, self.sensors] = -np.linalg.inv(self.admittance).transpose(1, 2, 0)
        return sense

    def change(self, voltage: Complex, stepped: PlateState) -> Complex:
        """Differentiate `response`, (K, F), given that of the voltage (K, F) and the stepped state."""
        turned = (np.imag(stepped.log_gain) + 1j * np.imag(stepped.phase)) / STEP
        return np.asarray(self.factor * (voltage + self.voltage * turned) + np.imag(stepped.feedthrough) / STEP)
