"""Standard deviation per line of FRFs that came without a variance: from what a good fit leaves over."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d


def deviation_from_residual(
    left: NDArray[np.complex128], h: NDArray[np.complex128], *, smallest_width: int = 41
) -> NDArray[np.float64]:
    """Smooth root mean square of residuals along frequency, (K, F).

    The window holds a sixteenth of the lines, so that the weights carry a few per cent of noise themselves and
    cost under one per cent of variance; noise that changes faster than that is averaged. Floored at a
    hundredth of the band's mean, for a window must not fall silent, and at the rounding of `h` itself, (K, F).
    """
    power = np.abs(left) ** 2
    width = min(max(smallest_width, left.shape[1] // 16), left.shape[1])
    smooth = uniform_filter1d(power, width, axis=1, mode="reflect")
    mean = power.mean(axis=1, keepdims=True)
    rounding = (1e-14**2) * (np.abs(h) ** 2).mean(axis=1, keepdims=True)
    mean = np.maximum(mean, 1e4 * np.maximum(rounding, np.finfo(float).tiny))
    deviation: NDArray[np.float64] = np.sqrt(np.maximum(smooth, 1e-4 * mean))
    return deviation
