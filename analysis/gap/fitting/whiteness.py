"""Whiteness of a residual: neighbours in frequency and in temperature are uncorrelated if it is noise."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.gap.data.sweeps import GapSweeps

LAGS = 3
"""Largest lag in nodes: about a resonance's half width."""


def whiteness(sweeps: GapSweeps, residual: NDArray[np.complex128]) -> tuple[float, float]:
    """Correlation of `residual` (T, K, n) over frequency and over temperature, in standard deviations of noise.

    With real and imaginary parts of unit variance, products have variance 2; sums over many are normal.
    """
    rows = sweeps.rows
    over_frequency = [
        _correlation(residual[..., lag:], residual[..., :-lag], rows[..., lag:] & rows[..., :-lag])
        for lag in range(1, LAGS + 1)
    ]
    pairs = neighbours(sweeps)
    if not pairs:
        return float(np.sum(over_frequency) / np.sqrt(LAGS)), 0.0
    left, right = np.array(pairs).T
    over_temperature = _correlation(residual[left], residual[right], rows[left] & rows[right])
    return float(np.sum(over_frequency) / np.sqrt(LAGS)), over_temperature


def neighbours(sweeps: GapSweeps) -> list[tuple[int, int]]:
    """Sweeps next to each other in temperature, at one level of one input and on one ramp."""
    return [pair for leg in sweeps.legs for pair in pairwise(leg)]


def _correlation(a: NDArray[np.complex128], b: NDArray[np.complex128], rows: NDArray[np.bool_]) -> float:
    count = max(int(rows.sum()), 1)
    return float((a * b.conj()).real.sum() / np.sqrt(2.0 * count))
