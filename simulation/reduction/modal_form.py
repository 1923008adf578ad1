"""A reduced plate at one set of constants: poles, and transfers as sums over them."""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real
from simulation.reduction.dashpots import connected, forces
from simulation.reduction.pole_sums import PoleSums
from simulation.reduction.symmetric_poles import symmetric_poles


@dataclass(frozen=True)
class ModalForm:
    """Eigenvalues and eigenvectors of a complex symmetric stiffness whose mass is the identity, and dashpots.

    The right eigenvectors' inverse serves as left eigenvectors. It is their transpose except where eigenvalues
    coincide: there the normalisation x'x = 1 of complex symmetric eigenvectors may be impossible.

    Attributes
    ----------
    poles : (r,) ndarray
        Complex squared angular frequencies, rad2/s2, by ascending real part.
    shapes : (r, r) ndarray
        Right eigenvectors, one a column.
    inverse : (r, r) ndarray
        Left eigenvectors, one a row.
    dashpots : (r, q) ndarray
        Columns whose product is the damping matrix, 1/s; not included in the other attributes.
    """

    poles: Complex
    shapes: Complex
    inverse: Complex
    dashpots: Real = field(default_factory=lambda: np.zeros((0, 0)))

    @classmethod
    def of(cls, stiffness: Complex, dashpots: Real | None = None) -> Self:
        """Solve the eigenproblem of a complex (r, r) stiffness; `dashpots` (r, q) are stored."""
        columns = np.zeros((len(stiffness), 0)) if dashpots is None else dashpots
        found = symmetric_poles(stiffness)
        if found is not None:
            order = np.argsort(found[0].real)
            shapes = np.asfortranarray(found[1][:, order])
            return cls(found[0][order], shapes, shapes.T, columns)
        poles, shapes = np.linalg.eig(stiffness)  # scipy's version holds the interpreter lock; this one does not
        order = np.argsort(poles.real)
        shapes = np.asfortranarray(shapes[:, order])
        return cls(poles[order], shapes, scipy.linalg.inv(shapes, check_finite=False), columns)

    @property
    def count(self) -> int:
        """Number of dashpots' columns q."""
        return int(self.dashpots.shape[1])

    def damped_poles(self) -> Complex:
        """Squared angular frequencies of free motion with the dashpots, rad2/s2, by ascending real part.

        Overdamped motions are left out.
        """
        if not self.count:
            return self.poles
        damping = 1j * (self.inverse @ self.dashpots) @ (self.dashpots.T @ self.shapes)
        zero, one = np.zeros_like(damping), np.eye(len(damping))
        roots = np.linalg.eigvals(np.block([[zero, one], [np.diag(self.poles), damping]]))
        squares = roots[roots.real > np.abs(roots.imag)] ** 2
        return np.asarray(squares[np.argsort(squares.real)])

    def solve(self, force: Real, frequency: ArrayLike) -> Complex:
        """Coordinates Z**-1 b for every column b of `force` (r, N): (N, F, r)."""
        weights = (self.inverse @ self.with_dashpots(force)).T
        sums = PoleSums.of(self.poles, frequency)
        answers = sums.simple(weights[:, None] * self.shapes).swapaxes(1, 2)
        if not self.count:
            return np.asarray(answers)
        moved = np.einsum("rq,nfr->qnf", self.dashpots, answers)
        x = forces(moved[:, -self.count :], moved[:, : -self.count], frequency)
        return np.asarray(answers[: -self.count] - np.einsum("qfr,qnf->nfr", answers[-self.count :], x))

    def compliance(self, left: Real, right: Real, frequency: ArrayLike, sums: PoleSums | None = None) -> Complex:
        """Return a' Z**-1 b for every column a of `left` and b of `right`.

        Parameters
        ----------
        left : (r, I) ndarray
        right : (r, J) ndarray
        frequency : (F,) array_like, Hz
        sums : PoleSums, optional
            Of `poles` at `frequency`, if known.

        Returns
        -------
        (I, J, F) complex ndarray
        """
        a, b = self.with_dashpots(left).T @ self.shapes, self.inverse @ self.with_dashpots(right)
        whole = (sums or PoleSums.of(self.poles, frequency)).simple(a[:, None] * b.T[None])
        return connected(whole, self.count, frequency)

    def with_dashpots(self, ports: Real) -> Real:
        """Columns (r, N) with those of the dashpots after them, (r, N + q)."""
        return np.hstack([ports, self.dashpots]) if self.count else ports
