"""A discretised plate with piezo patches: matrices, and responses by direct solution."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator, eigsh

from analysis.arrays import Complex, Real
from analysis.channel import Footprint
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.points import footprint_rows
from simulation.shell.rigidity import W, plane_stress_moduli
from simulation.shell.shell_plate import ShellPlate
from simulation.shell.space import ShapeSpace
from simulation.shell.unknowns import Unknowns, factorize


@dataclass(frozen=True)
class ShellModel:
    """Sparse matrices of a plate with piezo patches over n unknowns.

    K = (1 + j eta)(C1 K1 + C2 K2) + Kp, with C1, C2 of `plane_stress_moduli`;
    M u'' + C u' + K u + b V = F and b'u - Cp V = -q for every patch.

    Attributes
    ----------
    shell : ShellPlate
    unknowns : Unknowns
    stiffness_1, stiffness_2 : (n, n) csr_matrix
        K1 and K2, m3 and the like: times Pa gives a stiffness.
    stiffness_patch : (n, n) csr_matrix
        Kp: patches short-circuited, and springs of supports.
    mass : (n, n) csr_matrix
    damping : (n, n) csr_matrix
        C, N s/m: dashpots of supports.
    coupling : (n, P) ndarray
        b of every patch, N/V.
    capacitance : (P,) ndarray
        Cp of every patch at zero in-plane strain, F.
    dropped : float
        See `simulation.shell.assembly.Choice`: estimate of the energy missing in the responses.
    """

    shell: ShellPlate
    unknowns: Unknowns
    stiffness_1: csr_matrix
    stiffness_2: csr_matrix
    stiffness_patch: csr_matrix
    mass: csr_matrix
    damping: csr_matrix
    coupling: Real
    capacitance: Real
    dropped: float = 0.0

    @property
    def space(self) -> ShapeSpace:
        """Function space from which the unknowns were selected."""
        return self.shell.space

    @property
    def size(self) -> int:
        """Number of unknowns n."""
        return self.unknowns.size

    def stiffness(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float = 0.0) -> csr_matrix:
        """Stiffness K at one set of plate constants.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Returns
        -------
        (n, n) csr_matrix
            Real without loss.
        """
        c1, c2 = plane_stress_moduli(youngs_modulus, poisson_ratio)
        plate = c1 * self.stiffness_1 + c2 * self.stiffness_2
        if loss_factor:
            plate = (1.0 + 1j * loss_factor) * plate
        return csr_matrix(plate + self.stiffness_patch)

    def responses(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """Return Z**-1 b of every patch by direct solution: minus the displacements per volt.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) array_like, Hz

        Returns
        -------
        (n, P, F) complex ndarray
            m/V and rad/V.
        """
        stiffness = self.stiffness(youngs_modulus, poisson_ratio, loss_factor)
        lines = np.atleast_1d(np.asarray(frequency, float))
        load = self.coupling.astype(complex)
        dynamic = (stiffness - w**2 * self.mass + 1j * w * self.damping for w in 2 * np.pi * lines)
        return np.stack([factorize(z).solve(load) for z in dynamic], axis=-1)

    def compliance(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """Return b_i' Z**-1 b_k between all patches by direct solution.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) array_like, Hz

        Returns
        -------
        (P, P, F) complex ndarray, C/V
        """
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
        """Sensor voltages per volt on the actuator by direct solution.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) array_like, Hz, above 0
        actuator : int
            Place among the patches.
        sensors : sequence of int
            Places of the K sensors.
        load : ElectricLoad
            Across every sensor.

        Returns
        -------
        (K, F) complex ndarray, V/V
        """
        coupled = self.compliance(youngs_modulus, poisson_ratio, loss_factor, frequency)
        chosen = list(sensors)
        return load.voltages(
            coupled[chosen, actuator], coupled[np.ix_(chosen, chosen)], self.capacitance[chosen], frequency
        )

    def deflection(self, points: Real) -> csr_matrix:
        """Matrix (K, n) that gives w at points (K, 2) in m."""
        return self.unknowns.rows(self.space.values(np.asarray(points, float).reshape(-1, 2)), W)

    def footprint_rows(self, footprints: Sequence[Footprint]) -> Real:
        """Rows (S, n) that give the mean deflection over each footprint; transposed, unit forces there."""
        return np.asarray(self.unknowns.rows(footprint_rows(self.space, footprints), W).toarray())

    def eigenfrequencies(self, youngs_modulus: float, poisson_ratio: float, count: int) -> Real:
        """Lowest undamped natural frequencies, rigid body modes included.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Returns
        -------
        (count,) ndarray, Hz
            Ascending.
        """
        stiffness = self.stiffness(youngs_modulus, poisson_ratio)
        shift = -((2 * np.pi * 5.0) ** 2)  # negative, so that a free plate's matrix is not singular
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
