"""Common temperature range of laws and a panel, and steps over it."""

import numpy as np

from analysis.arrays import Real
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws


def covered(laws: MaterialLaws, wanted: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the `wanted` range that the laws cover, °C; ValueError if there is none."""
    low, high = max(laws.temperature_range[0], wanted[0]), min(laws.temperature_range[1], wanted[1])
    if low >= high:
        raise ValueError(
            f"the laws hold from {laws.temperature_range[0]:g} to {laws.temperature_range[1]:g} °C, the panel is "
            f"wanted from {wanted[0]:g} to {wanted[1]:g} °C: nothing in common"
        )
    return low, high


def reference_temperature(panel: Panel, laws: MaterialLaws) -> float:
    """Return the panel's reference temperature, moved to the end of the laws' range where it lies outside, °C."""
    low, high = covered(laws, panel.filters.operating_range)
    return min(max(panel.filters.reference_temperature, low), high)


def spaced(low: float, high: float, spacing: float) -> Real:
    """Temperatures in even steps, and the upper end itself.

    Parameters
    ----------
    low, high : float
        Ends, °C.
    spacing : float
        K.

    Returns
    -------
    (T,) ndarray, °C
        Ascending.

    Raises
    ------
    ValueError
        For a spacing that is not above 0.
    """
    if not spacing > 0.0:
        raise ValueError(f"{spacing:g} K between temperatures: above 0 wanted")
    steps = np.arange(low, high + 1e-9, spacing)
    return steps if high - steps[-1] < 1e-6 * spacing else np.append(steps, high)
