"""Natural frequency and damping of a pole, with standard deviations.

A polymer's damping is hysteretic: with k = -lambda^2 the complex stiffness over mass of the mode, sqrt(Re k)/2 pi
is the frequency from its storage modulus alone, and Im k / Re k its loss factor. The frequency of a
viscous oscillator, |lambda|/2 pi, lies higher by a share of eta^2/4 for the same pole (eta^2/2 in the modulus).
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Damping = Literal["hysteretic", "viscous"]


@dataclass(frozen=True)
class PoleReading:
    """Frequency and damping of poles, each array shaped like the poles.

    Attributes
    ----------
    frequency_hz, sigma_frequency_hz : ndarray, Hz
    damping_ratio, sigma_damping_ratio : ndarray
        -Re lambda / |lambda|, for hysteretic and viscous damping alike.
    loss_factor, sigma_loss_factor : ndarray
        Im k / Re k if hysteretic, twice the damping ratio if viscous.
    """

    frequency_hz: NDArray[np.float64]
    sigma_frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    sigma_damping_ratio: NDArray[np.float64]
    loss_factor: NDArray[np.float64]
    sigma_loss_factor: NDArray[np.float64]


def read_poles(
    poles: NDArray[np.complex128], covariance: NDArray[np.float64], damping: Damping = "hysteretic"
) -> PoleReading:
    """Read frequency and damping off poles.

    Parameters
    ----------
    poles : (...) complex ndarray
        rad/s, upper half plane.
    covariance : (..., 2, 2) ndarray
        Of log |lambda| and log damping ratio of each pole.
    damping : str
        ``hysteretic`` or ``viscous``.

    Returns
    -------
    PoleReading
        Frequency, Hz, damping ratio and loss factor, (...), with standard deviations.
    """
    w = np.abs(poles)
    zeta = -poles.real / w
    spread_w, spread_zeta = covariance[..., 0, 0], covariance[..., 1, 1]
    if damping == "viscous":
        f, eta = w / (2.0 * np.pi), 2.0 * zeta
        sigma_f, sigma_eta = f * np.sqrt(spread_w), eta * np.sqrt(spread_zeta)
    else:
        storage = 1.0 - 2.0 * zeta**2
        f = w * np.sqrt(storage) / (2.0 * np.pi)
        eta = 2.0 * zeta * np.sqrt(1.0 - zeta**2) / storage
        slope_f = -2.0 * zeta**2 / storage  # d log f / d log zeta
        slope_eta = 1.0 - zeta**2 / (1.0 - zeta**2) + 4.0 * zeta**2 / storage
        cross = covariance[..., 0, 1]
        sigma_f = f * np.sqrt(np.maximum(spread_w + 2.0 * slope_f * cross + slope_f**2 * spread_zeta, 0.0))
        sigma_eta = eta * np.abs(slope_eta) * np.sqrt(spread_zeta)
    return PoleReading(f, sigma_f, zeta, zeta * np.sqrt(spread_zeta), eta, sigma_eta)
