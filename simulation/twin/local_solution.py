"""Answers of a plate in one state over a band, in the few coordinates that this state and band need."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from simulation.reduction.composition import Composite
from simulation.reduction.dashpots import columns
from simulation.reduction.effect_operators import EffectOperators
from simulation.state.plate_state import PlateState, PointLoad

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

REACH = 1.6
"""Modes up to this many times the band's end are kept; what lies above answers through residual vectors."""
RESIDUALS = 3
"""Blocks of residual vectors, (K - s M)**-1 b and on."""
FOLLOWING = 20
CHUNK = 64
"""Lines solved at a time where the stiffness changes from line to line."""


@dataclass(frozen=True)
class LocalPlate:
    """A plate in one state, in the coordinates that this state needs.

    Attributes
    ----------
    basis : (r, m) ndarray
        Local coordinates: modes and residual vectors, orthonormal in the mass.
    composite : Composite
        In local coordinates; point springs and masses are in ``fixed`` and ``mass``.
    normal : (m, m) ndarray
    operators : EffectOperators
    """

    basis: Real
    composite: Composite
    normal: Real
    operators: EffectOperators

    @classmethod
    def of(cls, ops: EffectOperators, whole: Composite, state: PlateState, reach: float = REACH) -> Self:
        """Choose local coordinates, modes up to `reach` times the band's end (all if infinite)."""
        stiffness, mass = whole.fixed, whole.mass
        for load in state.point_loads:
            row = deflection_at(ops, load)
            stiffness = stiffness + load.stiffness * np.outer(row, row)
            mass = mass + load.mass * np.outer(row, row)
        whole = Composite(whole.plate, whole.plate_loss, stiffness, mass, whole.coupling)
        basis = _local_basis(ops, whole, float(np.mean(state.storage)), reach)
        return cls(basis, _restricted(whole, basis), basis.T @ ops.normal @ basis, ops)

    def dashpots(self, state: PlateState) -> Real:
        """Damping of supports, and at points, (m, m), N s/m."""
        own = self.basis.T @ self.operators.damping @ self.basis
        rows = [(load.damping, deflection_at(self.operators, load) @ self.basis) for load in state.point_loads]
        return np.asarray(sum((c * np.outer(row, row) for c, row in rows if c), own))


@dataclass(frozen=True)
class LocalSolution:
    """Z**-1 b of every patch over the band, for one state.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    plate : LocalPlate
    answers : (m, P, F) complex ndarray
    """

    frequency: Real
    plate: LocalPlate
    answers: Complex

    @classmethod
    def of(
        cls, ops: EffectOperators, whole: Composite, state: PlateState, frequency: Real, reach: float = REACH
    ) -> Self:
        """Choose local coordinates, modes up to `reach` times the band's end (all if infinite), and solve."""
        plate = LocalPlate.of(ops, whole, state, reach)
        return cls(frequency, plate, _solve(plate, state, frequency))

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
    def operators(self) -> EffectOperators:
        """Of `plate`."""
        return self.plate.operators

    def compliance(self) -> Complex:
        """b_i' Z**-1 b_j between all patches, (P, P, F), C/V."""
        m, p, f = self.answers.shape
        return np.asarray((self.composite.coupling.T @ self.answers.reshape(m, -1)).reshape(p, p, f))


def deflection_at(ops: EffectOperators, load: PointLoad) -> Real:
    """Row (r,) that gives w at a point load's place; ValueError where no load can act."""
    distance = np.hypot(*(ops.points - np.asarray(load.point)).T) if len(ops.points) else np.zeros(0)
    if not distance.size or distance.min() > 1e-6:
        known = ", ".join(f"({x:g}, {y:g})" for x, y in ops.points) or "none"
        raise ValueError(f"no load can act at {load.point} m; declared string and cable points: {known}")
    return np.asarray(ops.deflection[int(distance.argmin())])


def _restricted(whole: Composite, basis: Real) -> Composite:
    def small(matrix: Real) -> Real:
        return np.asarray(basis.T @ matrix @ basis) if matrix.any() else np.zeros((basis.shape[1],) * 2)

    return Composite(
        plate=small(whole.plate),
        plate_loss=small(whole.plate_loss),
        fixed=small(whole.fixed),
        mass=small(whole.mass),
        coupling=basis.T @ whole.coupling,
    )


def _local_basis(ops: EffectOperators, whole: Composite, storage: float, reach: float) -> Real:
    """Modes up to `reach` times the band's end, and residual vectors of patches, points and dashpots, (r, m)."""
    root = scipy.linalg.cholesky(whole.mass, lower=True, check_finite=False)
    if np.isinf(reach):
        return np.asarray(scipy.linalg.solve_triangular(root, np.eye(len(root)), lower=True, trans="T"))
    stiffness = storage * whole.plate + whole.fixed
    end = 2 * np.pi * ops.band[1]
    half = scipy.linalg.solve_triangular(root, stiffness, lower=True, check_finite=False)
    standard = scipy.linalg.solve_triangular(root, half.T, lower=True, check_finite=False)
    # all of them: LAPACK's divide and conquer is twice as fast as its search for those wanted
    squares, shapes = np.linalg.eigh(0.5 * (standard + standard.T))
    shapes = shapes[:, squares <= (reach * end) ** 2]
    modes = scipy.linalg.solve_triangular(root, shapes, lower=True, trans="T", check_finite=False)
    loads = [whole.coupling, ops.deflection.T, columns(ops.damping, modes)]
    block = scipy.linalg.solve_triangular(root, np.hstack(loads), lower=True, check_finite=False)
    shifted = scipy.linalg.cho_factor(standard + (0.5 * end) ** 2 * np.eye(len(standard)), check_finite=False)
    residual = []
    for _ in range(RESIDUALS):
        block = scipy.linalg.cho_solve(shifted, block, check_finite=False)
        block = block / np.linalg.norm(block, axis=0)
        residual.append(block)
    if whole.fixed.any():
        # the ratio of patch to plate stiffness is complex and may change: how modes follow it belongs here too
        fixed = scipy.linalg.solve_triangular(root, whole.fixed, lower=True, check_finite=False)
        fixed = scipy.linalg.solve_triangular(root, fixed.T, lower=True, check_finite=False)
        follows = scipy.linalg.cho_solve(shifted, fixed @ np.hstack([shapes, residual[0]]), check_finite=False)
        follows -= shapes @ (shapes.T @ follows)
        left, strength, _ = np.linalg.svd(follows, full_matrices=False)
        residual.append(left[:, :FOLLOWING] * (strength[:FOLLOWING] / strength[0]))
    beside = np.hstack(residual)
    for _ in range(2):
        beside = beside - shapes @ (shapes.T @ beside)
    left, strength, _ = np.linalg.svd(beside / np.linalg.norm(beside, axis=0), full_matrices=False)
    local = np.hstack([shapes, left[:, strength > 1e-5 * strength[0]]])
    return np.asarray(scipy.linalg.solve_triangular(root, local, lower=True, trans="T", check_finite=False))


def _solve(plate: LocalPlate, state: PlateState, frequency: Real) -> Complex:
    """Z**-1 b over the band, (m, P, F): by modes where only -w**2 changes along the band, else line by line."""
    local, dashpots = plate.composite, plate.dashpots(state)
    omega2 = (2 * np.pi * frequency) ** 2
    varying = (state.area_mass, state.area_resistance)
    if not dashpots.any() and not any(s.any() for s in varying) and _constant((state.storage, state.loss)):
        stiffness = state.storage[0] * local.plate + 1j * state.loss[0] * local.plate_loss + local.fixed
        poles, shapes = np.linalg.eig(stiffness)
        weights = np.linalg.solve(shapes, local.coupling.astype(complex))
        modal = weights[:, :, None] / (poles[:, None] - omega2)[:, None, :]
        return np.asarray((shapes @ modal.reshape(len(poles), -1)).reshape(modal.shape))
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
