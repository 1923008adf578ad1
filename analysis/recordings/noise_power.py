"""Power of the noise of an FRF at each line, from residuals at the same lines.

Noise of the response has a smooth spectrum. Noise of the drive reaches the FRF multiplied by H, so that its power
follows |H|^2 and is largest at resonances. The power is therefore s (1 + beta |H|^2), with s smooth over frequency
and one beta for the FRF, found by maximum likelihood.

Without repeats it is taken from roughness along frequency, also where resonances are a few lines wide.
"""

import numpy as np
from numpy.typing import NDArray

SMOOTHING_LINES = 41
"""Number of neighbouring lines over which the noise power is averaged."""

SHARES = np.concatenate([[0.0], np.geomspace(1e-3, 1e3, 25)])
"""Power of the drive's noise over that of the response's, at the geometric mean of |H|^2: the values tried."""


def noise_power(
    power: NDArray[np.float64], h: NDArray[np.complex128], excluded: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Estimate the noise power at each line of one FRF.

    Parameters
    ----------
    power : (F,) ndarray
        Power of the residual, one independent estimate per line.
    h : (F,) complex ndarray
        The FRF, or any multiple of it.
    excluded : (F,) bool ndarray
        Lines that say nothing of the noise.

    Returns
    -------
    (F,) ndarray
        s (1 + beta |h|^2): s averages power / (1 + beta |h|^2) over `SMOOTHING_LINES` lines, and beta maximizes
        the likelihood of powers that scatter as chi-squared about it (Bendat and Piersol, Random Data, 2010).
    """
    smooth, shape = noise_parts(power, h, excluded)
    return smooth * shape


def noise_parts(
    power: NDArray[np.float64], h: NDArray[np.complex128], excluded: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Split the noise of `noise_power` into that of the response and that of the drive.

    Parameters
    ----------
    power : (F,) ndarray
    h : (F,) complex ndarray
    excluded : (F,) bool ndarray
        As for `noise_power`.

    Returns
    -------
    smooth, shape : (F,) ndarray
        s, the noise of the response alone, and 1 + beta |h|^2, by which the drive's increases it.
    """
    gain = np.abs(h) ** 2
    seen = ~excluded & np.isfinite(power) & np.isfinite(gain)
    known = seen & (power > 0.0) & (gain > 0.0)
    if not known.any():
        return _smooth(power, seen), np.ones(len(power))
    shapes = 1.0 + SHARES[:, None] * (gain / np.exp(np.log(gain[known]).mean()))
    smooth = _smooth(power / shapes, seen)
    powers = shapes * smooth
    unlikely = (np.log(powers[:, known]) + power[known] / powers[:, known]).sum(1)
    likeliest = int(np.argmin(unlikely))
    return np.asarray(smooth[likeliest]), np.asarray(shapes[likeliest])


def _smooth(power: NDArray[np.float64], seen: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Average (..., F) over `SMOOTHING_LINES` lines, of those that are `seen` alone."""
    total, share = _moving_sum(np.where(seen, power, 0.0)), _moving_sum(seen.astype(float))
    return np.asarray(total / np.maximum(share, 1.0))


def _moving_sum(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum (..., F) over `SMOOTHING_LINES` lines of the last axis, its ends continued by the first and last value.

    It adds sums of 1, 2, 4, ... lines: differences of a cumulative sum lose all digits if the power falls by 1e16.
    """
    before = [(0, 0)] * (values.ndim - 1)
    sums = np.pad(values, [*before, (SMOOTHING_LINES // 2, SMOOTHING_LINES // 2)], mode="edge")
    total, start, size = np.zeros_like(values, dtype=float), 0, 1
    while size <= SMOOTHING_LINES:
        if SMOOTHING_LINES & size:
            total += sums[..., start : start + values.shape[-1]]
            start += size
        sums = sums[..., :-size] + sums[..., size:]
        size *= 2
    return total


def single_repeat_power(h: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Noise power per line of an FRF without repeats, from its roughness over frequency.

    What a local quartic over eleven lines (all of them, where there are fewer; seven at least) leaves is noise
    where modes are many lines wide (local polynomial method: Pintelon and Schoukens, System Identification, 2012,
    ch. 7). The lines at both ends share what their window leaves together: a quartic follows the last line itself
    to nine tenths, and the noise there came out at half of its power.
    """
    width = min(11, (len(h) - 1) // 2 * 2 + 1)
    half = width // 2
    # to smooth is to project each window; scipy.signal does the same, and takes a second to import
    basis = np.linalg.qr(np.vander(np.linspace(-1.0, 1.0, width), 5))[0]
    hat = basis @ basis.T
    smooth = np.concatenate([hat[:half] @ h[:width], np.convolve(h, hat[half], "valid"), hat[-half:] @ h[-width:]])
    left = np.abs(h - smooth) ** 2
    power: NDArray[np.float64] = left / (1.0 - hat[half, half])
    for ends, window in ((slice(None, half), h[:width]), (slice(-half, None), h[-width:])):
        power[ends] = (np.abs(window - hat @ window) ** 2).sum() / (width - basis.shape[1])
    return power


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
