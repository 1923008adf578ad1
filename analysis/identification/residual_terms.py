"""Contribution of the modes outside the band: a few powers of s with real or complex coefficients."""

from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class ResidualTerms:
    """Powers of s in the model in addition to the poles.

    Attributes
    ----------
    name : str
        Shown in reports.
    powers : tuple of int
        0 is the flexibility E of the modes above, -2 the inertia F of the rigid-body modes below
        (paper eq. 10), 1 a correction G s, linear in frequency.
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
        """Columns of the least-squares problem.

        Parameters
        ----------
        s : (F,) complex ndarray
            jw, rad/s.
        scale : float
            Scale by which s is divided in the columns, rad/s.

        Returns
        -------
        (P, F) complex ndarray
            One row per real parameter.
        """
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
"""By rising number of parameters; the choice by BIC starts from the last."""

MOBILITY_CHOICES = (
    ResidualTerms("E + F/s + G s", (0, -1, 1), False),
    ResidualTerms("complex E + F/s + G s + K s^2", (0, -1, 1, 2), True),
)
"""For mobility: s times a pole's term adds power 0, the modes above the band power 1, those below power -1."""

ACCELERANCE_CHOICES = (
    ResidualTerms("E + G s + K s^2", (0, 1, 2), False),
    ResidualTerms("complex E + F/s^2 + G s + K s^2", (0, -2, 1, 2), True),
)
"""For accelerance: s^2 times a pole's term adds powers 0 and 1, and the modes above the band power 2."""

EVERY_CHOICE = (*CHOICES, *MOBILITY_CHOICES, *ACCELERANCE_CHOICES)


def choices_for(quantities: AbstractSet[str]) -> tuple[ResidualTerms, ...]:
    """Choices of residual terms for the quantities of the responses; all choices if they differ or are unknown.

    Each of `quantities` is ``displacement``, ``velocity``, ``acceleration`` or anything else for unknown.
    """
    suited = {
        "displacement": CHOICES,
        "velocity": (*CHOICES, *MOBILITY_CHOICES),
        "acceleration": (*CHOICES, *ACCELERANCE_CHOICES),
    }
    return suited.get(next(iter(quantities)), EVERY_CHOICE) if len(quantities) == 1 else EVERY_CHOICE


def named(name: str) -> ResidualTerms:
    """Residual terms of that name; ValueError naming the choices otherwise."""
    for terms in EVERY_CHOICE:
        if terms.name == name:
            return terms
    raise ValueError(f"residual terms {name!r} are not known; choose from {[t.name for t in EVERY_CHOICE]}")
