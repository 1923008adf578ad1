"""Scatter of numbers: where their errors differ, and where a few of them are outliers."""

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real


def scatter_of(values: Real, variance: Real, span: tuple[float, float]) -> float:
    """Return the root mean square of the deviation d of numbers that are N(0, d^2 + variance).

    The logarithm of d is taken as evenly likely over `span` beforehand, so that few numbers, which say little,
    give rather too large a deviation than too small a one.

    Parameters
    ----------
    values, variance : (N,) ndarray
    span : (float, float)
        Least and largest deviation.
    """
    tried = np.geomspace(*span, 200)
    total = tried[:, None] ** 2 + variance
    log_likelihood = -0.5 * (values**2 / total + np.log(total)).sum(axis=1)
    weight = np.exp(log_likelihood - log_likelihood.max())
    return float(np.sqrt((weight * tried**2).sum() / weight.sum()))


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
