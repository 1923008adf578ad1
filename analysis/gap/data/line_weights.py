"""Weights of whitened complex numbers: one along a direction in the complex plane, another across it."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real


@dataclass(frozen=True)
class LineWeights:
    """Factors on the two parts of every whitened number of some sweeps.

    Attributes
    ----------
    direction : (T, K, n) complex ndarray
        Of unit size.
    along, across : (T, K, n) ndarray
        0 to 1; both 1 where only noise is expected.
    """

    direction: NDArray[np.complex128] = field(repr=False)
    along: Real = field(repr=False)
    across: Real = field(repr=False)

    @classmethod
    def equal(cls, shape: tuple[int, ...]) -> "LineWeights":
        """Weights of 1 for sweeps of some `shape`."""
        return cls(np.ones(shape, dtype=complex), np.ones(shape), np.ones(shape))

    def weigh(
        self, white: NDArray[np.complex128], sweep: int, channels: slice = slice(None)
    ) -> NDArray[np.complex128]:
        """Turn and weigh whitened numbers.

        Parameters
        ----------
        white : (..., K, n) complex ndarray
        sweep : int
            Theirs.
        channels : slice
            Of which they are; all unless given.

        Returns
        -------
        (..., K, n) complex ndarray
        """
        turned = white * self.direction[sweep, channels].conj()
        along, across = self.along[sweep, channels], self.across[sweep, channels]
        return np.asarray(along * turned.real + 1j * across * turned.imag)

    def undone(self, weighted: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the whitened numbers (T, K, n) of which `weighted` ones were made."""
        found: NDArray[np.complex128] = (
            weighted.real / self.along + 1j * weighted.imag / self.across
        ) * self.direction
        return found

    def only(self, sweeps: Sequence[int]) -> "LineWeights":
        """Return those of some sweeps."""
        kept = list(sweeps)
        return LineWeights(self.direction[kept], self.along[kept], self.across[kept])
