"""A discretised plate with piezo patches: matrices, and answers by direct solution."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csc_matrix, csr_matrix, diags_array, hstack
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu

from simulation.electric_load import ElectricLoad
from simulation.shape_space import ShapeSpace

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def plane_stress_moduli(youngs_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """C1 = E/(1 - nu**2) and C2 = nu C1, Pa: the stiffness is affine in these two."""
    c1 = youngs_modulus / (1.0 - poisson_ratio**2)
    return c1, poisson_ratio * c1


@dataclass(frozen=True)
class ShellModel:
    """Sparse matrices of a plate with piezo patches over n unknowns.

    K = (1 + j eta)(C1 K1 + C2 K2) + Kp, with C1, C2 of `plane_stress_moduli`;
    M u'' + K u + b V = F and b'u - Cp V = -q for every patch.

    Attributes
    ----------
    space : ShapeSpace
    unknowns : (n,) ndarray
        Which of the 5 fields x functions are unknowns (counted field by field), in elimination order.
    stiffness_1, stiffness_2 : (n, n) csr_matrix
        K1 and K2, m3 and the like: times Pa gives a stiffness.
    stiffness_patch : (n, n) csr_matrix
        Kp, patches short-circuited.
    mass : (n, n) csr_matrix
    coupling : (n, P) ndarray
        b of every patch, N/V.
    capacitance : (P,) ndarray
        Cp of every patch at zero in-plane strain, F.
    """

    space: ShapeSpace
    unknowns: NDArray[np.int_]
    stiffness_1: csr_matrix
    stiffness_2: csr_matrix
    stiffness_patch: csr_matrix
    mass: csr_matrix
    coupling: Real
    capacitance: Real

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return int(self.unknowns.size)

    def stiffness(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float = 0.0) -> csr_matrix:
        """K at one set of plate constants, (n, n); real without loss."""
        c1, c2 = plane_stress_moduli(youngs_modulus, poisson_ratio)
        plate = c1 * self.stiffness_1 + c2 * self.stiffness_2
        if loss_factor:
            plate = (1.0 + 1j * loss_factor) * plate
        return csr_matrix(plate + self.stiffness_patch)

    def responses(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """Z**-1 b of every patch by direct solution, (n, P, F): minus the displacements per volt."""
        stiffness = self.stiffness(youngs_modulus, poisson_ratio, loss_factor)
        lines = np.atleast_1d(np.asarray(frequency, float))
        load = self.coupling.astype(complex)
        answers = [factorize(stiffness - (2 * np.pi * f) ** 2 * self.mass).solve(load) for f in lines]
        return np.stack(answers, axis=-1)

    def compliance(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """b_i' Z**-1 b_k between all patches by direct solution, (P, P, F), C/V."""
        answers = self.responses(youngs_modulus, poisson_ratio, loss_factor, frequency)
        return np.asarray(np.einsum("ni,nkf->ikf", self.coupling, answers))

    def frf(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: ArrayLike,
        *,
        actuator: int,
        sensors: Sequence[int],
        load: ElectricLoad,
    ) -> Complex:
        """Sensor voltages per volt on the actuator by direct solution, (K, F)."""
        coupled = self.compliance(youngs_modulus, poisson_ratio, loss_factor, frequency)
        chosen = list(sensors)
        return load.voltages(
            coupled[chosen, actuator], coupled[np.ix_(chosen, chosen)], self.capacitance[chosen], frequency
        )

    def deflection(self, points: Real) -> csr_matrix:
        """Matrix (K, n) that gives w at points (K, 2) in m."""
        points = np.asarray(points, float).reshape(-1, 2)
        if not len(points):
            return csr_matrix((0, self.size))
        low = np.array([self.space.x.position[0], self.space.y.position[0]])
        high = np.array([self.space.x.position[-1], self.space.y.position[-1]])
        outside = np.any((points < low) | (points > high), axis=1)
        if outside.any():
            raise ValueError(
                f"point {points[outside][0].tolist()} m is off the plate, "
                f"which spans {low.tolist()} to {high.tolist()} m"
            )
        values = self.space.values(points)
        empty = csr_matrix(values.shape)
        return csr_matrix(hstack([empty, empty, values, empty, empty], format="csc")[:, self.unknowns])

    def eigenfrequencies(self, youngs_modulus: float, poisson_ratio: float, count: int) -> Real:
        """Lowest `count` undamped natural frequencies, rigid body modes included, Hz, ascending."""
        stiffness = self.stiffness(youngs_modulus, poisson_ratio)
        shift = -((2 * np.pi * 5.0) ** 2)  # below zero, so that a free plate can be factorized
        factors = factorize(stiffness - shift * self.mass)
        values = eigsh(
            stiffness,
            count,
            self.mass,
            sigma=shift,
            OPinv=LinearOperator(stiffness.shape, matvec=factors.solve, dtype=float),
            v0=np.random.default_rng(0).standard_normal(self.size),
            return_eigenvectors=False,
        )
        return np.sort(np.sqrt(np.abs(values))) / (2 * np.pi)


def elimination_order(pattern: csr_matrix) -> NDArray[np.int_]:
    """Order of the unknowns that keeps the factors of matrices of this pattern sparse, (n,).

    Minimum degree, found by factorizing a matrix of the pattern that is surely positive definite.
    """
    ones = csr_matrix((np.ones_like(pattern.data, dtype=float), pattern.indices, pattern.indptr), pattern.shape)
    dominant = csc_matrix(ones + diags_array(2.0 * np.asarray(ones.sum(axis=1)).ravel() + 1.0))
    factors = splu(
        dominant, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, relax=1, options={"SymmetricMode": True}
    )
    return np.argsort(factors.perm_c).astype(np.int64)


def factorize(matrix: csr_matrix) -> SuperLU:
    """Factors of a (complex) symmetric matrix whose unknowns stand in elimination order.

    No pivoting: it would undo the order. Solutions stay good to about 1e-12 all the same, because a
    plate's dynamic stiffness away from an undamped resonance is far from singular.
    """
    return splu(
        csc_matrix(matrix),
        permc_spec="NATURAL",
        diag_pivot_thresh=0.0,
        relax=1,
        options={"SymmetricMode": True},
    )
