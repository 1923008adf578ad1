"""A reduced plate in one state, and reduced coordinates for its responses over a band."""

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
import scipy.linalg

from analysis.arrays import Real
from analysis.material import MaterialBox
from simulation.reduction.composition import COMPLEX_STEP, Composite, proportion
from simulation.reduction.modal_form import columns
from simulation.state.attached import Attachable, Seat
from simulation.state.plate_state import PlateState, PointLoad


class CompositeSlopes(Protocol):
    """Derivatives of a composite in some local coordinates."""

    def by(self, stepped: PlateState) -> Composite:
        """Differentiate by the parameter whose imaginary step of `COMPLEX_STEP` gave `stepped`."""
        ...

    def by_along_moves(self, stepped: PlateState) -> Composite:
        """Differentiate likewise what the moves of patches change."""
        ...


class LoadedPlate(Attachable, Protocol):
    """Loads and dampers of a reduced plate of r coordinates, besides its stiffness and its patches."""

    @property
    def band(self) -> tuple[float, float]:
        """Hz."""
        ...

    @property
    def damping(self) -> Real:
        """Of the supports' dashpots, (r, r), N s/m."""
        ...

    @property
    def normal(self) -> Real:
        """Integral of w times w, (r, r), m2."""
        ...

    @property
    def points(self) -> Real:
        """Where point loads can act, (K, 2), m."""
        ...

    @property
    def deflection(self) -> Real:
        """Deflection w there, (K, r)."""
        ...

    @property
    def deflection_slopes(self) -> Real:
        """Derivatives of `deflection` by shifts along x and y, (2, K, r), 1/m."""
        ...


class ReducedPlate(LoadedPlate, Protocol):
    """A plate with P patches and S footprints of transducers over r coordinates."""

    @property
    def box(self) -> MaterialBox:
        """Certified materials."""
        ...

    @property
    def error(self) -> float:
        """Certified error of a transfer."""
        ...

    @property
    def capacitance(self) -> Real:
        """Of the patches, (P,), F."""
        ...

    @property
    def footprints(self) -> Real:
        """Mean deflection over each, (S, r)."""
        ...

    @property
    def footprint_slopes(self) -> Real:
        """Derivatives of `footprints` by shifts along x and y, 1/m, and by a share of their area, (3, S, r)."""
        ...

    def require(self, state: PlateState) -> None:
        """ValueError, naming value and range, for a state that is not supported or not certified."""
        ...

    def composed(self, state: PlateState) -> Composite:
        """Return the matrices of a state, with the patches as ports."""
        ...

    def slopes(self, state: PlateState, basis: Real) -> CompositeSlopes:
        """Return derivatives of `composed` at a state, in the local coordinates that are columns of `basis`."""
        ...


KEPT_MODES_FACTOR = 1.6
"""Modes up to this many times the band's end are kept; those above are represented by residual vectors."""
RESIDUAL_BLOCKS = 3
"""Number of blocks of residual vectors, (K - s M)**-1 b and so on, in the space of the modes above."""
SHIFT_OVER_BAND = 0.6
"""Shift s over the square of the band's end. It is among the modes that are kept, which are projected out first:
the response of the modes above is then a hundred times more accurate than with a shift below the band."""
LEAST_COUPLING = 1e-4
"""Smallest strength, over the strongest, of directions that couple the modes above to those kept."""
LEAST_DIRECTION = 1e-7
"""Smallest relative size of a direction; smaller ones are left out."""


class LocalBasis(NamedTuple):
    """Local coordinates of a plate.

    Attributes
    ----------
    vectors : (r, m) ndarray
        Orthonormal in the mass.
    stiffness : (m,) ndarray or None
        Its diagonal, 1/s2, if the vectors are orthogonal in the mean stiffness.
    """

    vectors: Real
    stiffness: Real | None


@dataclass(frozen=True)
class _UnitMass:
    """Coordinates in which the mass is the identity; `root` (r, r) is its Cholesky factor, None if not needed."""

    root: Real | None

    @classmethod
    def of(cls, mass: Real) -> Self:
        if np.array_equal(mass, np.eye(len(mass))):
            return cls(None)
        return cls(scipy.linalg.cholesky(mass, lower=True, check_finite=False))

    def loads(self, loads: Real) -> Real:
        """Transform loads (r, k), or one side of a matrix, to these coordinates."""
        if self.root is None:
            return loads
        return np.asarray(scipy.linalg.solve_triangular(self.root, loads, lower=True, check_finite=False))

    def matrix(self, matrix: Real) -> Real:
        """Transform a symmetric matrix (r, r) to these coordinates."""
        return self.loads(self.loads(matrix).T)

    def back(self, vectors: Real) -> Real:
        """Transform vectors (r, k) to the original coordinates."""
        if self.root is None:
            return vectors
        found = scipy.linalg.solve_triangular(self.root, vectors, lower=True, trans="T", check_finite=False)
        return np.asarray(found)


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


def local_basis(
    ops: LoadedPlate, whole: Composite, storage: float, reach: float, further: Real | None = None
) -> LocalBasis:
    """Modes up to `reach` times the band's end, and residual vectors of ports, points and dashpots.

    Parameters
    ----------
    whole : Composite
        In all r coordinates.
    storage : float
        Mean factor on the plate's stiffness.
    reach : float
        Modes are taken up to `reach` times the band's end.
    further : (r, k) ndarray, optional
        Loads whose responses are wanted, too.

    Returns
    -------
    LocalBasis
        With r vectors for an infinite `reach`.
    """
    size = len(whole.mass)
    unit_mass = _UnitMass.of(whole.mass)
    if np.isinf(reach):
        return LocalBasis(unit_mass.back(np.eye(size)), None)
    end2 = (2 * np.pi * ops.band[1]) ** 2
    stiffness = unit_mass.matrix(storage * whole.plate + whole.fixed)
    # all modes: LAPACK's divide and conquer is twice as fast as its search for some of them
    squares, shapes = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    count = int((squares <= reach**2 * end2).sum())
    if count == size:
        return LocalBasis(unit_mass.back(shapes), squares)
    low, high, above = shapes[:, :count], shapes[:, count:], squares[count:, None] - SHIFT_OVER_BAND * end2
    loads = [whole.coupling, ops.deflection.T, columns(ops.damping, unit_mass.back(low))]
    loads += [] if further is None else [further]
    residual = _residual_vectors(high.T @ unit_mass.loads(np.hstack(loads)), above)
    if whole.fixed.any():
        # the ratio of patch to plate stiffness is complex and may change: the resulting change of modes is
        # included
        fixed = unit_mass.matrix(whole.fixed)
        follows = high.T @ (fixed @ np.hstack([low, high @ np.hstack(residual)])) / above
        power, directions = np.linalg.eigh(follows.T @ follows)
        strong = power > LEAST_COUPLING**2 * power[-1]
        residual.append(follows @ (directions[:, strong] / np.sqrt(power[-1])))
    beside = np.hstack(residual)
    beside = beside[:, np.linalg.norm(beside, axis=0) > 0.0]
    left, strength, _ = np.linalg.svd(beside / np.linalg.norm(beside, axis=0), full_matrices=False)
    apart = left[:, strength > LEAST_DIRECTION * strength[0]]
    own, turned = np.linalg.eigh(apart.T @ (squares[count:, None] * apart))
    vectors = np.hstack([low, high @ (apart @ turned)])
    return LocalBasis(unit_mass.back(vectors), np.concatenate([squares[:count], own]))


def _residual_vectors(loads: Real, above: Real) -> list[Real]:
    """Blocks (h, k) of residual vectors in the modes above, of unit length: loads over `above` once, twice, ..."""
    blocks = []
    for _ in range(RESIDUAL_BLOCKS):
        loads = loads / above
        loads = loads / np.maximum(np.linalg.norm(loads, axis=0), np.finfo(float).tiny)
        blocks.append(loads)
    return blocks
