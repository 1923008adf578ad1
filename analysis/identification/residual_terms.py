"""What the modes outside the band leave inside it: a few powers of s, real or complex."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ResidualTerms:
    """Powers of s beside the poles.

    Attributes
    ----------
    name : str
        As reports show it.
    powers : tuple of int
        0 is the flexibility E of the modes above, -2 the inertia F of the rigid-body modes below
        (paper eq. 10), 1 a correction G s that bends with frequency.
    complex_valued : bool
        Whether the coefficients may be complex, as hysteretic damping makes them.
    """

    name: str
    powers: tuple[int, ...]
    complex_valued: bool

    @property
    def parameters(self) -> int:
        """Real parameters per FRF."""
        return len(self.powers) * (2 if self.complex_valued else 1)

    def columns(self, s: NDArray[np.complex128], scale: float) -> NDArray[np.complex128]:
        """Columns of the least-squares problem, (parameters, F), with s in units of `scale` rad/s."""
        powers: NDArray[np.complex128] = np.empty((len(self.powers), len(s)), dtype=complex)
        for row, power in enumerate(self.powers):
            powers[row] = (s / scale) ** power
        return np.concatenate([powers, 1j * powers]) if self.complex_valued else powers

    def coefficients(self, solved: NDArray[np.float64], scale: float) -> NDArray[np.complex128]:
        """Complex coefficients (K, P) in SI from the real solution (K, parameters) of `columns`."""
        count = len(self.powers)
        unit = scale ** np.array(self.powers, dtype=float)
        value: NDArray[np.complex128] = solved[:, :count].astype(complex)
        if self.complex_valued:
            value.imag = solved[:, count:]
        value /= unit
        return value


NONE = ResidualTerms("none", (), False)
REAL_E = ResidualTerms("E", (0,), False)
REAL_E_F = ResidualTerms("E + F/s^2", (0, -2), False)
COMPLEX_E_F = ResidualTerms("complex E + F/s^2", (0, -2), True)
COMPLEX_E_F_G = ResidualTerms("complex E + F/s^2 + G s", (0, -2, 1), True)

CHOICES = (NONE, REAL_E, REAL_E_F, COMPLEX_E_F, COMPLEX_E_F_G)
"""From the poorest to the richest: the order choice by BIC starts from the last."""

ACCELERANCE = ResidualTerms("complex E + F/s^2 + G s + s^2", (0, -2, 1, 2), True)
"""For accelerance: s^2 times a pole's term leaves powers 0 and 1, and the modes above the band a power 2."""


def named(name: str) -> ResidualTerms:
    """Residual terms of that name; ValueError naming the choices otherwise."""
    known = (*CHOICES, ACCELERANCE)
    for terms in known:
        if terms.name == name:
            return terms
    raise ValueError(f"residual terms {name!r} are not known; choose from {[t.name for t in known]}")
