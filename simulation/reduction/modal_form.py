"""A reduced plate at one set of constants: poles, and transfers as sums over them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
import scipy.linalg
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import ArrayLike, NDArray

from simulation.reduction.dashpots import connected, connected_derivatives, forces

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

SAME_POLE = 1e-9
"""Relative distance below which two poles count as one double pole."""

FAR, NODES = 4.0, 16
"""A pole beyond FAR times the highest squared frequency leaves 14**-NODES to interpolation."""


@dataclass(frozen=True)
class ModalForm:
    """Eigenvalues and eigenvectors of a complex symmetric stiffness whose mass is the identity, and dashpots.

    The right eigenvectors' inverse serves as left eigenvectors: the usual normalisation of complex
    symmetric eigenvectors, x'x = 1, has no answer where eigenvalues meet.

    Attributes
    ----------
    poles : (r,) ndarray
        Complex squared angular frequencies, rad2/s2, by ascending real part.
    shapes : (r, r) ndarray
        Right eigenvectors, one a column.
    inverse : (r, r) ndarray
        Left eigenvectors, one a row.
    dashpots : (r, q) ndarray
        Columns whose product is the damping matrix, 1/s; they are in none of the above.
    """

    poles: Complex
    shapes: Complex
    inverse: Complex
    dashpots: Real = field(default_factory=lambda: np.zeros((0, 0)))

    @classmethod
    def of(cls, stiffness: Complex, dashpots: Real | None = None) -> Self:
        """Solve the eigenproblem of a complex (r, r) stiffness; `dashpots` (r, q) are connected to its modes."""
        poles, shapes = np.linalg.eig(stiffness)  # scipy's holds the interpreter; this one lets other threads run
        order = np.argsort(poles.real)
        shapes = np.asfortranarray(shapes[:, order])
        inverse = scipy.linalg.inv(shapes, check_finite=False)
        return cls(poles[order], shapes, inverse, np.zeros((len(shapes), 0)) if dashpots is None else dashpots)

    @property
    def count(self) -> int:
        """Number of dashpots' columns q."""
        return int(self.dashpots.shape[1])

    def damped_poles(self) -> Complex:
        """Squared angular frequencies of free motion with the dashpots, rad2/s2, by ascending real part.

        Motions that die away without swinging are left out.
        """
        if not self.count:
            return self.poles
        damping = 1j * (self.inverse @ self.dashpots) @ (self.dashpots.T @ self.shapes)
        zero, one = np.zeros_like(damping), np.eye(len(damping))
        roots = np.linalg.eigvals(np.block([[zero, one], [np.diag(self.poles), damping]]))
        squares = roots[roots.real > np.abs(roots.imag)] ** 2
        return np.asarray(squares[np.argsort(squares.real)])

    def terms(self, frequency: ArrayLike) -> Complex:
        """1/(pole - w**2), (F, r)."""
        omega2 = (2 * np.pi * np.asarray(frequency, float)) ** 2
        return np.asarray(1.0 / (self.poles - omega2[:, None]))

    def solve(self, force: Real, frequency: ArrayLike) -> Complex:
        """Coordinates Z**-1 b for every column b of `force` (r, N): (N, F, r)."""
        weights = (self.inverse @ self._with_dashpots(force)).T
        terms = self.terms(frequency)
        answers = np.stack([(terms * weight) @ self.shapes.T for weight in weights])
        if not self.count:
            return np.asarray(answers)
        moved = np.einsum("rq,nfr->qnf", self.dashpots, answers)
        x = forces(moved[:, -self.count :], moved[:, : -self.count], frequency)
        return np.asarray(answers[: -self.count] - np.einsum("qfr,qnf->nfr", answers[-self.count :], x))

    def compliance(self, left: Real, right: Real, frequency: ArrayLike) -> Complex:
        """Return a' Z**-1 b for every column a of `left` (r, I) and b of `right` (r, J): (I, J, F)."""
        residues = self._residues(self._with_dashpots(left), self._with_dashpots(right))
        return connected(self._summed(residues, None, frequency), self.count, frequency)

    def compliance_and_derivatives(
        self, left: Real, right: Real, changes: Sequence[Real], frequency: ArrayLike
    ) -> tuple[Complex, Complex]:
        """`compliance` (I, J, F) and its derivatives (D, I, J, F).

        The derivative for a change K' (r, r) of the stiffness is -a' Z**-1 K' Z**-1 b. In modal
        coordinates the product of two terms 1/((p - s)(q - s)) is the difference of the single terms
        over q - p, so that a sum over pairs of poles and frequencies becomes one over pairs of poles
        and one over frequencies.
        """
        left, right = self._with_dashpots(left), self._with_dashpots(right)
        gap = self.poles[None, :] - self.poles[:, None]
        double = np.abs(gap) <= SAME_POLE * np.abs(self.poles)[:, None]
        weights = np.where(double, 0.0, 1.0 / np.where(double, 1.0, gap))
        a, b = left.T @ self.shapes, self.inverse @ right
        simple = [self._residues(left, right)]
        squared = [np.zeros_like(simple[0])]
        for change in changes:
            modal = self.inverse @ change @ self.shapes
            split = modal * weights
            simple.append((a @ split)[:, None] * b.T[None] - a[:, None] * (split @ b).T[None])
            squared.append(-a[:, None] * ((modal * double) @ b).T[None])
        sums = self._summed(np.stack(simple), np.stack(squared), frequency)
        slopes = connected_derivatives(sums[0], sums[1:], self.count, frequency)
        return connected(sums[0], self.count, frequency), slopes

    def _with_dashpots(self, ports: Real) -> Real:
        return np.hstack([ports, self.dashpots]) if self.count else ports

    def _residues(self, left: Real, right: Real) -> Complex:
        residues: Complex = (left.T @ self.shapes)[:, None, :] * (self.inverse @ right).T[None, :, :]
        return residues

    def _summed(self, simple: Complex, squared: Complex | None, frequency: ArrayLike) -> Complex:
        """Sum simple/(pole - s) + squared/(pole - s)**2 over the poles, (..., r) -> (..., F).

        What the poles far above the lines add is so smooth that a polynomial through few points gives
        it to rounding: most poles of a reduced model are far.
        """
        lines = np.atleast_1d(np.asarray(frequency, float))
        s = (2 * np.pi * lines) ** 2
        far = np.abs(self.poles) > FAR * s.max()
        if lines.size < 4 * NODES or not far.any():
            return _terms_summed(self.poles, simple, squared, s)
        near_sum = _terms_summed(
            self.poles[~far], simple[..., ~far], None if squared is None else squared[..., ~far], s
        )
        points, interpolation = _interpolation(s)
        far_sum = _terms_summed(
            self.poles[far], simple[..., far], None if squared is None else squared[..., far], points
        )
        return np.asarray(near_sum + far_sum @ interpolation.T)


def _terms_summed(poles: Complex, simple: Complex, squared: Complex | None, s: Real) -> Complex:
    """Sum over poles (r,) at squared angular frequencies s (F,), weights (..., r): (..., F)."""
    terms = 1.0 / (poles[:, None] - s)
    total = simple @ terms
    if squared is not None and squared.any():
        total += squared @ (terms * terms)
    return np.asarray(total)


def _interpolation(s: Real) -> tuple[Real, Real]:
    """Chebyshev points (NODES,) between the ends of s (F,), and the matrix (F, NODES) from them to s."""
    low, high = s.min(), s.max()
    points = np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)
    to_coefficients = chebvander(points, NODES - 1).T * (2.0 / NODES)
    to_coefficients[0] *= 0.5
    place = (2.0 * s - low - high) / (high - low)
    return 0.5 * (low + high + (high - low) * points), chebvander(place, NODES - 1) @ to_coefficients
