"""Recorded signals of a plate with effects: outputs per unit of the input, and their derivatives."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex
from simulation.reduction.composition import STEP
from simulation.state.plate_state import PlateState
from simulation.twin.instruments import Instruments
from simulation.twin.local_solution import LocalSolution
from simulation.twin.transfer import Transfer


@dataclass(frozen=True)
class SignalReading:
    """Instruments connected to a plate, and the factor and constant of effects on their signals.

    Attributes
    ----------
    transfer : Transfer
        Before that factor.
    factor : (F,) complex ndarray
    electric : (K, 1) ndarray
        1 for voltages that follow a voltage, to which the feedthrough is added; else 0.
    response : (K, F) complex ndarray
        Transfer times factor, plus the feedthrough.
    ports : int
        Of the plate.
    """

    transfer: Transfer
    factor: Complex
    electric: NDArray[np.float64]
    response: Complex
    ports: int

    @classmethod
    def of(
        cls, solved: LocalSolution, state: PlateState, instruments: Instruments, capacitance: NDArray[np.float64]
    ) -> Self:
        """Read a solved plate.

        Parameters
        ----------
        solved : LocalSolution
            Its coupling has a column for each port.
        state : PlateState
        instruments : Instruments
        capacitance : (P,) ndarray, F
            Of the patches.

        Returns
        -------
        SignalReading
        """
        between = solved.compliance(instruments.seen, instruments.driving)
        transfer = Transfer.of(instruments, capacitance, between, solved.frequency)
        factor = np.exp(state.log_gain + 1j * state.phase)
        driven_by_voltage = instruments.source < capacitance.size
        electric = np.array([[float(one.voltage and driven_by_voltage)] for one in instruments.pickups])
        response = transfer.response * factor + electric * state.feedthrough
        return cls(transfer, factor, electric, response, solved.composite.coupling.shape[1])

    @property
    def drive(self) -> Complex:
        """Of `Transfer.drive`, (ports, F)."""
        return self.transfer.drive(self.ports)

    @property
    def sense(self) -> Complex:
        """Of `Transfer.sense`, (K, ports, F)."""
        return self.transfer.sense(self.ports)

    def change(self, transfer: Complex, stepped: PlateState) -> Complex:
        """Differentiate `response`, (K, F), given that of the transfer (K, F) and the stepped state."""
        turned = (np.imag(stepped.log_gain) + 1j * np.imag(stepped.phase)) / STEP
        fed = self.electric * np.imag(stepped.feedthrough) / STEP
        return np.asarray(self.factor * (transfer + self.transfer.response * turned) + fed)
