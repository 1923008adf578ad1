"""Responses of a reduced plate by its modes: transfers with proportional damping, and energies of all lines.

Frequencies for the comparison of a plate's responses: an even grid, and lines on every narrow resonance.

At a loss factor of 1e-3 a resonance at 500 Hz is half a hertz wide: an even grid of a few hundred lines does not
resolve it.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Complex, Real
from simulation.reduction.modal_form import ModalForm, PoleSums, connected, forces, of_dashpots


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
        acting = of_dashpots(self.dashpots.shape[1], lines)
        return connected(residues @ self.terms(lines, loss_factor), acting)

    def modal(self, lines: Real, loss_factor: float) -> Complex:
        """Z**-1 b for every patch and line in the modes, (r, P, F)."""
        terms = self.terms(lines, loss_factor)
        answers = self.force[:, :, None] * terms[:, None, :]
        if not self.dashpots.size:
            return np.asarray(answers)
        moved = np.einsum("rq,rpf->qpf", self.dashpots, answers, optimize=True)
        acting = of_dashpots(self.dashpots.shape[1], lines)
        x = forces((self.dashpots.T[:, None, :] * self.dashpots.T) @ terms, moved, acting)
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


LEAST_IMAGINARY_PART = 1e-6
"""Smallest imaginary part of a pole, as a share of its size or of the highest squared frequency: with a smaller
one (rigid motions of a free plate) the distance to a conjugate pole is too small a divisor."""


@dataclass(frozen=True)
class EnergySums:
    """Products x_nᴴ G x_m of the responses x_n = Z⁻¹ b_n to N loads at F lines.

    Over modes S with poles p, x_nᴴ G x_m = Σ_jk conj(a_jn / (p_j - s)) (Sᴴ G S)_jk a_km / (p_k - s). A product of
    two terms is a difference, 1/((p_j* - s)(p_k - s)) = (1/(p_j* - s) - 1/(p_k - s)) / (p_k - p_j*), so that the
    double sum becomes a single one and its Hermitian transpose: N² r products a line in place of N r².
    Rounding errors grow with the square of the shapes' condition number: 1e-10 where two poles are 1e-8 of their
    coupling from a common shape; equal poles with two shapes are harmless.

    Attributes
    ----------
    modal : ModalForm
        Without dashpots.
    weights : (r, N) ndarray
        Modal loads a.
    sums : PoleSums
    squares : (F,) ndarray
        s, squared angular frequencies, rad2/s2.
    """

    modal: ModalForm
    weights: Complex
    sums: PoleSums
    squares: Real

    @classmethod
    def of(cls, modal: ModalForm, force: Real, frequency: ArrayLike) -> Self:
        """Prepare the sums for given loads.

        Parameters
        ----------
        force : (r, N) ndarray
        frequency : (F,) array_like, Hz

        Raises
        ------
        ValueError
            With dashpots, whose forces are no sum over poles.
        """
        if modal.count:
            raise ValueError(f"{modal.count} columns of dashpots: their forces are no sum over poles")
        squares = (2.0 * np.pi * np.asarray(frequency, float)) ** 2
        return cls(modal, modal.inverse @ force, PoleSums.of(modal.poles, frequency), squares)

    def along(self, direction: Real) -> Complex:
        """Return x_nᴴ d (F, N) for a real `direction` d (r,)."""
        shares = (direction @ self.modal.shapes)[:, None] * self.weights
        return np.asarray(self.sums.simple(shares.T).conj().T)

    def energy(self, root: Real) -> Complex:
        """Return x_nᴴ G x_m (F, N, N) of G = Rᵀ R for a real `root` R (p, r)."""
        image = root @ self.modal.shapes
        gram = image.conj().T @ image
        poles = self.modal.poles
        apart = poles[None] - poles.conj()[:, None]
        still = poles.imag < LEAST_IMAGINARY_PART * np.maximum(np.abs(poles), self.squares.max())
        both = still[:, None] & still[None]
        coupled = np.where(both, 0.0, gram / np.where(both, 1.0, apart)) @ self.weights
        shares = self.weights.T[:, None] * coupled.conj().T[None]
        half = self.sums.simple(shares).conj().transpose(2, 0, 1)
        found = half + half.conj().swapaxes(1, 2)
        if still.any():
            alone = self.weights[still] / (poles[still] - self.squares[:, None])[:, :, None]
            found = found + alone.conj().swapaxes(1, 2) @ gram[np.ix_(still, still)] @ alone
        return np.asarray(found)


NARROW_WIDTH = 2.0
"""Resonances with a half-power width below this many steps of the even grid get lines of their own."""


def resonance_lines(natural: Real, loss_factor: float, grid: Real) -> Real:
    """Lines over a band: those of an even grid, and more around narrow resonances.

    Parameters
    ----------
    natural : (r,) ndarray
        Natural frequencies, Hz; those outside the band are left out.
    loss_factor : float
        Of every mode: the half-power width is loss_factor times the natural frequency.
    grid : (G,) ndarray
        Even lines from one end of the band to the other, Hz.

    Returns
    -------
    (F,) ndarray, Hz
        Ascending.
    """
    step = grid[1] - grid[0]
    inside = natural[(natural > grid[0]) & (natural < grid[-1])]
    narrow = inside[loss_factor * inside < NARROW_WIDTH * step]
    if not narrow.size:
        return grid
    lines = [grid]
    for center in narrow:
        width = loss_factor * center
        doublings = max(int(np.ceil(np.log2(step / width))), 0) + 2
        offsets = 0.5 * width * 2.0 ** np.arange(doublings)
        lines.append(center + np.concatenate([-offsets[::-1], [0.0], offsets]))
    joined = np.unique(np.concatenate(lines))
    return np.asarray(joined[(joined >= grid[0]) & (joined <= grid[-1])])


def root_mean_square(values: NDArray[np.complex128], lines: Real) -> Real:
    """Rms of values (..., F) over the band that uneven lines (F,) span, trapezoidal: (...)."""
    power = np.trapezoid(np.abs(values) ** 2, lines, axis=-1) / (lines[-1] - lines[0])
    return np.asarray(np.sqrt(power))
