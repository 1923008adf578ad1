"""Temperature groups: sweeps at one nominal temperature share the laws there; each reading has a small error.

Up and down ramps, and several levels, visit each temperature more than once. They share log E, nu and log eta at
the group's mean reading; the slopes of the laws there are taken from the neighbouring groups.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.thresholds import SAME_TEMPERATURE
from analysis.local_laws import LocalLaws
from analysis.material import Material

LENGTH = 30.0
"""Correlation length of the laws' deviation from a straight line, K (Matern 5/2): with it slopes of laws that bend
within 8 to 15 K have errors of 1 % at steps of 2 and 4 K, less than with local polynomials."""
READING_ERROR = 0.025
"""Standard deviation of a group's temperature, K: mean of an up and a down sweep."""


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

    def laws(self, values: NDArray[np.float64]) -> list[LocalLaws]:
        """Local laws of each group through `values` (G, 3): log E, nu and log eta at the references."""
        slope, curvature, _ = law_derivatives(self.reference, values)
        return [
            LocalLaws(float(t), v, s, c)
            for t, v, s, c in zip(self.reference, values, slope, curvature, strict=True)
        ]

    def slope_sigma(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return standard deviations (G, 3) of the slopes estimated from neighbouring groups, per K.

        Between temperatures far apart the slope is uncertain, and so is the effect of a thermal lag or gradient.
        """
        if not np.ptp(self.reference):
            return np.zeros_like(values)
        return law_derivatives(self.reference, values)[2]


def mean_laws(material: Material, groups: TemperatureGroups) -> NDArray[np.float64]:
    """Return log E, nu and log eta (G, 3), means over each group of estimates for its sweeps."""
    rows = [np.log(material.youngs_modulus), material.poisson_ratio, np.log(material.loss_factor)]
    return np.array([np.bincount(groups.of_sweep, row) / groups.size for row in rows]).T


def law_derivatives(
    temperature: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """First and second derivatives (G, 3) of laws through `values` (G, 3), and standard deviations of the first.

    Derivatives of a Gaussian process about a straight line (Rasmussen and Williams, Gaussian Processes for Machine
    Learning, 2006, sections 2.7 and 9.4). With one temperature the derivatives are zero.
    """
    slope, curvature, sigma = (np.zeros_like(values) for _ in range(3))
    if not np.ptp(temperature):
        return slope, curvature, sigma
    design = np.stack([np.ones_like(temperature), temperature - temperature.mean()], axis=1)
    apart = temperature[:, None] - temperature
    r = np.sqrt(5.0) * np.abs(apart) / LENGTH
    fall = np.exp(-r)
    correlation = (1.0 + r + r**2 / 3.0) * fall
    first = -(5.0 / 3.0) * apart / LENGTH**2 * (1.0 + r) * fall
    second = -(5.0 / 3.0) / LENGTH**2 * (1.0 + r - r**2) * fall
    for law, value in enumerate(values.T):
        line = np.linalg.lstsq(design, value)[0]
        bend = float(np.sqrt(np.sum((value - design @ line) ** 2) / max(len(value) - 2, 1)))
        # few points may lie on a line by chance, and two always do
        least = {2: 0.3, 3: 0.1, 4: 0.05}.get(len(value), 0.0)
        size = max(bend, least * float(np.ptp(value)), 1e-9)
        error = np.hypot(READING_ERROR * line[1] / size, 0.01)
        covariance = correlation + error**2 * np.eye(len(value))
        whitened = np.linalg.solve(covariance, np.column_stack([design, value]))
        line = np.linalg.solve(design.T @ whitened[:, :2], design.T @ whitened[:, 2])
        weight = whitened[:, 2] - whitened[:, :2] @ line
        slope[:, law] = line[1] + first @ weight
        curvature[:, law] = second @ weight
        known = (first * np.linalg.solve(covariance, first.T).T).sum(1)
        sigma[:, law] = size * np.sqrt(np.maximum(5.0 / (3.0 * LENGTH**2) - known, 0.0))
    return slope, curvature, sigma
