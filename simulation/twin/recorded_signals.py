"""Recorded signals of a plate with effects: outputs per unit of the input, and derivatives by any parameter."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from simulation.reduction.composition import COMPLEX_STEP
from simulation.reduction.modal_form import ModalSlopes
from simulation.state.plate_state import SPECTRA, Departures, PlateState
from simulation.twin.instruments import Instruments
from simulation.twin.local_plate import CompositeSlopes
from simulation.twin.local_solution import LocalSolution
from simulation.twin.sensitivity import ModalSensitivity, ParameterChange, TransferSensitivity
from simulation.twin.strain_energy import EnergySlopes, StateOf
from simulation.twin.transfer import Transfer


@dataclass(frozen=True)
class SignalReading:
    """Instruments connected to a plate, and the factor and constant of effects on their signals.

    Attributes
    ----------
    transfer : Transfer
        Before that factor.
    factor : (K, F) complex ndarray
    electric : (K, 1) ndarray
        1 for voltages that follow a voltage, to which the feedthrough is added; else 0.
    response : (K, F) complex ndarray
        Transfer times factor, plus feedthrough and crosstalk.
    ports : int
        Of the plate.
    capacitance : (P,) ndarray, F
        Of the patches as declared.
    """

    transfer: Transfer
    factor: Complex
    electric: NDArray[np.float64]
    response: Complex
    ports: int
    capacitance: Real

    @classmethod
    def of(
        cls, solved: LocalSolution, state: PlateState, instruments: Instruments, capacitance: NDArray[np.float64]
    ) -> Self:
        """Read a solved plate.

        Parameters
        ----------
        solved : LocalSolution
            Its coupling has a column for each port.
        capacitance : (P,) ndarray, F
            Of the patches as declared.

        Returns
        -------
        SignalReading
        """
        between = solved.compliance(instruments.seen, instruments.driving)
        away = state.departures
        wired = instruments.wired(away.resistance, away.capacitance)
        transfer = Transfer.of(wired, _capacitance(capacitance, away), between, solved.frequency)
        sensitivity = np.reshape(away.log_sensitivity, (-1, 1))
        factor = np.exp(sensitivity + state.log_gain + 1j * state.phase)
        driven_by_voltage = instruments.source < capacitance.size
        electric = np.array([[float(one.voltage and driven_by_voltage)] for one in instruments.pickups])
        response = transfer.response * factor + electric * (state.feedthrough + 1j * state.crosstalk)
        return cls(transfer, factor, electric, response, solved.composite.coupling.shape[1], capacitance)

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
        away = stepped.departures
        louder = np.reshape(np.imag(away.log_sensitivity), (-1, 1))
        turned = (louder + np.imag(stepped.log_gain) + 1j * np.imag(stepped.phase)) / COMPLEX_STEP
        if away.stepped:
            transfer = transfer + self._loaded(away)
        fed = self.electric * (np.imag(stepped.feedthrough) + 1j * np.imag(stepped.crosstalk)) / COMPLEX_STEP
        return np.asarray(self.factor * (transfer + self.transfer.response * turned) + fed)

    def _loaded(self, away: Departures) -> Complex:
        """Differentiate the transfer (K, F) by what is connected to the patches, given stepped departures."""
        wired = self.transfer.instruments
        capacitance = np.imag(_capacitance(self.capacitance, away)) / COMPLEX_STEP
        resistance = np.imag(away.resistance) / np.real(away.resistance) / COMPLEX_STEP
        inputs = np.imag(away.capacitance) / np.real(away.capacitance) / COMPLEX_STEP
        if not (wired.connected and (capacitance.any() or resistance or inputs)):
            return np.zeros_like(self.transfer.response)
        lines = self.transfer.frequency
        change = wired.across_change(capacitance, float(resistance), float(inputs), lines)
        # as a change of the charge on the connected ports at their present voltages
        felt = np.einsum("kcf,cf->kf", self.sense[:, list(wired.connected)], change * self.transfer.voltage)
        return np.asarray(felt)


def _capacitance(declared: Real, away: Departures) -> Any:
    """Capacitance (P,) of patches with other permittivities, areas and thicknesses, F."""
    return declared * (away.permittivity * away.patch_area / away.patch_thickness)


TOGETHER = 32
"""Parameters by which is differentiated at once: each holds four matrices of the plate, a megabyte."""


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of the outputs at one state.

    Attributes
    ----------
    reading : SignalReading
        What is differentiated.
    slopes : CompositeSlopes
        Of the plate's matrices.
    sensitivity : TransferSensitivity or ModalSensitivity
        Of the transfer by these.
    energy : (F,) ndarray
        Relative strain energy of the state.
    by_energy : EnergySlopes or None
        Derivatives of that energy; None if no effect depends on it.
    """

    reading: SignalReading
    slopes: CompositeSlopes
    sensitivity: TransferSensitivity | ModalSensitivity
    energy: Real
    by_energy: EnergySlopes | None

    @classmethod
    def of(
        cls,
        slopes: CompositeSlopes,
        solved: LocalSolution,
        reading: SignalReading,
        state_of: StateOf,
        energy: Real,
        scale: float,
    ) -> Self:
        """Prepare derivatives at a solved state.

        Parameters
        ----------
        slopes : CompositeSlopes
            Of the plate's matrices at the state, in the coordinates of `solved`.
        solved : LocalSolution
            Of the state at `energy`.
        reading : SignalReading
            Of it.
        state_of : callable
            (F,) relative strain energy -> PlateState.
        energy : (F,) ndarray
        scale : float
            Relative energies per J/V2.
        """
        state, transfer = solved.state, reading.transfer
        sensitivity: TransferSensitivity | ModalSensitivity
        if solved.modal is None:
            sensitivity = TransferSensitivity.of(solved, state, reading.drive, reading.sense)
        else:
            ports, instruments = solved.composite.coupling, transfer.instruments
            seen, driving = ports[:, list(instruments.seen)], ports[:, list(instruments.driving)]
            modal = ModalSlopes.of(solved.modal, seen, driving, solved.frequency, solved.sums)
            sensitivity = ModalSensitivity(solved, state, transfer, modal)
        follower = state_of(energy + 1j * COMPLEX_STEP)
        by_energy = None
        if any(np.imag(getattr(follower, name)).any() for name in (*SPECTRA, "log_gain", "phase")):
            by_energy = EnergySlopes.of(solved, transfer.instruments.source, state, follower, scale)
        return cls(reading, slopes, sensitivity, energy, by_energy)

    def by_each(self, states_of: Sequence[StateOf]) -> Iterator[Complex]:
        """Differentiate the outputs, (K, F), by each parameter that has an imaginary step in one of `states_of`.

        Together they take a third of the time.
        """
        for first in range(0, len(states_of), TOGETHER):
            steps = [self._step(one) for one in states_of[first : first + TOGETHER]]
            changes = self.sensitivity.by_each(steps)
            for (_, stepped), change in zip(steps, changes, strict=True):
                yield self.reading.change(change, stepped)

    def _step(self, state_of: StateOf) -> ParameterChange:
        stepped = state_of(self.energy)
        moved = self.slopes.by(stepped)
        if self.by_energy:
            stepped = state_of(self.energy + 1j * COMPLEX_STEP * self.by_energy.by(moved, stepped))
        return moved, stepped
