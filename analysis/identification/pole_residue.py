"""The pole/residue model of an FRF: columns, derivatives and synthesis (paper eq. 10).

With s = jw, a pole lambda and its conjugate contribute R / (s - lambda) + conj(R) / (s - conj(lambda)).
That is linear in Re R and Im R, so each pole owns two columns of a real least-squares problem.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.residual_terms import ResidualTerms

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
