"""The pole/residue model of an FRF: columns, derivatives and synthesis (paper eq. 10).

With s = jw, a pole lambda and its conjugate contribute R / (s - lambda) + conj(R) / (s - conj(lambda)).
That is linear in Re R and Im R, so each pole owns two columns of a real least-squares problem.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.residual_terms import ResidualTerms

Spread = NDArray[np.float64] | None

CACHED = 8192
"""Numbers in an array that passes through many operations and stays in the processor's cache between them."""


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


def real_columns_with_derivatives(
    s: NDArray[np.complex128],
    poles: NDArray[np.complex128],
    spread: Spread,
    columns: NDArray[np.float64],
    moved: NDArray[np.float64],
) -> None:
    """Fill in `pole_columns` and, in the same arrangement, the columns of 1/(s - lambda)^2, as real numbers.

    Moving a pole by d changes its share of the FRF by R d/(s - lambda)^2 + conj(R d)/(s - conj(lambda))^2, which
    lies in the real span of the latter whatever R and d are. This is the innermost loop of every search: it is
    written in real arithmetic, without a complex division, a few poles at a time.

    Parameters
    ----------
    s : (F,) complex ndarray
        jw, rad/s.
    poles : (J,) complex ndarray
        Upper half plane, rad/s.
    spread : (F,) ndarray or None
        As in `pole_columns`, (rad/s)^2.
    columns, moved : (2J, 2F) ndarray
        Filled: real parts on all lines, then imaginary parts.
    """
    few = max(CACHED // (2 * len(s)), 1)
    for start in range(0, len(poles), few):
        rows = slice(2 * start, 2 * (start + few))
        _fill(s.imag, poles[start : start + few], spread, columns[rows], moved[rows])


def _fill(
    w: NDArray[np.float64],
    poles: NDArray[np.complex128],
    spread: Spread,
    columns: NDArray[np.float64],
    moved: NDArray[np.float64],
) -> None:
    """Columns and derivative columns of a few poles, written where they belong."""
    count, points = len(poles), len(w)
    real = np.concatenate([poles.real, poles.real])[:, None]
    im = np.concatenate([poles.imag, -poles.imag])[:, None] - w
    re = im * im
    re += real * real
    np.divide(1.0, re, out=re)
    im *= re  # 1/(s - lambda) = re + j im, then 1/(s - conj(lambda))
    re *= -real
    re2, im2 = re * re, re * im
    re2 -= im * im
    im2 *= 2.0
    if spread is not None:
        bend, bend_im = 1.0 - spread * re2, -spread * im2
        re, im = re * bend - im * bend_im, re * bend_im + im * bend
        bend, bend_im = 3.0 * bend - 2.0, 3.0 * bend_im
        re2, im2 = re2 * bend - im2 * bend_im, re2 * bend_im + im2 * bend
    for target, a, b in ((columns, re, im), (moved, re2, im2)):
        np.add(a[:count], a[count:], out=target[0::2, :points])
        np.add(b[:count], b[count:], out=target[0::2, points:])
        np.subtract(b[count:], b[:count], out=target[1::2, :points])
        np.subtract(a[:count], a[count:], out=target[1::2, points:])


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
