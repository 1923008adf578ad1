"""Temperature groups: sweeps at one nominal temperature share the laws there; each reading has a small error.

Up and down ramps, and several levels, visit each temperature more than once. They share log E, nu and log eta at
the group's mean reading.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.thresholds import SAME_TEMPERATURE
from analysis.material import Material

FEWEST = 3
"""Temperatures that laws need: from two, the data cannot tell how smooth a law is."""


@dataclass(frozen=True)
class TemperatureGroups:
    """Assignment of sweeps to groups of equal nominal temperature.

    Attributes
    ----------
    of_sweep : (T,) int ndarray
        Group of each sweep; groups ascend in temperature.
    reference : (G,) ndarray
        Mean reading of each group, degrees Celsius.
    size : (G,) int ndarray
        Sweeps in each group.
    """

    of_sweep: NDArray[np.int_]
    reference: NDArray[np.float64]
    size: NDArray[np.int_]

    @classmethod
    def of(cls, temperature: NDArray[np.float64], tolerance: float = SAME_TEMPERATURE) -> "TemperatureGroups":
        """Group readings (T,), degrees Celsius, none further than `tolerance` K from the first of its group."""
        of_sweep = np.zeros(len(temperature), dtype=int)
        group, first = -1, -np.inf
        for sweep in np.argsort(temperature, kind="stable"):
            if temperature[sweep] - first > tolerance:
                group, first = group + 1, float(temperature[sweep])
            of_sweep[sweep] = group
        return cls.labelled(of_sweep, temperature)

    @classmethod
    def labelled(cls, of_sweep: NDArray[np.int_], temperature: NDArray[np.float64]) -> "TemperatureGroups":
        """Make groups from known group numbers (T,) and readings (T,), degrees Celsius."""
        size = np.bincount(of_sweep)
        return cls(of_sweep, np.bincount(of_sweep, temperature) / size, size)

    def total(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum of `values` (T, ...) over the sweeps of each group, (G, ...)."""
        return np.array([values[self.of_sweep == group].sum(axis=0) for group in range(len(self.size))])


def mean_laws(material: Material, groups: TemperatureGroups) -> NDArray[np.float64]:
    """Return log E, nu and log eta (G, 3), means over each group of estimates for its sweeps."""
    rows = [np.log(material.youngs_modulus), material.poisson_ratio, np.log(material.loss_factor)]
    return np.array([np.bincount(groups.of_sweep, row) / groups.size for row in rows]).T


def distinct_temperatures(temperature: NDArray[np.float64]) -> int:
    """Count the set-points at which readings (T,), degrees Celsius, were taken: legs and levels repeat them."""
    return len(TemperatureGroups.of(temperature).size) if temperature.size else 0
