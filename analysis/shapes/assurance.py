"""How alike shapes are, and how real each is."""

import numpy as np
from numpy.typing import NDArray


def mac(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Modal assurance criterion of all pairs (Allemang and Brown, IMAC 1982), 0 to 1.

    Parameters
    ----------
    one, other : (S, K) and (U, K) ndarray
        Shapes at the same places; NaN where one was not measured, which leaves the place out for that pair.

    Returns
    -------
    (S, U) ndarray
    """
    both = np.isfinite(one)[:, None] & np.isfinite(other)[None]
    a = np.where(both, one[:, None], 0.0)
    b = np.where(both, other[None], 0.0)
    cross = np.abs((a.conj() * b).sum(2)) ** 2
    size = (np.abs(a) ** 2).sum(2) * (np.abs(b) ** 2).sum(2)
    found: NDArray[np.float64] = np.divide(cross, size, out=np.zeros_like(cross), where=size > 0.0)
    return found


def mpc(shapes: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Modal phase collinearity (Pappa et al., J. Guid. Control Dyn. 16, 1993): 1 for a shape in one phase.

    Parameters
    ----------
    shapes : (S, K) complex ndarray

    Returns
    -------
    (S,) ndarray
        0 to 1; of a shape at a single place, 1.
    """
    known = np.where(np.isfinite(shapes), shapes, 0.0)
    real, imaginary = known.real, known.imag
    xx, yy, xy = (real**2).sum(1), (imaginary**2).sum(1), (real * imaginary).sum(1)
    apart = np.sqrt((xx - yy) ** 2 + 4.0 * xy**2)
    total = xx + yy
    found: NDArray[np.float64] = np.divide(apart**2, total**2, out=np.ones_like(apart), where=total > 0.0)
    return found
