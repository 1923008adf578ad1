"""What a fit leaves over: how large the error of every line is, and how many lines are independent."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from analysis.identification.running_median import running_median

CALM = 1.5
"""Mean power of noise over its median's estimate, at most, where a window holds nothing but noise."""

LARGEST_SHARE = 1.0
"""Error of a line, relative to the response of the model, beyond what its calm neighbours show."""

LONGEST = 2.0
"""Half widths over which errors count as correlated, at most."""

LEAST_REACH = 8.0
"""The same in lines, at least."""

ALIKE = 0.1
"""Root mean square of the relative difference up to which deviations of two responses have one course along
frequency: about what two estimates from the same noise differ by. Weights off by so much cost 2 % of accuracy."""


def deviation_from_residual(
    left: NDArray[np.complex128],
    h: NDArray[np.complex128],
    *,
    smallest_width: int = 41,
) -> NDArray[np.float64]:
    """Smooth root mean square of residuals along frequency.

    The window holds a sixteenth of the lines, so that the weights carry a few per cent of noise themselves and
    cost under one per cent of variance; noise that changes faster than that is averaged. What a resonance leaves
    over (leakage, a response that is not quite linear) must not make the lines beside it look noisy, or its pole
    is no longer worth its price: beyond a running median, which it does not move, the mean counts only up to a
    share of the model.

    Parameters
    ----------
    left, h : (K, F) complex ndarray
        Measured minus model, and what was measured, whose rounding is the least deviation.
    smallest_width : int
        Lines in the window at least.

    Returns
    -------
    (K, F) ndarray
        Above zero, in the unit of `h`.
    """
    power = np.abs(left) ** 2
    count = left.shape[1]
    width = min(max(smallest_width, count // 16), count)
    rounding = (1e-14**2) * (np.abs(h) ** 2).mean(axis=1, keepdims=True)
    least = np.maximum(1e-4 * np.median(power, axis=1, keepdims=True), rounding)
    floor = running_median(power, width, "reflect") / np.log(2.0)
    smooth = uniform_filter1d(power, width, axis=1, mode="reflect")
    limited = np.minimum(smooth, CALM * floor + LARGEST_SHARE**2 * np.abs(h - left) ** 2)
    deviation: NDArray[np.float64] = np.sqrt(np.maximum(limited, np.maximum(least, np.finfo(float).tiny)))
    return deviation


def pooled(deviation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give responses whose noise takes the same course along frequency the mean of their courses.

    Sensors of one kind on one acquisition device have noise of one course, each at its own level. Together they
    tell it better than each alone, and responses with weights in proportion share one factorisation in a fit.

    Parameters
    ----------
    deviation : (K, F) ndarray
        Above zero.

    Returns
    -------
    (K, F) ndarray
        Each response keeps its level, the geometric mean.
    """
    course = np.log(deviation)
    level = course.mean(axis=1, keepdims=True)
    course -= level
    left = list(range(len(course)))
    while left:
        first, *others = left
        apart = np.sqrt(np.square(course[others] - course[first]).mean(axis=1))
        alike = [first, *(row for row, distance in zip(others, apart, strict=True) if distance <= ALIKE)]
        course[alike] = course[alike].mean(axis=0)
        left = [row for row in left if row not in alike]
    same: NDArray[np.float64] = np.exp(course + level)
    return same


def correlation(normalised: NDArray[np.complex128], reach: float) -> float:
    """How many neighbouring lines carry the information of one: tau = 1 + 2 sum rho_k, at least 1.

    Parameters
    ----------
    normalised : (K, F) complex ndarray
        Residual over the lines' standard deviation. Its autocorrelation rho_k along frequency is summed up to
        the first value that is not positive; windows, interpolation, slow drifts and whatever a model lacks
        correlate neighbouring lines.
    reach : float
        Lines, the half width of a resonance here: errors that go together over more than `LONGEST` of it bend the
        background and do not look like a resonance.
    """
    count = normalised.shape[1]
    spectrum = np.fft.fft(normalised, 2 * count, axis=1)
    rho = np.fft.ifft((np.abs(spectrum) ** 2).sum(axis=0))[: count // 2].real
    if not rho[0] > 0.0:
        return 1.0
    rho /= rho[0]
    ends = np.flatnonzero(rho <= 0.0)
    last = min(int(ends[0]) if len(ends) else len(rho), int(max(LONGEST * reach, LEAST_REACH)) + 1)
    return float(1.0 + 2.0 * rho[1:last].sum())
