"""Tracks that are smooth in temperature: what poles of all sweeps have in common, and how far they may leave it.

Of a pole's log |lambda| and log damping ratio, one part is the sweep's and common to all modes (modulus and loss
at that temperature), one belongs to the mode and changes slowly, the rest is scatter:

    x(t, j) = base(t, j) + common(t) + curve_j(T) + scatter

The curve of log |lambda| is a polynomial, that of the log damping ratio nearly a constant: what damps a
homogeneous plate damps all its modes alike. `base` is what is known beforehand, a twin's poles say.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

DEGREE = 3
"""Of the polynomial in temperature that belongs to one mode's log |lambda|."""

FREE = 1e6
"""Variance of what nothing is known of."""

BEND = 0.3
"""Standard deviation of a curve's coefficients beyond its constant, log |lambda|."""

OWN_DAMPING = (0.02, 0.005)
"""Standard deviations of a mode's own log damping ratio: constant, and along temperature."""

SCATTER = (2e-4, 2e-3)
"""Of log |lambda| and log damping ratio about the curves: laws of real materials are no polynomials."""


@dataclass(frozen=True)
class SmoothTracks:
    """Prior of the poles (T, J) of a campaign, in log |lambda| and log damping ratio.

    Attributes
    ----------
    basis : (T, P) ndarray
        Polynomials in temperature, the constant first.
    base : (T, J, 2) ndarray
        What is known beforehand; zeros where nothing is.
    own : (J, P, 2) ndarray
        Variances of each mode's coefficients; those of damping beyond the second are not used.
    scatter : (2,) ndarray
        Standard deviations of the scatter.
    """

    basis: NDArray[np.float64]
    base: NDArray[np.float64]
    own: NDArray[np.float64]
    scatter: NDArray[np.float64]

    @classmethod
    def polynomials(
        cls,
        temperature: NDArray[np.float64],
        base: NDArray[np.float64],
        frequency: tuple[float, ...] = (FREE,),
        damping: tuple[float, float] = OWN_DAMPING,
        degree: int = DEGREE,
    ) -> "SmoothTracks":
        """Make tracks with polynomials in temperature.

        Parameters
        ----------
        temperature : (T,) ndarray
            Degrees Celsius.
        base : (T, J, 2) ndarray
            What is known beforehand; zeros where nothing is.
        frequency : tuple of float
            Standard deviations of the coefficients of log |lambda|, the last for all that follow; `BEND` after an
            only one.
        damping : (float, float)
            Those of the log damping ratio's constant and slope.
        degree : int
            At most; fewer sweeps than three for a coefficient have a lower one.

        Returns
        -------
        SmoothTracks
        """
        span = max(float(np.ptp(temperature)), 1e-9)
        degree = min(degree, max((len(temperature) - 1) // 3, 0))
        basis = np.polynomial.chebyshev.chebvander(2.0 * (temperature - temperature.min()) / span - 1.0, degree)
        own = np.full((base.shape[1], degree + 1, 2), 1e-12)
        later = frequency[1:] or (BEND,)
        own[:, :, 0] = np.square([frequency[0], *(later[min(p, len(later) - 1)] for p in range(degree))])
        own[:, : min(2, degree + 1), 1] = np.square(damping)[: degree + 1]
        return cls(basis, base, own, np.array(SCATTER))

    @property
    def count(self) -> int:
        """Numbers that make up common parts and curves."""
        return 2 * len(self.basis) + self.own.size

    @cached_property
    def certainty(self) -> NDArray[np.float64]:
        """One over the variances of these numbers."""
        common = np.full(2 * len(self.basis), 1.0 / FREE)
        return np.concatenate([common, 1.0 / self.own.ravel()])

    @cached_property
    def design(self) -> NDArray[np.float64]:
        """Derivative (T, 2J, count) of every pole's parameters by these numbers."""
        sweeps, degree = self.basis.shape
        modes = len(self.own)
        design = np.zeros((sweeps, modes, 2, self.count))
        for t in range(sweeps):
            for p in (0, 1):
                design[t, :, p, 2 * t + p] = 1.0
                for j in range(modes):
                    first = 2 * sweeps + 2 * degree * j + p
                    design[t, j, p, first : first + 2 * degree : 2] = self.basis[t]
        return design.reshape(sweeps, 2 * modes, self.count)

    def place(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Poles on the curves, (T, J, 2)."""
        return self.base + (self.design @ numbers).reshape(self.base.shape)
