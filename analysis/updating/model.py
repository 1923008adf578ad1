"""What a twin must offer to be updated."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class MaterialBox:
    """The range of E [Pa], nu and eta over which a twin's accuracy is certified, as (low, high) pairs."""

    youngs_modulus: tuple[float, float]
    poisson_ratio: tuple[float, float]
    loss_factor: tuple[float, float]

    def clip(self, material: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move (..., 3) values of E, nu, eta to the nearest values inside."""
        bounds = np.array([self.youngs_modulus, self.poisson_ratio, self.loss_factor])
        clipped: NDArray[np.float64] = np.clip(material, bounds[:, 0], bounds[:, 1])
        return clipped


class TransferModel(Protocol):
    """A twin as model updating sees it: material in, transfer and its derivatives out."""

    @property
    def box(self) -> MaterialBox:
        """Where the model may be asked."""
        ...

    def frf(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: NDArray[np.float64]
    ) -> NDArray[np.complex128]:
        """Sensor volts per actuator volt, (K, F)."""
        ...

    def sensitivities(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: NDArray[np.float64]
    ) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """The transfer (K, F) and its derivatives (3, K, F) with respect to E, nu and eta."""
        ...
