"""Scatter of numbers that are known with different errors: its mean square under their likelihood."""

import numpy as np

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
