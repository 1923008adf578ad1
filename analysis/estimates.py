"""Estimates with standard deviations: of one parameter, and of the material laws at a campaign's temperatures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_finite, check_shapes
from analysis.sheet_material import SheetMaterial


@dataclass(frozen=True)
class Estimate:
    """A parameter's value and one standard deviation, inflated as those of `FittedLaws`, SI."""

    name: str
    value: float
    sigma: float
    unit: str


@dataclass(frozen=True)
class FittedLaws:
    """Laws at the groups' temperatures.

    Attributes
    ----------
    temperature : (G,) ndarray
        Degrees Celsius.
    value, sigma : (G, 3) ndarray
        log E [log Pa], nu and log eta, with standard deviations inflated where more than noise is left, and by the
        twin's own error.
    common : (G, 3, P + 1) ndarray or None
        What one standard deviation of each of P declared quantities moves in them, with sign, and last that of all
        else that the temperatures share, the twin's own error included. None without tolerances.
    sheet : SheetMaterial or None
        Constants by direction of an orthotropic sheet; None for an isotropic one.
    """

    temperature: NDArray[np.float64]
    value: NDArray[np.float64]
    sigma: NDArray[np.float64]
    common: NDArray[np.float64] | None = None
    sheet: SheetMaterial | None = None

    def __post_init__(self) -> None:
        check_shapes(self, temperature="G", value="G 3", sigma="G 3", common="G 3 P")
        check_finite(self, "temperature", "value")

    @property
    def shared(self) -> NDArray[np.float64]:
        """Return `common`, without columns where there are no tolerances, (G, 3, P)."""
        return np.zeros((self.temperature.size, 3, 0)) if self.common is None else self.common

    @property
    def own_sigma(self) -> NDArray[np.float64]:
        """Return the part of `sigma` that each temperature has for itself, (G, 3)."""
        own: NDArray[np.float64] = np.maximum(self.sigma**2 - (self.shared**2).sum(-1), (1e-6 * self.sigma) ** 2)
        return np.asarray(np.sqrt(own))
