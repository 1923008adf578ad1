"""Poles as parameters of a search, with bounds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LARGEST_DAMPING = 0.6
"""Damping ratio beyond which a pole is a background slope, not a mode."""
BAND_MARGIN = 0.12
"""Poles outside the band are fitted as well up to this distance, as a share of the frequency of its edge."""
WIDER_BAND_MARGIN = 0.25
"""The same for a second pass over sweeps that the first leaves poor: with little noise, modes farther away matter.
Tracks are less certain with it: in narrow bands more than one pole may stand for what is outside."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of poles: undamped frequency in rad/s, damping ratio.

    A pole narrower than a tenth of a line's spacing describes one line, not a resonance; one far outside
    the band is a residual term.
    """

    frequency: tuple[float, float]
    half_width: float
    damping: float = LARGEST_DAMPING

    @classmethod
    def of(cls, frequency: NDArray[np.float64], spacing: float) -> "Bounds":
        """Bounds for a band of lines (F,) and their spacing, Hz."""
        return cls((np.pi * frequency[0], 3.0 * np.pi * frequency[-1]), 0.2 * np.pi * spacing)

    def clip(self, parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        """Parameters (J, 2) clipped to the bounds."""
        log_w = np.clip(parameters[:, 0], *np.log(self.frequency))
        narrowest = np.log(self.half_width) - log_w
        log_zeta = np.minimum(np.maximum(parameters[:, 1], narrowest), np.log(self.damping))
        return np.column_stack([log_w, log_zeta])

    def stuck(self, poles: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Which poles lie on a bound: (J,) ndarray."""
        w, zeta = np.abs(poles), -poles.real / np.abs(poles)
        low, high = self.frequency
        at: NDArray[np.bool_] = (w < low * 1.001) | (w > high * 0.999) | (zeta > 0.999 * self.damping)
        return at | (zeta * w < 1.001 * self.half_width)


def to_parameters(poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Log of |pole| and of the damping ratio, (J, 2): steps in them stay inside the stable half plane."""
    w = np.abs(poles)
    return np.column_stack([np.log(w), np.log(np.maximum(-poles.real / w, 1e-12))])


def to_poles(parameters: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Inverse of `to_parameters`."""
    w, zeta = np.exp(parameters[:, 0]), np.exp(parameters[:, 1])
    poles: NDArray[np.complex128] = w * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    return poles


def active_in(
    place: NDArray[np.float64], frequency: NDArray[np.float64], beyond: float = BAND_MARGIN
) -> NDArray[np.bool_]:
    """Which poles lie in a band, or near it.

    Parameters
    ----------
    place : (J, 2) ndarray
        Log |lambda| and log damping ratio.
    frequency : (F,) ndarray, Hz
        Lines of the band, lowest first.
    beyond : float
        Largest distance, as a share of the edge's frequency.

    Returns
    -------
    (J,) ndarray of bool
    """
    f, (low, high) = np.exp(place[:, 0]) / (2.0 * np.pi), frequency[[0, -1]]
    return np.asarray((f > low * (1.0 - beyond)) & (f < high * (1.0 + beyond)))
