"""Reduced coordinates for the responses of a plate in one state over a band, without significant error."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
import scipy.linalg

from analysis.arrays import Real
from simulation.reduction.composition import Composite
from simulation.reduction.dashpots import columns
from simulation.twin.reduced_plate import LoadedPlate

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


def _residual_vectors(loads: Real, above: Real) -> list[Real]:
    """Blocks (h, k) of residual vectors in the modes above, of unit length: loads over `above` once, twice, ..."""
    blocks = []
    for _ in range(RESIDUAL_BLOCKS):
        loads = loads / above
        loads = loads / np.maximum(np.linalg.norm(loads, axis=0), np.finfo(float).tiny)
        blocks.append(loads)
    return blocks
