"""Responses of a plate in one state over a band, in reduced coordinates for this state and band."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from simulation.reduction.composition import Composite, proportion
from simulation.reduction.modal_form import ModalForm
from simulation.reduction.pole_sums import PoleSums
from simulation.state.plate_state import PlateState, PointLoad
from simulation.twin.local_basis import REACH, local_basis
from simulation.twin.reduced_plate import LoadedPlate

CHUNK = 64
"""Number of lines solved at a time if the stiffness changes from line to line."""
DASHPOTS = 12
"""Directions of damping beyond which lines are factorized: the cost of connecting them grows with their square."""


@dataclass(frozen=True)
class LocalPlate:
    """A plate in one state, in reduced coordinates for this state.

    Attributes
    ----------
    basis : (r, m) ndarray
        Local coordinates: modes and residual vectors, orthonormal in the mass.
    composite : Composite
        In local coordinates; point springs and masses are in ``fixed`` and ``mass``.
    normal : (m, m) ndarray
    operators : LoadedPlate
    """

    basis: Real
    composite: Composite
    normal: Real
    operators: LoadedPlate

    @classmethod
    def of(cls, ops: LoadedPlate, whole: Composite, state: PlateState, reach: float = REACH) -> Self:
        """Choose local coordinates.

        Parameters
        ----------
        ops : LoadedPlate
        whole : Composite
            In all r coordinates, without the state's point loads.
        state : PlateState
        reach : float
            Modes are taken up to `reach` times the band's end; all of them if infinite.

        Returns
        -------
        LocalPlate
        """
        stiffness, mass = whole.fixed, whole.mass
        for load in state.point_loads:
            row = deflection_at(ops, load)
            stiffness = stiffness + load.stiffness * np.outer(row, row)
            mass = mass + load.mass * np.outer(row, row)
        whole = Composite(whole.plate, whole.plate_loss, stiffness, mass, whole.coupling)
        basis = local_basis(ops, whole, float(np.mean(state.storage)), reach)
        return cls(basis, _restricted(whole, basis), _small(ops.normal, basis), ops)

    def dashpots(self, state: PlateState) -> Real:
        """Damping of supports, and at points, (m, m), N s/m."""
        own = _small(self.operators.damping, self.basis)
        rows = [(load.damping, deflection_at(self.operators, load) @ self.basis) for load in state.point_loads]
        return np.asarray(sum((c * np.outer(row, row) for c, row in rows if c), own))


@dataclass(frozen=True)
class LocalSolution:
    """Z**-1 b of every port over the band, for one state.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    plate : LocalPlate
    state : PlateState
    modal : ModalForm or None
        Used if only -w**2 and few dashpots change over the band; None if lines are factorized one by one.
    """

    frequency: Real
    plate: LocalPlate
    state: PlateState
    modal: ModalForm | None
    by_lines: Complex | None = None

    @classmethod
    def of(
        cls, ops: LoadedPlate, whole: Composite, state: PlateState, frequency: Real, reach: float = REACH
    ) -> Self:
        """Choose local coordinates and solve.

        Parameters
        ----------
        ops : LoadedPlate
        whole : Composite
            In all r coordinates, without the state's point loads.
        state : PlateState
        frequency : (F,) ndarray, Hz
        reach : float
            Modes are taken up to `reach` times the band's end; all of them if infinite.

        Returns
        -------
        LocalSolution
        """
        plate = LocalPlate.of(ops, whole, state, reach)
        modal = _modal(plate, state)
        return cls(frequency, plate, state, modal, None if modal else _by_lines(plate, state, frequency))

    @property
    def basis(self) -> Real:
        """Of `plate`."""
        return self.plate.basis

    @property
    def composite(self) -> Composite:
        """Of `plate`."""
        return self.plate.composite

    @property
    def normal(self) -> Real:
        """Of `plate`."""
        return self.plate.normal

    @property
    def operators(self) -> LoadedPlate:
        """Of `plate`."""
        return self.plate.operators

    @cached_property
    def sums(self) -> PoleSums | None:
        """Of the modes over the band; None where lines are factorized."""
        return None if self.modal is None else PoleSums.of(self.modal.poles, self.frequency)

    @cached_property
    def answers(self) -> Complex:
        """Z**-1 b, (m, P, F)."""
        if self.modal is None or self.by_lines is not None:
            return np.asarray(self.by_lines)
        return np.ascontiguousarray(self.modal.solve(self.composite.coupling, self.frequency).transpose(2, 0, 1))

    def compliance(self, seen: Sequence[int] | None = None, driving: Sequence[int] | None = None) -> Complex:
        """b_i' Z**-1 b_j between ports `seen` (I,) and `driving` (J,), all unless given: (I, J, F), C/V."""
        coupling = self.composite.coupling
        rows, columns = (range(coupling.shape[1]) if some is None else some for some in (seen, driving))
        left, right = coupling[:, list(rows)], coupling[:, list(columns)]
        if self.modal is not None:
            return self.modal.compliance(left, right, self.frequency, self.sums)
        answers = self.answers[:, list(columns)]
        return np.asarray((left.T @ answers.reshape(len(left), -1)).reshape(-1, *answers.shape[1:]))


def deflection_at(ops: LoadedPlate, load: PointLoad) -> Real:
    """Row (r,) that gives w at a point load's place; ValueError if no point is declared there."""
    distance = np.hypot(*(ops.points - np.asarray(load.point)).T) if len(ops.points) else np.zeros(0)
    if not distance.size or distance.min() > 1e-6:
        known = ", ".join(f"({x:g}, {y:g})" for x, y in ops.points) or "none"
        raise ValueError(f"no load can act at {load.point} m; declared string and cable points: {known}")
    return np.asarray(ops.deflection[int(distance.argmin())])


def _restricted(whole: Composite, basis: Real) -> Composite:
    plate, same_loss = _small(whole.plate, basis), proportion(whole.plate_loss, whole.plate)
    return Composite(
        plate=plate,
        plate_loss=_small(whole.plate_loss, basis) if same_loss is None else same_loss * plate,
        fixed=_small(whole.fixed, basis),
        mass=_small(whole.mass, basis),
        coupling=basis.T @ whole.coupling,
    )


def _small(matrix: Real, basis: Real) -> Real:
    """Return a matrix in local coordinates."""
    return np.asarray(basis.T @ matrix @ basis) if matrix.any() else np.zeros((basis.shape[1],) * 2)


def _modal(plate: LocalPlate, state: PlateState) -> ModalForm | None:
    """Modes of a state whose stiffness, mass and few dashpots are the same at all lines; None for others."""
    varying = (state.area_mass, state.area_resistance)
    if any(s.any() for s in varying) or not _constant((state.storage, state.loss)):
        return None
    dashpots = plate.dashpots(state)
    power, directions = np.linalg.eigh(dashpots) if dashpots.any() else (np.zeros(0), np.zeros((len(dashpots), 0)))
    felt = power > 1e-13 * power.max(initial=0.0)
    if felt.sum() > DASHPOTS:
        return None
    local = plate.composite
    stiffness = state.storage[0] * local.plate + 1j * state.loss[0] * local.plate_loss + local.fixed
    return ModalForm.of(stiffness, directions[:, felt] * np.sqrt(power[felt]))


def _by_lines(plate: LocalPlate, state: PlateState, frequency: Real) -> Complex:
    """Z**-1 b over the band, (m, P, F), line by line."""
    local, dashpots = plate.composite, plate.dashpots(state)
    omega2 = (2 * np.pi * frequency) ** 2
    answers = np.empty((omega2.size, *local.coupling.shape), complex)
    for start in range(0, omega2.size, CHUNK):
        part = slice(start, start + CHUNK)
        w2 = omega2[part, None, None]
        air = 1j * np.sqrt(w2) * state.area_resistance[part, None, None] - w2 * state.area_mass[part, None, None]
        z: Complex = (
            state.storage[part, None, None] * local.plate
            + 1j * state.loss[part, None, None] * local.plate_loss
            + local.fixed
            - w2 * local.mass
            + air * plate.normal
            + 1j * np.sqrt(w2) * dashpots
        )
        answers[part] = np.linalg.solve(z, local.coupling.astype(complex))
    return np.ascontiguousarray(answers.transpose(1, 2, 0))


def _constant(spectra: Iterable[Real]) -> bool:
    return all(np.ptp(s) == 0.0 for s in spectra)
