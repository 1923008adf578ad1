"""A standard deviation that a few outliers do not move."""

import numpy as np
from numpy.typing import NDArray

NORMAL = 1.4826
"""Standard deviation of normal numbers over their median departure from the median."""


def median_deviation(values: NDArray[np.floating], axis: int | tuple[int, ...] = 0) -> NDArray[np.float64]:
    """Median departure from the median, as the standard deviation of normal numbers.

    SciPy has the same in `scipy.stats`, which takes longer to load than a verb's whole start.

    Parameters
    ----------
    values : (...) ndarray
    axis : int or tuple of int
        Along which; kept with length 1.
    """
    away = np.abs(values - np.median(values, axis=axis, keepdims=True))
    return NORMAL * np.asarray(np.median(away, axis=axis, keepdims=True), dtype=np.float64)
