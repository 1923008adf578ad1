"""Relative error of reconstructed filters, paper eq. (13)."""

import numpy as np
from numpy.typing import NDArray


def relative_error(reconstructed: NDArray[np.float64], true: NDArray[np.float64]) -> NDArray[np.float64]:
    """100 ∫(r - r_true)² / ∫ r_true² over the last axis, in %.

    A ratio of energies: 0.01 % is an error of a hundredth of the filter's amplitude, not of a ten-thousandth. Both
    arrays have shape (..., M); returns (...).
    """
    if reconstructed.shape != true.shape:
        raise ValueError(f"reconstructed {reconstructed.shape} and true {true.shape} filters differ in shape")
    energy = np.sum(true**2, axis=-1)
    if not np.all(energy > 0.0):
        raise ValueError("a true filter is silent: its relative error is undefined")
    ratio: NDArray[np.float64] = 100.0 * np.sum((reconstructed - true) ** 2, axis=-1) / energy
    return ratio
