"""Temperature groups: sweeps at one nominal temperature share the laws there; how laws run on between them.

Up and down ramps, and several levels, visit each temperature more than once. They share log E, nu and log eta at
the group's mean reading.
"""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.gap.thresholds import SAME_TEMPERATURE
from analysis.material import LocalLaws, Material

FEWEST = 3
"""Temperatures that laws need: from two, the data cannot tell how smooth a law is."""
LENGTH = 30.0
"""Correlation length of the laws' deviation from a straight line, K (Matern 5/2): with it slopes of laws that bend
within 8 to 15 K have errors of 1 % at steps of 2 and 4 K, less than with local polynomials."""
READING_ERROR = 0.025
"""Standard deviation of a group's temperature, K: mean of an up and a down sweep."""
UNCERTAIN = 1e-9
"""Smallest variance of a combination of derivatives, as a share of the largest, all in units of their own standard
deviations: what is less uncertain follows from the values."""


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


@dataclass(frozen=True)
class LawSmoothness:
    """Derivatives of L laws at G temperatures, first all slopes, then all curvatures.

    They are those of a Gaussian process about a straight line of any height and slope (Rasmussen and Williams,
    Gaussian Processes for Machine Learning, 2006, sections 2.7 and 9.4). Given the values v, they are
    ``by_values v + root z`` with independent standard normal z: neighbouring temperatures share their errors.

    Attributes
    ----------
    temperature : (G,) ndarray
        Degrees Celsius.
    by_values : (L, 2G, G) ndarray
        Derivative of the derivatives of each law by its values, 1/K and 1/K2.
    root : tuple of L (2G, R) ndarray
        Of each law: root of the covariance of its derivatives at fixed values, per K and per K2. R is the number
        of combinations that are uncertain; 0 where all temperatures are the same, and the derivatives are zero.
    """

    temperature: Real
    by_values: Real = field(repr=False)
    root: tuple[Real, ...] = field(repr=False)

    @classmethod
    def of(cls, temperature: Real, values: Real) -> Self:
        """Take the size of the laws' deviation from straight lines from approximate `values` (G, L)."""
        if not np.ptp(temperature):
            return cls.flat(temperature, values.shape[1])
        found = [_derivatives(temperature, value) for value in values.T]
        roots = tuple(_root(covariance) for _, covariance in found)
        return cls(temperature, np.array([by_values for by_values, _ in found]), roots)

    @classmethod
    def flat(cls, temperature: Real, laws: int = 3) -> Self:
        """Laws that do not change near each temperature: for sweeps that have nothing to do with each other."""
        count = len(temperature)
        return cls(temperature, np.zeros((laws, 2 * count, count)), laws * (np.zeros((2 * count, 0)),))

    @property
    def unknowns(self) -> int:
        """Number of the uncertain combinations of all laws."""
        return sum(root.shape[1] for root in self.root)

    @property
    def slope_sigma(self) -> Real:
        """Standard deviations (G, L) of the slopes at fixed values, per K."""
        return np.stack([np.sqrt((root[: len(self.temperature)] ** 2).sum(axis=1)) for root in self.root], axis=1)

    def derivatives(self, values: Real) -> tuple[Real, Real]:
        """Likeliest slopes and curvatures, each (G, L), of laws through `values` (G, L)."""
        slope, curvature = np.split(np.einsum("ldg,gl->dl", self.by_values, values), 2)
        return slope, curvature

    def deviations(self, errors: Real) -> tuple[Real, Real]:
        """Return how far slopes and curvatures, each (G, L), are from these for `errors` z (`unknowns`,)."""
        parts = np.split(errors, np.cumsum([root.shape[1] for root in self.root])[:-1])
        slope, curvature = np.split(np.stack([r @ z for r, z in zip(self.root, parts, strict=True)], axis=1), 2)
        return slope, curvature

    def errors(self, slope: Real, curvature: Real) -> Real:
        """Return the errors z (`unknowns`,) of `deviations` (G, L) of slopes and curvatures."""
        rows = np.concatenate([slope, curvature]).T
        return np.concatenate([_inverse(root) @ row for root, row in zip(self.root, rows, strict=True)])

    def laws(self, values: Real) -> list[LocalLaws]:
        """Return log E, nu and log eta through `values` (G, 3), with the likeliest derivatives."""
        rows = zip(self.temperature, values, *self.derivatives(values), strict=True)
        return [LocalLaws(float(t), value, slope, curvature) for t, value, slope, curvature in rows]

    def seen(self, group: int, away: float) -> Real:
        """Differentiate what a sweep sees of log E, nu and log eta by the unknowns.

        Parameters
        ----------
        group : int
            The sweep's.
        away : float
            Its temperature less that of the group, K.

        Returns
        -------
        (9, 3G + `unknowns`) ndarray
            Rows: three values, slopes and curvatures at the sweep's temperature. Columns: three values of each
            group, then the errors z, about the sweep's temperature as in `LocalLaws.tilted`.
        """
        count, first = len(self.temperature), 3 * len(self.temperature)
        found = np.zeros((3, 3, first + self.unknowns))  # by order of the derivative, and law
        for law, (by_values, root) in enumerate(zip(self.by_values, self.root, strict=True)):
            slope, curvature = by_values[group], by_values[count + group]
            of_values = found[:, law, law : 3 * count : 3]
            of_values[:] = away * (slope + 0.5 * away * curvature), slope + away * curvature, curvature
            of_values[0, group] += 1.0
            found[1:, law, first : first + root.shape[1]] = root[group], root[count + group]
            first += root.shape[1]
        return found.reshape(9, -1)


def _derivatives(temperature: Real, value: Real) -> tuple[Real, Real]:
    """Return the derivatives of one law by its values (2G, G), and their covariance at fixed values."""
    count = len(value)
    apart = temperature[:, None] - temperature
    a = np.sqrt(5.0) / LENGTH
    r = a * np.abs(apart)
    fall = np.exp(-r)
    # the process' correlation and its first, second, third and fourth derivatives
    correlation = (1.0 + r + r**2 / 3.0) * fall
    first = -(a**2) / 3.0 * apart * (1.0 + r) * fall
    second = -(a**2) / 3.0 * (1.0 + r - r**2) * fall
    third = a**3 / 3.0 * np.sign(apart) * (3.0 * r - r**2) * fall
    fourth = a**4 / 3.0 * (3.0 - 5.0 * r + r**2) * fall
    design = np.stack([np.ones(count), temperature - temperature.mean()], axis=1)
    line = np.linalg.lstsq(design, value)[0]
    # few points may lie on a line by chance, and two always do
    least = max({2: 0.3, 3: 0.1, 4: 0.05}.get(count, 0.0) * float(np.ptp(value)), 1e-9)
    bend = max(float(np.sqrt(np.sum((value - design @ line) ** 2) / max(count - 2, 1))), least)
    error = np.hypot(READING_ERROR * line[1] / bend, 0.01)
    weight = np.linalg.inv(correlation + error**2 * np.eye(count))
    of_line = np.linalg.inv(design.T @ weight @ design)
    by_line = of_line @ design.T @ weight
    across = np.concatenate([first, second])
    rest = np.concatenate([np.tile([0.0, 1.0], (count, 1)), np.zeros((count, 2))]) - across @ weight @ design
    # variance of the process by maximum likelihood, the line being free: its own scatter would be too small,
    # because a line follows the longest waves of the process
    power = float(value @ weight @ (value - design @ (by_line @ value))) / max(count - 2, 1)
    own = np.block([[-second, third], [third.T, fourth]])
    covariance = own - across @ weight @ across.T + rest @ of_line @ rest.T
    return across @ weight + rest @ by_line, max(power, least**2) * covariance


def _root(covariance: Real) -> Real:
    """Return a root (2G, R) of the part of a covariance that is not negligible."""
    scale = np.sqrt(np.diag(covariance))
    power, directions = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = power > UNCERTAIN * power[-1]
    return np.asarray(scale[:, None] * directions[:, kept] * np.sqrt(power[kept]))


def _inverse(root: Real) -> Real:
    """Pseudo-inverse of a root as `_root` gives it; rows in units of their own standard deviations."""
    if not root.size:
        return root.T
    scale = np.sqrt((root**2).sum(axis=1))
    return np.asarray(np.linalg.pinv(root / scale[:, None]) / scale)
