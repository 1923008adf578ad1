"""The pole/residue model of an FRF: columns, derivatives and synthesis (paper eq. 10).

With s = jw, a pole lambda and its conjugate contribute R / (s - lambda) + conj(R) / (s - conj(lambda)).
That is linear in Re R and Im R, so each pole owns two columns of a real least-squares problem.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.residual_terms import ResidualTerms

Spread = NDArray[np.float64] | None


def pole_columns(
    s: NDArray[np.complex128], poles: NDArray[np.complex128], spread: Spread = None
) -> NDArray[np.complex128]:
    """Columns that Re R and Im R multiply, pole by pole.

    Parameters
    ----------
    s : (F,) complex ndarray
        jw, rad/s.
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    spread : (F,) ndarray, optional
        Where `s` is the middle of several averaged lines, their mean squared distance from it, (rad/s)^2:
        the mean of 1/(s - lambda) over them is taken to fourth order in their reach over s - lambda.

    Returns
    -------
    (2J, F) complex ndarray
        s/rad.
    """
    columns = np.empty((2 * len(poles), len(s)), dtype=complex)
    upper, lower = 1.0 / (s - poles[:, None]), 1.0 / (s - poles.conj()[:, None])
    if spread is not None:
        upper *= 1.0 - spread * upper * upper
        lower *= 1.0 - spread * lower * lower
    _pair(upper, lower, columns)
    return columns


def columns_with_derivatives(
    s: NDArray[np.complex128], poles: NDArray[np.complex128], spread: Spread = None
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return `pole_columns` and, in the same arrangement, the columns of 1/(s - lambda)^2.

    Moving a pole by d changes its share of the FRF by R d/(s - lambda)^2 + conj(R d)/(s - conj(lambda))^2, which
    lies in the real span of the latter whatever R and d are.

    Parameters
    ----------
    s : (F,) complex ndarray
        jw, rad/s.
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    spread : (F,) ndarray, optional
        As in `pole_columns`, (rad/s)^2.

    Returns
    -------
    columns, moved : (2J, F) complex ndarray
    """
    upper, lower = 1.0 / (s - poles[:, None]), 1.0 / (s - poles.conj()[:, None])
    columns = np.empty((2 * len(poles), len(s)), dtype=complex)
    moved = np.empty_like(columns)
    upper_squared, lower_squared = upper * upper, lower * lower
    if spread is not None:
        bend, lower_bend = spread * upper_squared, spread * lower_squared
        upper -= bend * upper
        lower -= lower_bend * lower
        upper_squared -= 3.0 * bend * upper_squared
        lower_squared -= 3.0 * lower_bend * lower_squared
    _pair(upper, lower, columns)
    _pair(upper_squared, lower_squared, moved)
    return columns, moved


def _pair(upper: NDArray[np.complex128], lower: NDArray[np.complex128], columns: NDArray[np.complex128]) -> None:
    """Fill `columns` with upper + lower and j (upper - lower), in turns."""
    np.add(upper, lower, out=columns[0::2])
    np.subtract(upper, lower, out=columns[1::2])
    columns[1::2] *= 1j


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
        Which powers of s stand for the modes out of band.
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
