"""Power of the noise of an FRF at each line, from residuals at the same lines.

Noise of the response has a smooth spectrum. Noise of the drive reaches the FRF multiplied by H, so that its power
follows |H|^2 and is largest at resonances. The power is therefore s (1 + beta |H|^2), with s smooth over frequency
and one beta for the FRF, found by maximum likelihood.
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
