"""A reduced plate with piezo patches: small dense matrices for a box of materials and a band; its modes."""

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real
from analysis.material import MaterialBox
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.modal_form import ModalForm
from simulation.shell.rigidity import plane_stress_moduli


@dataclass(frozen=True)
class ReducedModel:
    """K = (1 + j eta)(C1 K1 + C2 K2) + Kp, and dashpots, over r coordinates whose mass matrix is the identity.

    Attributes
    ----------
    stiffness_1, stiffness_2, stiffness_patch : (r, r) ndarray
        Real symmetric.
    coupling : (r, P) ndarray
        b of every patch, N/V.
    capacitance : (P,) ndarray
        Cp of every patch, F.
    box : MaterialBox
        Ranges of materials for which the error is certified.
    band : (float, float)
        Hz; likewise.
    error : float
        Largest error, against the full model, at materials and frequencies outside the training set:
        of a transfer between patches relative to its rms over the band, and of the field, as rms over
        the points, relative to its rms over points, inputs and band.
    dashpots : (r, q) ndarray
        Columns whose product is the damping matrix of the supports' dashpots, 1/s.
    deflection : (K, r) ndarray
        w at `points` of every coordinate; K = 0 without a field.
    points : (K, 2) ndarray
        m.
    footprints : (S, r) ndarray
        Mean deflection over the footprints of transducers: forces there are inputs of the training, like patches.
    """

    stiffness_1: Real
    stiffness_2: Real
    stiffness_patch: Real
    coupling: Real
    capacitance: Real
    box: MaterialBox
    band: tuple[float, float]
    error: float
    dashpots: Real
    deflection: Real = field(default_factory=lambda: np.zeros((0, 0)))
    points: Real = field(default_factory=lambda: np.zeros((0, 2)))
    footprints: Real = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        size = len(self.coupling)
        for name in ("stiffness_1", "stiffness_2", "stiffness_patch"):
            matrix = getattr(self, name)
            if matrix.shape != (size, size) or not np.isfinite(matrix).all():
                raise ValueError(f"reduced model: {name} {matrix.shape} must be finite and ({size}, {size})")
        if self.capacitance.shape != self.coupling.shape[1:]:
            raise ValueError(
                f"reduced model: {self.capacitance.shape} capacitances for {self.coupling.shape[1]} patches"
            )
        if self.dashpots.ndim != 2 or len(self.dashpots) != size:
            raise ValueError(f"reduced model: dashpots {self.dashpots.shape} of {size} coordinates")
        if len(self.footprints) and self.footprints.shape[1] != size:
            raise ValueError(f"reduced model: footprints {self.footprints.shape} of {size} coordinates")
        if len(self.deflection) != len(self.points):
            raise ValueError(
                f"reduced model: {len(self.deflection)} rows of deflection, {len(self.points)} points"
            )

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.coupling)

    @property
    def ports(self) -> Real:
        """Columns of the patches, then of the footprints, (r, P + S)."""
        return np.hstack([self.coupling, self.footprints.T]) if len(self.footprints) else self.coupling

    def loaded(self, masses: Real) -> Self:
        """Return the plate with masses (S,), kg, added at the footprints; in other coordinates."""
        if not np.any(masses):
            return self
        mass = np.eye(self.size) + (self.footprints.T * masses) @ self.footprints
        root = scipy.linalg.cholesky(mass, lower=True)
        return self.restricted(scipy.linalg.solve_triangular(root, np.eye(self.size), lower=True).T)

    def require(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike = ()
    ) -> None:
        """Raise ValueError for constants or frequencies outside the trained box or band.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : array_like, Hz
            Of any shape; none is checked unless given.

        Raises
        ------
        ValueError
            With the value seen and the range allowed.
        """
        self.box.require(youngs_modulus, poisson_ratio, loss_factor)
        certified_lines(frequency, self.band)

    def stiffness(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float) -> Complex:
        """Complex stiffness K at one material.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Returns
        -------
        (r, r) complex ndarray, rad2/s2
        """
        c1, c2 = plane_stress_moduli(youngs_modulus, poisson_ratio)
        plate = c1 * self.stiffness_1 + c2 * self.stiffness_2
        return np.asarray((1.0 + 1j * loss_factor) * plate + self.stiffness_patch, complex)

    def restricted(self, basis: Real) -> Self:
        """Galerkin model on the columns of `basis` (r, s), orthonormal in the mass; same ranges and error."""
        return replace(
            self,
            stiffness_1=basis.T @ self.stiffness_1 @ basis,
            stiffness_2=basis.T @ self.stiffness_2 @ basis,
            stiffness_patch=basis.T @ self.stiffness_patch @ basis,
            coupling=basis.T @ self.coupling,
            deflection=self.deflection @ basis if len(self.points) else np.zeros((0, basis.shape[1])),
            footprints=self.footprints @ basis if len(self.footprints) else np.zeros((0, basis.shape[1])),
            dashpots=basis.T @ self.dashpots,
        )

    def modal_form(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float) -> ModalForm:
        """Poles and shapes at one material.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Raises
        ------
        ValueError
            Outside the trained box.
        """
        self.require(youngs_modulus, poisson_ratio, loss_factor)
        return ModalForm.of(self.stiffness(youngs_modulus, poisson_ratio, loss_factor), self.dashpots)

    def damped_modes(self, youngs_modulus: float, poisson_ratio: float) -> DampedModes:
        """Real modes, and the couplings of patches and dashpots to them; see `DampedModes` for their limits.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        """
        stiffness = self.stiffness(youngs_modulus, poisson_ratio, 0.0).real
        return DampedModes.of(stiffness, self.coupling, self.dashpots)

    def compliance(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """Return b_i' Z**-1 b_k between all patches.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) array_like, Hz

        Returns
        -------
        (P, P, F) complex ndarray, C/V

        Raises
        ------
        ValueError
            Outside the trained box or band.
        """
        self.require(youngs_modulus, poisson_ratio, loss_factor, frequency)
        modal = self.modal_form(youngs_modulus, poisson_ratio, loss_factor)
        return modal.compliance(self.coupling, self.coupling, frequency)

    def amplitudes(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: ArrayLike,
        inputs: ArrayLike | None = None,
    ) -> Complex:
        """Coordinates A per unit of each input, patches short-circuited.

        The field is w = deflection @ A[n, f], in m/V; of a footprint in m per -1 N along z.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) array_like, Hz
        inputs : (N,) array_like of int, optional
            Columns of `ports`; all unless given.

        Returns
        -------
        (N, F, r) complex ndarray

        Raises
        ------
        ValueError
            Outside the trained box or band.
        """
        self.require(youngs_modulus, poisson_ratio, loss_factor, frequency)
        modal = self.modal_form(youngs_modulus, poisson_ratio, loss_factor)
        chosen = slice(None) if inputs is None else np.atleast_1d(np.asarray(inputs, int))
        return -modal.solve(self.ports[:, chosen], frequency)


def certified_lines(frequency: ArrayLike, band: tuple[float, float]) -> Real:
    """Return frequencies, Hz, as an array of one axis or more; ValueError for one outside the band, Hz."""
    lines = np.atleast_1d(np.asarray(frequency, float))
    low, high = band
    outside = lines[~((lines >= low * (1 - 1e-9)) & (lines <= high * (1 + 1e-9)))]
    if outside.size:
        raise ValueError(f"frequency {outside[0]:.6g} Hz is outside the twin's band, {low:g} to {high:g} Hz")
    return lines


def lowest_modes(
    model: ReducedModel, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int
) -> tuple[Complex, Real]:
    """Lowest undamped modes, with the damping of each by plate and dashpots (patches are lossless).

    Parameters
    ----------
    youngs_modulus : float
        Pa.
    count : int
        r at most.

    Returns
    -------
    squares : (count,) complex ndarray, rad2/s2
        Squared angular frequencies, with the damping as imaginary part.
    shapes : (r, count) ndarray

    Raises
    ------
    ValueError
        Outside the trained box.
    """
    model.require(youngs_modulus, poisson_ratio, loss_factor)
    stiffness = model.stiffness(youngs_modulus, poisson_ratio, loss_factor)
    values, shapes = scipy.linalg.eigh(stiffness.real, subset_by_index=(0, min(count, model.size) - 1))
    lost = np.einsum("rm,rs,sm->m", shapes, stiffness.imag, shapes)
    viscous = np.sqrt(np.abs(values)) * ((model.dashpots.T @ shapes) ** 2).sum(axis=0)
    return values + 1j * (lost + viscous), shapes
