"""A plate in one state, in reduced coordinates for this state."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from analysis.arrays import Real
from simulation.reduction.composition import COMPLEX_STEP, Composite, proportion
from simulation.state.attached import Seat
from simulation.state.plate_state import PlateState, PointLoad
from simulation.twin.local_basis import KEPT_MODES_FACTOR, LocalBasis, local_basis
from simulation.twin.reduced_plate import LoadedPlate


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
    def of(cls, ops: LoadedPlate, whole: Composite, state: PlateState, reach: float = KEPT_MODES_FACTOR) -> Self:
        """Choose local coordinates.

        Parameters
        ----------
        whole : Composite
            In all r coordinates, without the state's point loads.
        reach : float
            Modes are taken up to `reach` times the band's end; all of them if infinite.

        Returns
        -------
        LocalPlate
        """
        stiffness, mass = whole.fixed, whole.mass
        if state.area_stiffness:
            stiffness = stiffness + state.area_stiffness * ops.normal
        for load in state.point_loads:
            row = deflection_at(ops, load, state)
            stiffness = stiffness + load.stiffness * np.outer(row, row)
            mass = mass + load.mass * np.outer(row, row)
        whole = Composite(whole.plate, whole.plate_loss, stiffness, mass, whole.coupling)
        storage = float(np.mean(state.storage))
        # off the plate is refused also what does not act: a fit that lets its place go there could not go on
        rows = [(one, np.real(Seat.of(ops, one, state).row)) for one in state.attached]
        seats = [row for one, row in rows if one.acts]
        local = local_basis(ops, whole, storage, reach, np.array(seats).T if seats else None)
        return cls(local.vectors, _restricted(whole, local, storage), _small(ops.normal, local.vectors), ops)

    def dashpots(self, state: PlateState) -> Real:
        """Damping of supports, and at points, (m, m), N s/m."""
        own = _small(self.operators.damping, self.basis)
        loads = state.point_loads
        rows = [(load.damping, deflection_at(self.operators, load, state) @ self.basis) for load in loads]
        return np.asarray(sum((c * np.outer(row, row) for c, row in rows if c), own))


def deflection_at(ops: LoadedPlate, load: PointLoad, state: PlateState, *, stepped: bool = False) -> Real:
    """Row that gives w at a point load's place, or its derivative.

    Parameters
    ----------
    state : PlateState
        Its departures move the point.
    stepped : bool
        Whether the derivative is wanted by the parameter whose imaginary step gave `state`.

    Returns
    -------
    (r,) ndarray

    Raises
    ------
    ValueError
        If no point is declared there.
    """
    distance = np.hypot(*(ops.points - np.asarray(load.point)).T) if len(ops.points) else np.zeros(0)
    if not distance.size or distance.min() > 1e-6:
        known = ", ".join(f"({x:g}, {y:g})" for x, y in ops.points) or "none"
        raise ValueError(f"no load can act at {load.point} m; declared string and cable points: {known}")
    place = int(distance.argmin())
    away = [np.broadcast_to(one, len(ops.points))[place] for one in _attached(state)]
    if stepped:
        moved = [np.imag(one) / COMPLEX_STEP for one in away]
        return np.asarray(np.tensordot(moved, ops.deflection_slopes[:, place], 1))
    moved = [np.real(one) for one in away]
    row = ops.deflection[place]
    return np.asarray(row + np.tensordot(moved, ops.deflection_slopes[:, place], 1) if any(moved) else row)


def _attached(state: PlateState) -> tuple[Any, Any]:
    return state.departures.attached_x, state.departures.attached_y


def _restricted(whole: Composite, local: LocalBasis, storage: float) -> Composite:
    """Return matrices in local coordinates; `storage` is the mean factor on the plate's stiffness."""
    basis = local.vectors
    fixed, same_loss = _small(whole.fixed, basis), proportion(whole.plate_loss, whole.plate)
    known = local.stiffness
    plate = _small(whole.plate, basis) if known is None else (np.diag(known) - fixed) / storage
    return Composite(
        plate=plate,
        plate_loss=_small(whole.plate_loss, basis) if same_loss is None else same_loss * plate,
        fixed=fixed,
        mass=np.eye(basis.shape[1]),
        coupling=basis.T @ whole.coupling,
    )


def _small(matrix: Real, basis: Real) -> Real:
    """Return a matrix in local coordinates."""
    return np.asarray(basis.T @ matrix @ basis) if matrix.any() else np.zeros((basis.shape[1],) * 2)
