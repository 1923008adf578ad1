"""What the recorder reads of a plate: sensor volts per actuator volt, and its derivatives."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from simulation.composition import STEP
from simulation.effect_operators import EffectOperators
from simulation.electric_load import ElectricLoad
from simulation.local_solution import LocalSolution
from simulation.plate_state import PlateState

Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Reading:
    """Sensors on their inputs, and the factor and constant that effects put on their signals.

    Attributes
    ----------
    voltage : (K, F) complex ndarray
        Across the sensors, per actuator volt.
    admittance : (F, K, K) complex ndarray
        Of `ElectricLoad.admittance`.
    factor : (F,) complex ndarray
    response : (K, F) complex ndarray
        voltage times factor, plus the feedthrough.
    actuator, sensors : int, list of int
    """

    voltage: Complex
    admittance: Complex
    factor: Complex
    response: Complex
    actuator: int
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
        patches = ops.capacitance[sensors]
        between = compliance[np.ix_(sensors, sensors)]
        voltage = load.voltages(compliance[sensors, actuator], between, patches, solved.frequency)
        factor = np.exp(state.log_gain + 1j * state.phase)
        return cls(
            voltage=voltage,
            admittance=load.admittance(patches, between, solved.frequency),
            factor=factor,
            response=voltage * factor + state.feedthrough,
            actuator=actuator,
            sensors=sensors,
        )

    def change(self, compliance: Complex, stepped: PlateState) -> Complex:
        """Differentiate `response`, (K, F), given that of the compliance (P, P, F) and the stepped state.

        Y V = -h gives Y V' = -(h' + G' V).
        """
        load = compliance[self.sensors, self.actuator]
        load = load + np.einsum("ijf,jf->if", compliance[np.ix_(self.sensors, self.sensors)], self.voltage)
        moved = -np.linalg.solve(self.admittance, load.T[..., None])[..., 0].T
        turned = (np.imag(stepped.log_gain) + 1j * np.imag(stepped.phase)) / STEP
        return np.asarray(self.factor * (moved + self.voltage * turned) + np.imag(stepped.feedthrough) / STEP)
