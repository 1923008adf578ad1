"""Transfers of a reduced plate with proportional damping: real modes, a fast approximation for training."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from simulation.reduction.dashpots import connected, forces
from simulation.reduction.energy_sums import LEAST_IMAGINARY_PART
from simulation.reduction.resonance_lines import resonance_lines, root_mean_square


@dataclass(frozen=True)
class DampedModes:
    """Undamped modes of a plate with identity mass, and the couplings in modal coordinates.

    A plate with lossless patches has complex modes. The difference does not matter for the choice of a space, and
    a real symmetric eigenproblem takes a thirtieth of the time.

    Attributes
    ----------
    squares : (r,) ndarray
        Squared angular frequencies, rad2/s2.
    shapes : (r, r) ndarray
        One a column.
    force : (r, P) ndarray
        Coupling of every patch to every mode.
    dashpots : (r, q) ndarray
        Of dashpots, likewise.
    """

    squares: Real
    shapes: Real
    force: Real
    dashpots: Real

    @classmethod
    def of(cls, stiffness: Real, coupling: Real, dashpots: Real | None = None) -> Self:
        """Solve the eigenproblem of a stiffness whose mass is the identity.

        Parameters
        ----------
        stiffness : (r, r) ndarray, rad2/s2
            Real; its symmetric part is taken.
        coupling : (r, P) ndarray
        dashpots : (r, q) ndarray, optional
            Columns whose product is the damping matrix, 1/s.

        Returns
        -------
        DampedModes
        """
        squares, shapes = np.linalg.eigh(0.5 * (stiffness + stiffness.T))  # scipy's version blocks other threads
        columns = np.zeros((len(squares), 0)) if dashpots is None else shapes.T @ dashpots
        return cls(squares, shapes, shapes.T @ coupling, columns)

    def lines(self, loss_factor: float, grid: Real) -> Real:
        """Lines that resolve every resonance, Hz, see `resonance_lines`."""
        return resonance_lines(np.sqrt(np.abs(self.squares)) / (2 * np.pi), loss_factor, grid)

    def terms(self, lines: Real, loss_factor: float) -> Complex:
        """1/((1 + j eta) w_r**2 - w**2), (r, F)."""
        return np.asarray(1.0 / ((1.0 + 1j * loss_factor) * self.squares[:, None] - (2 * np.pi * lines) ** 2))

    def transfers(self, lines: Real, loss_factor: float) -> Complex:
        """b_i' Z**-1 b_k between all patches, (P, P, F)."""
        ports = np.hstack([self.force, self.dashpots]).T
        residues = ports[:, None, :] * ports[None, :, :]
        return connected(residues @ self.terms(lines, loss_factor), self.dashpots.shape[1], lines)

    def modal(self, lines: Real, loss_factor: float) -> Complex:
        """Z**-1 b for every patch and line in the modes, (r, P, F)."""
        terms = self.terms(lines, loss_factor)
        answers = self.force[:, :, None] * terms[:, None, :]
        if not self.dashpots.size:
            return np.asarray(answers)
        moved = np.einsum("rq,rpf->qpf", self.dashpots, answers, optimize=True)
        x = forces((self.dashpots.T[:, None, :] * self.dashpots.T) @ terms, moved, lines)
        return np.asarray(answers - np.einsum("rq,qpf->rpf", self.dashpots, x, optimize=True) * terms[:, None, :])

    def responses(self, lines: Real, loss_factor: float) -> Real:
        """Real and imaginary parts of Z**-1 b for every patch and line, (r, 2 P F)."""
        modal = self.modal(lines, loss_factor).reshape(len(self.squares), -1)
        return np.asarray(self.shapes @ np.hstack([modal.real, modal.imag]))

    def gram(self, lines: Real, loss_factor: float) -> Real:
        """Product of the `responses` with their transpose, (r, r), computed without them if no dashpots act.

        A product of two terms is a difference, see `EnergySums`: the sums over the lines of all pairs of modes
        follow from those of every mode. Motions without stiffness get some damping for it.
        """
        if self.dashpots.size:
            modal = self.modal(lines, loss_factor).reshape(len(self.squares), -1)
            product = modal.real @ modal.real.T + modal.imag @ modal.imag.T
        else:
            squares = (2 * np.pi * lines) ** 2
            stiffness = np.maximum(np.abs(self.squares), LEAST_IMAGINARY_PART * squares.max())
            poles = self.squares + 1j * loss_factor * stiffness
            sums = (1.0 / (poles[:, None] - squares)).sum(axis=1)
            product = (sums.conj() - sums[:, None]) / (poles[:, None] - poles.conj())
            product = (self.force @ self.force.T) * product.real
        return np.asarray(self.shapes @ product @ self.shapes.T)


def relative_error(value: Complex, reference: Complex, lines: Real | None = None) -> float:
    """Largest deviation of any transfer over its reference's rms over the band.

    Parameters
    ----------
    value, reference : (..., F) ndarray
    lines : (F,) ndarray, optional
        Hz, where they are uneven; even unless given.
    """
    even = np.arange(float(reference.shape[-1])) if lines is None else lines
    rms = root_mean_square(reference, even)
    return float((np.abs(value - reference).max(axis=-1) / rms).max())
