"""Estimates with standard deviations: of one parameter, and of the material laws at a campaign's temperatures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
    sheet : SheetMaterial or None
        Constants by direction of an orthotropic sheet; None for an isotropic one.
    """

    temperature: NDArray[np.float64]
    value: NDArray[np.float64]
    sigma: NDArray[np.float64]
    sheet: SheetMaterial | None = None
