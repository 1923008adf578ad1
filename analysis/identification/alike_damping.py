"""Damping ratios of one plate, which are alike: what most modes tell of those that their neighbours hide.

Two modes that overlap look like one of more damping, and where many overlap each one's damping is hardly known.
What damps a plate damps its modes by about as much, so the others say which is likely. How alike they are is taken
from the modes themselves; a Student distribution leaves alone a mode that plainly is not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.identification.parameters import to_parameters
from analysis.median_deviation import median_deviation

FREEDOM = 4.0
"""Degrees of freedom of the distribution: low ones leave alone what is far from the others."""

FEWEST = 8
"""Modes that tell how alike all are, at least."""

LEAST_DEVIATION = 0.02
"""Of the log damping ratio, at least."""

HARDLY_KNOWN = 0.5
"""Deviation of a mode's log damping ratio, in that of all, from which it has something to learn."""

UNLIKE = 3.0
"""Departure from the others, in the same, from which it may be two modes."""

SHARED = (1.4, 6.0)
"""Damping of a pole, in that of the others, and its departure from them, in the same, from which it is reported
that it may be two modes: where forty modes overlap, those that are have 1.5 to 2 and 9 to 30."""

NEIGHBOURHOOD, NEIGHBOURS = 3.0, 2
"""Modes overlap where so many half-power bandwidths on either side hold at least so many others."""


@dataclass(frozen=True)
class AlikeDamping:
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
    def learned(
        cls, poles: NDArray[np.complex128], deviations: NDArray[np.float64], band: tuple[float, float]
    ) -> "AlikeDamping | None":
        """Distribution that poles tell.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.
        deviations : (J,) ndarray
            Of their log damping ratios.
        band : (float, float)
            rad/s.

        Returns
        -------
        AlikeDamping or None
            None where they are few, or all better known than they are alike.
        """
        inside = (poles.imag > band[0]) & (poles.imag < band[1])
        if inside.sum() < FEWEST:
            return None
        damping = to_parameters(poles)[inside, 1]
        middle = float(np.median(damping))
        away = np.abs(damping - middle)
        deviation = max(float(median_deviation(damping)[0]), LEAST_DEVIATION)
        if not ((deviations[inside] > HARDLY_KNOWN * deviation) | (away > UNLIKE * deviation)).any():
            return None
        return cls(middle, deviation, band)

    def above(self, poles: NDArray[np.complex128]) -> NDArray[np.float64]:
        """How many deviations each pole's log damping ratio lies above the middle, (J,); 0 outside the band."""
        inside = (poles.imag > self.band[0]) & (poles.imag < self.band[1])
        return np.where(inside, (to_parameters(poles)[:, 1] - self.middle) / self.deviation, 0.0)

    def shared(self, poles: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Which poles may stand for two modes, (J,): damped far more than the others, among modes that overlap."""
        above, width = self.above(poles), 2.0 * np.exp(self.middle) * np.abs(poles)
        near = np.abs(poles.imag[:, None] - poles.imag) < NEIGHBOURHOOD * width[:, None]
        crowded = (near & (np.abs(above) < UNLIKE)).sum(axis=1) >= NEIGHBOURS
        more = (above > SHARED[1]) & (above * self.deviation > np.log(SHARED[0]))
        return np.asarray(more & crowded, dtype=np.bool_)

    def departure(
        self, poles: NDArray[np.complex128]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Twice the negative logarithm of each pole's probability, from its least.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s.

        Returns
        -------
        value : (J,) ndarray
        slope, bend : (J,) ndarray
            Half the first derivative by each log damping ratio, and half the second, as if it did not change.
        """
        inside = (poles.imag > self.band[0]) & (poles.imag < self.band[1])
        away = self.above(poles)
        bend = np.where(inside, (FREEDOM + 1.0) / (FREEDOM + away**2) / self.deviation**2, 0.0)
        return (FREEDOM + 1.0) * np.log1p(away**2 / FREEDOM), away * bend * self.deviation, bend
