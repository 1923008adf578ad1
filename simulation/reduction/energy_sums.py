"""Energies of a reduced plate's responses as sums over its poles, without computing the responses."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real
from simulation.reduction.modal_form import ModalForm
from simulation.reduction.pole_sums import PoleSums

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
