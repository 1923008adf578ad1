"""Lines of an FRF that the mains have spoilt."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

OUTLIER = 5.0
"""How far a line must lie from the model, in local standard deviations, before the mains are blamed."""


def harmonic_lines(
    frequency: NDArray[np.float64], left: NDArray[np.complex128], spacing: float, mains: float
) -> NDArray[np.bool_]:
    """Find the lines within one spacing of a mains harmonic that stand out of a fit's residual.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.
    left : (K, F) complex ndarray
        Measured minus model.
    spacing : float
        Of the lines, Hz.
    mains : float
        Hz.

    Returns
    -------
    (F,) bool ndarray
    """
    size = np.abs(left)
    window = min(101, left.shape[1])
    usual = median_filter(size, size=(1, window), mode="nearest") / np.sqrt(np.log(2.0))
    number = np.maximum(np.round(frequency / mains), 1.0)
    near = np.abs(frequency - mains * number) <= 1.001 * spacing
    spoilt: NDArray[np.bool_] = near & (size > OUTLIER * np.maximum(usual, np.finfo(float).tiny)).any(axis=0)
    return spoilt
