"""The frequency lines in which modes are looked for."""

import numpy as np
from numpy.typing import NDArray

LEAST_LINES = 8
"""Of fewer, no pole can be told."""


def lines_inside(frequency: NDArray[np.float64], band: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which lines lie in a band, both ends included.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz, ascending.
    band : (float, float)
        Hz.

    Returns
    -------
    (F,) bool ndarray

    Raises
    ------
    ValueError
        Where it holds too few.
    """
    inside: NDArray[np.bool_] = (frequency >= band[0]) & (frequency <= band[1])
    if inside.sum() < LEAST_LINES:
        spacing = float(np.median(np.diff(frequency)))
        raise ValueError(
            f"--band {band[0]:g} {band[1]:g}: {int(inside.sum())} frequency lines; at least {LEAST_LINES} are "
            f"needed. Allowed: within {frequency[0]:g} to {frequency[-1]:g} Hz, at least "
            f"{LEAST_LINES * spacing:.3g} Hz wide"
        )
    return inside
