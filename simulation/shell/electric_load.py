"""Sensor patches connected to inputs of finite impedance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Complex


@dataclass(frozen=True)
class ElectricLoad:
    """Input impedance across each sensor patch.

    Attributes
    ----------
    resistance : float
        ohm; infinite for an open patch.
    capacitance : float
        F, module plus cable.
    """

    resistance: float
    capacitance: float = 0.0

    def __post_init__(self) -> None:
        if not self.resistance > 0.0:
            raise ValueError(f"input resistance is {self.resistance:g} ohm; must be above 0")
        if not self.capacitance >= 0.0:
            raise ValueError(f"input capacitance is {self.capacitance:g} F; must not be negative")

    def across(self, patch_capacitance: NDArray[np.float64], frequency: ArrayLike) -> Complex:
        """Cp + Cc + 1/(j w R) of clamped patches, (K, F), F."""
        omega = 2 * np.pi * np.atleast_1d(np.asarray(frequency, float))
        leak = np.zeros(omega.size, complex) if np.isinf(self.resistance) else 1.0 / (1j * omega * self.resistance)
        return np.asarray(patch_capacitance[:, None] + self.capacitance + leak)

    def admittance(
        self, patch_capacitance: NDArray[np.float64], compliance: Complex, frequency: ArrayLike
    ) -> Complex:
        """Return diag(Cp + Cc + 1/(j w R)) + G of all connected sensors.

        Parameters
        ----------
        patch_capacitance : (K,) ndarray, F
        compliance : (K, K, F) ndarray
            G = b_i' Z**-1 b_j between the sensors.
        frequency : (F,) array_like, Hz, above 0

        Returns
        -------
        (F, K, K) complex ndarray, F
        """
        across = self.across(patch_capacitance, frequency)
        total = np.moveaxis(compliance, -1, 0).astype(complex)
        diagonal = np.arange(patch_capacitance.size)
        total[:, diagonal, diagonal] += across.T
        return total

    def voltages(
        self,
        transfer: Complex,
        compliance: Complex,
        patch_capacitance: NDArray[np.float64],
        frequency: ArrayLike,
    ) -> Complex:
        """Sensor voltages V per actuator volt: (diag(Cp + Cc + 1/(j w R)) + G) V = -h.

        Parameters
        ----------
        transfer : (K, F) ndarray
            h = b_i' Z**-1 b_a, C/V.
        compliance : (K, K, F) ndarray
            G = b_i' Z**-1 b_j between the sensors, C/V.
        patch_capacitance : (K,) ndarray, F
        frequency : (F,) array_like, Hz, above 0

        Returns
        -------
        (K, F) complex ndarray, V/V
        """
        total = self.admittance(patch_capacitance, compliance, frequency)
        return np.asarray(-np.linalg.solve(total, transfer.T[..., None])[..., 0].T, complex)
