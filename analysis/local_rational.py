"""Noise power of an FRF without repeats, also where resonances are a few lines wide."""

import numpy as np
from numpy.typing import NDArray

from analysis.noise_power import single_repeat_power

WINDOW_LINES = 11
"""Lines of a window."""

X = np.linspace(-1.0, 1.0, WINDOW_LINES)

MOST_FITS = 4
"""Fits with weights by the denominator of the one before."""

CLEAR_RESIDUAL_SHARE = 0.3
"""Share of the quartic's residual below which the rational function replaces it; of noise, less remains seldom."""


def rough_power(h: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Noise power per line of an FRF without repeats, from what a resonance on a smooth background leaves.

    A peak narrower than the window is no quartic, and what a quartic leaves of it is up to a million times the
    noise. A cubic divided by 1 + b x, with as many coefficients, contains one pole (local rational method:
    McKelvey and Guerin, IFAC SYSID, 2012), and its residual is taken where it is clearly smaller.

    Parameters
    ----------
    h : (F,) complex ndarray

    Returns
    -------
    (F,) ndarray
    """
    power = single_repeat_power(h)
    if len(h) < WINDOW_LINES:
        return power
    half = WINDOW_LINES // 2
    starts = np.clip(np.arange(len(h)) - half, 0, len(h) - WINDOW_LINES)
    windows = h[starts[:, None] + np.arange(WINDOW_LINES)]
    own = np.arange(len(h)) - starts
    quartic = _energy(_without(5, windows))
    # a cheap fit without weights first: most windows hold no peak
    peaked = np.flatnonzero(_unweighted(windows) < 0.5 * quartic)
    if not len(peaked):
        return power
    left, leverage = _rational(windows[peaked])
    clear = _energy(left) < CLEAR_RESIDUAL_SHARE * quartic[peaked]
    place, line = np.flatnonzero(clear), peaked[clear]
    kept = np.maximum(1.0 - leverage[place, own[line]], 0.05)
    power[line] = np.minimum(power[line], np.abs(left[place, own[line]]) ** 2 / kept)
    return power


def _without(powers: int, windows: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Residual of polynomials with so many coefficients in every window, (W, N)."""
    basis = np.linalg.qr(np.vander(X, powers))[0]
    return np.asarray(windows - (windows @ basis) @ basis.T)


def _energy(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Sum of squares in every window, (W,)."""
    return np.asarray((values.real**2 + values.imag**2).sum(1))


def _unweighted(windows: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Energy (W,) that h (1 + b x) = cubic leaves without weights."""
    left, column = _without(4, windows), _without(4, windows * X)
    share = (column.conj() * left).sum(1) / np.maximum(_energy(column), np.finfo(float).tiny)
    return _energy(left - share[:, None] * column)


def _rational(windows: NDArray[np.complex128]) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Residual and leverage (W, N) of h (1 + b x) = cubic, weighted by 1 / |1 + b x| of the fit before."""
    cubic = np.broadcast_to(np.vander(X, 4), (len(windows), WINDOW_LINES, 4))
    denominator = np.ones(windows.shape, dtype=complex)
    for _ in range(MOST_FITS):
        columns = np.concatenate([cubic, (X * windows)[:, :, None]], axis=2) / denominator[:, :, None]
        basis, triangle = np.linalg.qr(columns)
        weighted = windows / denominator
        share = np.einsum("wnp,wn->wp", basis.conj(), weighted)
        change = 1.0 - (share[:, -1] / triangle[:, -1, -1])[:, None] * X
        left = (weighted - np.einsum("wnp,wp->wn", basis, share)) * denominator / change
        denominator = change
    return left, np.asarray((np.abs(basis) ** 2).sum(2))
