"""A running median along the lines of an FRF."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter


def running_median(
    values: NDArray[np.float64], window: int, mode: Literal["nearest", "reflect"]
) -> NDArray[np.float64]:
    """Median over a window that runs along the last axis.

    Computed row by row, because SciPy updates the sorted window only for one-dimensional arrays and sorts it anew
    at every line otherwise: 3 s instead of 8 ms for 48,000 lines and a window of 3,000.

    Parameters
    ----------
    values : (K, F) ndarray
    window : int
        Lines.
    mode : str
        Extension beyond the ends, as in `scipy.ndimage.median_filter`.

    Returns
    -------
    (K, F) ndarray
    """
    return np.array([median_filter(row, size=window, mode=mode) for row in values]).reshape(values.shape)
