"""What a twin must offer to be updated."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.material import MaterialBox


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
        """Return the transfer (K, F) and its derivatives (3, K, F) with respect to E, nu and eta."""
        ...
