"""The pole/residue model of an FRF with terms for modes outside the band, and its poles as parameters.

With s = jw, a pole lambda and its conjugate contribute R / (s - lambda) + conj(R) / (s - conj(lambda)).
That is linear in Re R and Im R, so each pole owns two columns of a real least-squares problem.
"""

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
BLOCK_IN_CACHE = 8192
"""Size of a block that stays in the processor's cache between operations, in complex numbers."""


def pole_columns(s: NDArray[np.complex128], poles: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Columns multiplied by Re R and Im R, pole by pole.

    Parameters
    ----------
    s : (F,) complex ndarray
        jw, rad/s.
    poles : (J,) complex ndarray
        Upper half plane, rad/s.

    Returns
    -------
    (2J, F) complex ndarray
        s/rad.
    """
    columns = np.empty((2 * len(poles), len(s)), dtype=complex)
    fill_columns(s, poles, columns)
    return columns


def fill_columns(
    s: NDArray[np.complex128],
    poles: NDArray[np.complex128],
    columns: NDArray[np.complex128],
    moved: NDArray[np.complex128] | None = None,
) -> None:
    """Fill in `pole_columns` and, in the same arrangement, the columns of 1/(s - lambda)^2.

    Moving a pole by d changes its share of the FRF by R d/(s - lambda)^2 + conj(R d)/(s - conj(lambda))^2, which
    lies in the real span of the latter whatever R and d are. A few poles are computed at a time, without a complex
    division.

    Parameters
    ----------
    s : (F,) complex ndarray
        jw, rad/s.
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    columns : (2J, F) complex ndarray
        Filled.
    moved : (2J, F) complex ndarray, optional
        Filled as well.
    """
    few = max(BLOCK_IN_CACHE // (2 * len(s)), 1)
    for start in range(0, len(poles), few):
        rows = slice(2 * start, 2 * (start + few))
        _fill(s.imag, poles[start : start + few], columns[rows], None if moved is None else moved[rows])


def _fill(
    w: NDArray[np.float64],
    poles: NDArray[np.complex128],
    columns: NDArray[np.complex128],
    moved: NDArray[np.complex128] | None,
) -> None:
    """Fill columns and derivative columns of a few poles in place."""
    both = np.concatenate([poles, poles.conj()])
    away = both.imag[:, None] - w
    inverse = away * away
    inverse += (both.real**2)[:, None]
    np.divide(1.0, inverse, out=inverse)
    once = np.empty(away.shape, dtype=complex)  # 1/(s - lambda), then 1/(s - conj(lambda))
    np.multiply(away, inverse, out=once.imag)
    np.multiply(-both.real[:, None], inverse, out=once.real)
    paired(once, columns)
    if moved is not None:
        paired(np.square(once), moved)


def paired(both: NDArray[np.complex128], columns: NDArray[np.complex128]) -> None:
    """Fill `columns` (2J, F) with upper + lower and j (upper - lower), alternating, from `both`."""
    upper, lower = both[: len(both) // 2], both[len(both) // 2 :]
    np.add(upper, lower, out=columns[0::2])
    np.subtract(lower.imag, upper.imag, out=columns[1::2].real)
    np.subtract(upper.real, lower.real, out=columns[1::2].imag)


def residues_from_columns(coefficients: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Complex residues (..., J) from the coefficients (..., 2J) of `pole_columns`."""
    residues: NDArray[np.complex128] = coefficients[..., 0::2] + 1j * coefficients[..., 1::2]
    return residues


def synthesis(
    frequency: NDArray[np.float64],
    poles: NDArray[np.complex128],
    residues: NDArray[np.complex128],
    terms: ResidualTerms,
    coefficients: NDArray[np.complex128],
) -> NDArray[np.complex128]:
    """Rebuild FRFs from poles, residues and residual terms.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz, above zero.
    poles : (J,) complex ndarray
        rad/s.
    residues : (K, J) complex ndarray
        FRF unit times rad/s.
    terms : ResidualTerms
        Powers of s that represent the modes out of band.
    coefficients : (K, P) complex ndarray
        Of those powers, FRF unit times (rad/s)^-power.

    Returns
    -------
    (K, F) complex ndarray
    """
    s = 2j * np.pi * np.asarray(frequency, dtype=float)
    h: NDArray[np.complex128] = residues @ (1.0 / (s - poles[:, None]))
    h = h + residues.conj() @ (1.0 / (s - poles.conj()[:, None]))
    if terms.powers:
        h = h + coefficients @ np.array([s**power for power in terms.powers])
    return h


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


LARGEST_DAMPING = 0.6
"""Damping ratio beyond which a pole is a background slope, not a mode."""
BAND_MARGIN = 0.12
"""Poles outside the band are fitted as well up to this distance, as a share of the frequency of its edge."""
WIDER_BAND_MARGIN = 0.25
"""The same for a second pass over sweeps that the first leaves poor: with little noise, modes farther away matter.
Tracks are less certain with it: in narrow bands more than one pole may stand for what is outside."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of poles: undamped frequency in rad/s, damping ratio.

    A pole narrower than a tenth of a line's spacing describes one line, not a resonance; one far outside
    the band is a residual term.
    """

    frequency: tuple[float, float]
    half_width: float
    damping: float = LARGEST_DAMPING

    @classmethod
    def of(cls, frequency: NDArray[np.float64], spacing: float) -> "Bounds":
        """Bounds for a band of lines (F,) and their spacing, Hz."""
        return cls((np.pi * frequency[0], 3.0 * np.pi * frequency[-1]), 0.2 * np.pi * spacing)

    def clip(self, parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        """Parameters (J, 2) clipped to the bounds."""
        log_w = np.clip(parameters[:, 0], *np.log(self.frequency))
        narrowest = np.log(self.half_width) - log_w
        log_zeta = np.minimum(np.maximum(parameters[:, 1], narrowest), np.log(self.damping))
        return np.column_stack([log_w, log_zeta])

    def stuck(self, poles: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Which poles lie on a bound: (J,) ndarray."""
        w, zeta = np.abs(poles), -poles.real / np.abs(poles)
        low, high = self.frequency
        at: NDArray[np.bool_] = (w < low * 1.001) | (w > high * 0.999) | (zeta > 0.999 * self.damping)
        return at | (zeta * w < 1.001 * self.half_width)


def to_parameters(poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Log of |pole| and of the damping ratio, (J, 2): steps in them stay inside the stable half plane."""
    w = np.abs(poles)
    return np.column_stack([np.log(w), np.log(np.maximum(-poles.real / w, 1e-12))])


def to_poles(parameters: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Inverse of `to_parameters`."""
    w, zeta = np.exp(parameters[:, 0]), np.exp(parameters[:, 1])
    poles: NDArray[np.complex128] = w * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    return poles


def active_in(
    place: NDArray[np.float64], frequency: NDArray[np.float64], beyond: float = BAND_MARGIN
) -> NDArray[np.bool_]:
    """Which poles lie in a band, or near it.

    Parameters
    ----------
    place : (J, 2) ndarray
        Log |lambda| and log damping ratio.
    frequency : (F,) ndarray, Hz
        Lines of the band, lowest first.
    beyond : float
        Largest distance, as a share of the edge's frequency.

    Returns
    -------
    (J,) ndarray of bool
    """
    f, (low, high) = np.exp(place[:, 0]) / (2.0 * np.pi), frequency[[0, -1]]
    return np.asarray((f > low * (1.0 - beyond)) & (f < high * (1.0 + beyond)))
