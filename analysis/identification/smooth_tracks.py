"""Tracks that are smooth in temperature: what poles of all sweeps have in common, and how far they may leave it.

Of a pole's log |lambda| and log damping ratio, one part is the sweep's and common to all modes (modulus and loss
at that temperature), one belongs to the mode and changes slowly, the rest is scatter:

    x(t, j) = base(t, j) + common(t) + curve_j(T) + scatter

The curve of log |lambda| is a polynomial, that of the log damping ratio nearly a constant: what damps a
homogeneous plate damps all its modes alike. `base` is what is known beforehand, a twin's poles say.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.median_deviation import median_deviation

DEGREE = 3
"""Of the polynomial in temperature that belongs to one mode's log |lambda|."""

FREE = 1e6
"""Variance of what nothing is known of."""

BEND = 0.3
"""Standard deviation of a curve's coefficients beyond its constant, log |lambda|, before any is known."""

FEWEST = 5
"""Tracks that tell how much curves differ, at least."""

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

    The numbers that make up the tracks are the common parts, sweep by sweep, then every mode's coefficients.
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

    def learned(self, place: NDArray[np.float64], active: NDArray[np.bool_]) -> "SmoothTracks":
        """Tracks that bend no more than those of one plate do, as the modes seen in every sweep tell.

        Free to bend as they like, tracks pass from one mode to its neighbour where either is hidden.

        Parameters
        ----------
        place : (T, J, 2) ndarray
            Log |lambda| and log damping ratio, of a fit.
        active : (T, J) ndarray of bool
            Modes that take part in a sweep.

        Returns
        -------
        SmoothTracks
        """
        modes = self.own[:, 0, 1] == self.own[:, 0, 1].min(initial=np.inf)  # background bends as it likes
        whole = modes & active.all(axis=0)
        if whole.sum() < FEWEST:
            return self
        curves = np.linalg.lstsq(self.basis, (place - self.base)[:, whole, 0], rcond=None)[0][1:]
        unlike = median_deviation(curves, axis=1)[:, 0]
        own = self.own.copy()
        own[modes, 1:, 0] = np.minimum(own[modes, 1:, 0], np.maximum(unlike, self.scatter[0]) ** 2)
        return replace(self, own=own)

    def one_more(self) -> "SmoothTracks":
        """Tracks with one more, of which nothing is known but that it is a mode of the same plate."""
        like = int(np.argmin(self.own[:, 0, 1]))
        base = np.concatenate([self.base, np.zeros_like(self.base[:, :1])], axis=1)
        return replace(self, base=base, own=np.concatenate([self.own, self.own[[like]]]))

    @property
    def count(self) -> int:
        """Numbers that make up common parts and curves."""
        return 2 * len(self.basis) + self.own.size

    @cached_property
    def certainty(self) -> NDArray[np.float64]:
        """One over the variances of these numbers."""
        common = np.full(2 * len(self.basis), 1.0 / FREE)
        return np.concatenate([common, 1.0 / self.own.ravel()])

    def place(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Poles on the curves, (T, J, 2)."""
        common, own = self._parts(numbers)
        place: NDArray[np.float64] = self.base + common[:, None, :] + np.einsum("tq,jqp->tjp", self.basis, own)
        return place

    def moves(self, matrices: NDArray[np.float64]) -> NDArray[np.float64]:
        """Multiply matrices (T, N, 2J) with the derivatives of all poles by the numbers: (T, N, count)."""
        sweeps, rows = matrices.shape[:2]
        apart = matrices.reshape(sweeps, rows, len(self.own), 2)
        moves = np.zeros((sweeps, rows, self.count))
        common = moves[:, :, : 2 * sweeps].reshape(sweeps, rows, sweeps, 2)
        each = np.arange(sweeps)
        common[each, :, each] = apart.sum(axis=2)
        curves = apart[:, :, :, None, :] * self.basis[:, None, None, :, None]
        moves[:, :, 2 * sweeps :] = curves.reshape(sweeps, rows, self.own.size)
        return moves

    def gathered(self, pull: NDArray[np.float64]) -> NDArray[np.float64]:
        """Slope (count,) of a sum by the numbers, from its slopes (T, J, 2) by the poles' parameters."""
        return np.concatenate([pull.sum(axis=1).ravel(), np.einsum("tq,tjp->jqp", self.basis, pull).ravel()])

    def information(self, seen: NDArray[np.float64]) -> NDArray[np.float64]:
        """Second derivatives (count, count) by the numbers, from those (T, 2J, 2J) by the poles' parameters.

        Every pole depends on its sweep's common part and its mode's own curve alone, so that a few sums do.
        """
        sweeps, degree = self.basis.shape
        modes, first = len(self.own), 2 * sweeps
        seen = seen.reshape(sweeps, modes, 2, modes, 2)
        found = np.zeros((self.count, self.count))
        common = found[:first, :first].reshape(sweeps, 2, sweeps, 2)
        each = np.arange(sweeps)
        common[each, :, each] = seen.sum(axis=(1, 3))
        cross = seen.sum(axis=1)[:, :, :, None, :] * self.basis[:, None, None, :, None]
        found[:first, first:] = cross.reshape(first, self.own.size)
        found[first:, :first] = found[:first, first:].T
        pairs = (self.basis[:, :, None] * self.basis[:, None, :]).reshape(sweeps, degree**2)
        curves = (pairs.T @ seen.reshape(sweeps, 4 * modes**2)).reshape(degree, degree, modes, 2, modes, 2)
        found[first:, first:] = curves.transpose(2, 0, 3, 4, 1, 5).reshape(self.own.size, self.own.size)
        return found

    def _parts(self, numbers: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return common parts (T, 2) and coefficients (J, P, 2)."""
        first = 2 * len(self.basis)
        return numbers[:first].reshape(-1, 2), numbers[first:].reshape(self.own.shape)
