"""Mode shapes of a plate from its twin, at any temperature of its laws."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.material import MaterialLaws

LARGEST_RIGID_FREQUENCY = 1.0
"""Hz; rigid motion stands below."""
LEAST_DEFLECTION = 0.02
"""Share of the largest mode's rms deflection, below which a mode is no bending: the rotation of a free plate
within its plane is none, patches do not drive it, and a twin made for them puts it at tens of hertz."""


@dataclass(frozen=True)
class Shapes:
    """A plate that can be asked for its shapes.

    Attributes
    ----------
    modes : callable
        E [Pa], nu, eta and a count to squared angular frequencies (m,), complex, rad2/s2, and shapes (r, m).
    deflection : (K, r) ndarray
        Of every coordinate at `points`.
    points : (K, 2) ndarray
        Points of a grid that lie on the plate, x slowest, m.
    laws : MaterialLaws
    """

    modes: Callable[[float, float, float, int], tuple[Complex, Real]]
    deflection: Real
    points: Real
    laws: MaterialLaws

    @property
    def x(self) -> Real:
        """Points along the plate, (X,), m."""
        return np.unique(self.points[:, 0])

    @property
    def y(self) -> Real:
        """Points across the plate, (Y,), m."""
        return np.unique(self.points[:, 1])

    def constants(self, temperature: float) -> tuple[float, float, float]:
        """E [Pa], nu and eta at a temperature, or at the nearest end of the laws."""
        low, high = self.laws.temperature_range
        law = self.laws.at(np.array([min(max(temperature, low), high)]))
        return float(law.youngs_modulus[0]), float(law.poisson_ratio[0]), float(law.loss_factor[0])

    def lowest(self, temperature: float, count: int) -> tuple[Real, Real, Real]:
        """Natural frequencies (m,), Hz, loss factors (m,) and shapes (m, X, Y) of the lowest bending modes.

        `count` of them, less those of rigid motion.
        """
        values, shapes = self.modes(*self.constants(temperature), count)
        found = (self.deflection @ shapes).T
        level = np.linalg.norm(found, axis=1)
        bending = (values.real > (2.0 * np.pi * LARGEST_RIGID_FREQUENCY) ** 2) & (
            level > LEAST_DEFLECTION * level.max()
        )
        values = values[bending]
        return np.sqrt(values.real) / (2.0 * np.pi), values.imag / values.real, self.on_grid(found[bending])

    def on_grid(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values at the points (..., K) as (..., X, Y); NaN off the plate."""
        found = np.full((*values.shape[:-1], len(self.x), len(self.y)), np.nan, values.dtype)
        row, column = (np.searchsorted(at, self.points[:, k]) for k, at in enumerate((self.x, self.y)))
        found[..., row, column] = values
        return found
