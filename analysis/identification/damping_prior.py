"""Distribution of the damping ratios of one plate: a prior for modes that overlap with their neighbours.

Two modes that overlap look like one mode with more damping, and where many overlap, the damping of each is hardly
determined. A plate's material damps all its modes by about as much, so the other modes are a prior. Its width is
estimated from the modes themselves; the heavy tails of a Student distribution allow outliers.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.identification.pole_residue import to_parameters
from analysis.scatter import median_deviation

STUDENT_FREEDOM = 4.0
"""Degrees of freedom of the Student distribution: with few, an outlier is hardly pulled to the others."""

FEWEST_MODES = 8
"""Modes needed at least to estimate the distribution."""

LEAST_DEVIATION = 0.02
"""Smallest standard deviation of the distribution of the log damping ratio."""

HARDLY_KNOWN = 0.5
"""A prior is used only if some mode's log damping ratio is known worse than this share of the scatter of all."""

DOUBLE_MODE_SIGMA = 3.0
"""Standard deviations above the median from which a pole may represent two modes."""

SHARED = (1.4, 6.0)
"""Damping ratio over the median, and standard deviations above it, from which a pole is reported as possibly two
modes: where forty modes overlap, poles that represent two have 1.5 to 2 and 9 to 30."""

NEIGHBOURHOOD, OVERLAPPING_MODES = 3.0, 2
"""Modes overlap where this many half-power bandwidths to either side hold at least this many other modes."""


@dataclass(frozen=True)
class DampingPrior:
    """Distribution of log damping ratios of the modes in a band.

    Attributes
    ----------
    middle, deviation : float
    band : (float, float)
        rad/s.
    """

    middle: float
    deviation: float
    band: tuple[float, float]

    @classmethod
    def estimated(
        cls, poles: NDArray[np.complex128], deviations: NDArray[np.float64], band: tuple[float, float]
    ) -> "DampingPrior | None":
        """Estimate the distribution from poles.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.
        deviations : (J,) ndarray
            Standard deviations of their log damping ratios.
        band : (float, float)
            rad/s.

        Returns
        -------
        DampingPrior or None
            None where there are too few poles, or the prior would add nothing to what is known of each.
        """
        inside = (poles.imag > band[0]) & (poles.imag < band[1])
        if inside.sum() < FEWEST_MODES:
            return None
        damping = to_parameters(poles)[inside, 1]
        middle = float(np.median(damping))
        away = np.abs(damping - middle)
        deviation = max(float(median_deviation(damping)[0]), LEAST_DEVIATION)
        if not ((deviations[inside] > HARDLY_KNOWN * deviation) | (away > DOUBLE_MODE_SIGMA * deviation)).any():
            return None
        return cls(middle, deviation, band)

    def above(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        """How many deviations each pole's log damping ratio lies above the middle, (J,); 0 outside the band."""
        inside = (poles.imag > self.band[0]) & (poles.imag < self.band[1])
        return np.where(inside, (to_parameters(poles)[:, 1] - self.middle) / self.deviation, 0.0)

    def shared(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Damping ratio over the median, (J,), of poles that may represent two overlapping modes; 0 for others."""
        above, width = self.above(poles), 2.0 * np.exp(self.middle) * np.abs(poles)
        near = np.abs(poles.imag[:, None] - poles.imag) < NEIGHBOURHOOD * width[:, None]
        crowded = (near & (np.abs(above) < DOUBLE_MODE_SIGMA)).sum(axis=1) >= OVERLAPPING_MODES
        times = np.exp(above * self.deviation)
        return np.where(crowded & (above > SHARED[1]) & (times > SHARED[0]), times, 0.0)

    def departure(
        self, poles: NDArray[np.complex128]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Twice the negative log probability of each pole's damping ratio, less its minimum, with derivatives.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.

        Returns
        -------
        value : (J,) ndarray
        slope, bend : (J,) ndarray
            Half the first derivative with respect to the log damping ratio, and half the second, taken as
            constant.
        """
        inside = (poles.imag > self.band[0]) & (poles.imag < self.band[1])
        away = self.above(poles)
        bend = np.where(inside, (STUDENT_FREEDOM + 1.0) / (STUDENT_FREEDOM + away**2) / self.deviation**2, 0.0)
        return (STUDENT_FREEDOM + 1.0) * np.log1p(away**2 / STUDENT_FREEDOM), away * bend * self.deviation, bend
