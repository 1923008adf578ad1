"""Waves of an unbounded Mindlin plate at one frequency, of which exact solutions are superposed.

All quantities are dimensionless: lengths over a, time over a**2 sqrt(rho h / D), so that D = rho h = a = 1 and the
frequency is Omega = w a**2 sqrt(rho h / D). Free waves then obey, with grad w + theta the transverse shear strain,

    s div(grad w + theta) + Omega**2 w = 0
    div M - s (grad w + theta) + r Omega**2 theta = 0

with the shear stiffness s and the rotary inertia r of `PlateWaves`. Setting theta = grad phi + rot H splits them
into two potentials of w (phi proportional to w) and one of H. R. D. Mindlin, J. Appl. Mech. 18 (1951) 31-38.
"""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from simulation.shell.shear_factor import SHEAR_FACTOR


@dataclass(frozen=True)
class PlateWaves:
    """A Mindlin plate in units of its length a.

    Attributes
    ----------
    thickness : float
        h / a.
    poisson_ratio : float
    """

    thickness: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        if not 0.0 < self.thickness <= 1.0:
            raise ValueError(f"thickness is {self.thickness:g} of the plate's length; allowed above 0, up to 1")
        if not -1.0 < self.poisson_ratio < 0.5:
            raise ValueError(f"Poisson's ratio is {self.poisson_ratio:g}; allowed between -1 and 0.5")

    @property
    def shear(self) -> float:
        """Shear stiffness s = k G h a**2 / D."""
        return 6.0 * SHEAR_FACTOR * (1.0 - self.poisson_ratio) / self.thickness**2

    @property
    def rotary(self) -> float:
        """Rotary inertia r = (h / a)**2 / 12."""
        return self.thickness**2 / 12.0

    @property
    def cut_off(self) -> float:
        """Frequency Omega above which the two evanescent waves propagate too."""
        return float(np.sqrt(self.shear / self.rotary))

    def bending(self, frequency: Real) -> tuple[Real, Real]:
        """Squared wave numbers of the two potentials of w, (2, F), and theirs of H, (F,).

        Each is m in Laplacian(f) = -m f: positive where the wave travels, as the first is at every frequency.
        """
        square = np.asarray(frequency, float) ** 2
        half_sum = 0.5 * square * (1.0 / self.shear + self.rotary)
        product = square * (self.rotary * square / self.shear - 1.0)
        root = np.sqrt(half_sum**2 - product)
        first = half_sum + root
        twist = -2.0 / (1.0 - self.poisson_ratio) * (self.shear - self.rotary * square)
        return np.stack([first, product / first]), twist

    def potential(self, frequency: Real, bending: Real) -> Real:
        """Return phi of a wave whose deflection is m f: (Omega**2 / s - m) f, (2, F)."""
        return np.asarray(np.asarray(frequency, float) ** 2 / self.shear - bending)
