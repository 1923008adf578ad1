"""Patches and voltages: the force of one volt, and sensors connected to inputs of finite impedance."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.arrays import Complex, Real
from simulation.shell.rigidity import THX, THY, U, V
from simulation.shell.shell_plate import ShellPlate


def couplings(shell: ShellPlate, thickness: Real, bond: float = 1.0) -> list[dict[int, Real]]:
    """Force of one volt on every patch.

    Parameters
    ----------
    thickness : (cells,) or (Q,) ndarray
        Of the plate, for every cell or every point of quadrature, m.
    bond : float
        Share of the force transmitted by the bond.

    Returns
    -------
    list of dict of int to (N,) ndarray
        Of each patch, by field, values over the functions, N/V.
    """
    found = []
    for k, patch in enumerate(shell.patches):
        h = thickness if len(thickness) == len(shell.space.dx) else shell.space.spread(thickness)
        sign = 1.0 if patch.side == "top" else -1.0
        height = 0.5 * sign * (h + patch.thickness)
        factor = bond * shell.materials[patch.material].e31
        found.append(_dilatation(shell, k, factor * np.ones_like(h), factor * height))
    return found


def _dilatation(shell: ShellPlate, patch: int, flat: Real, height: Real) -> dict[int, Real]:
    """Integral under a patch of flat (u,x + v,y) + height (thx,x + thy,y), (Q,) each, by field (N,)."""
    cells = shell.under[patch]
    moments = shell.space.moments
    if shell.surface is None:
        return {
            U: moments("x", flat, cells),
            V: moments("y", flat, cells),
            THX: moments("x", height, cells),
            THY: moments("y", height, cells),
        }
    found: dict[int, Real] = {}
    for weight, strains in ((flat, (0, 1)), (height, (3, 4))):
        for strain in strains:
            for (field, letter), factor in shell.surface.strains[strain].items():
                part = moments(letter, shell.surface.area * weight * factor, cells)
                found[field] = found.get(field, 0.0) + part
    return found


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
