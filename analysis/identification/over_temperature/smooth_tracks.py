"""Tracks: prior of the poles of all sweeps, smooth in temperature.

A pole's log |lambda| and log damping ratio have a part common to all modes of a sweep (modulus and loss factor at
its temperature), a part of the mode that changes slowly with temperature, and scatter:

    x(t, j) = base(t, j) + common(t) + curve_j(T) + scatter

The curve of log |lambda| is a polynomial, that of the log damping ratio nearly a constant: the material of a
homogeneous plate damps all its modes alike. `base` is prior knowledge, for example a twin's poles.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analysis.scatter import median_deviation, scatter_of

DEGREE = 3
"""Degree of the polynomial in temperature of one mode's log |lambda|."""

VARIANCE_OF_UNKNOWN = 1e6
"""Prior variance of an unknown parameter."""

CURVE_SIGMA = 0.3
"""Standard deviation of a curve's coefficients beyond its constant, log |lambda|, before any is known."""

FEWEST_TRACKS = 5
"""Smallest number of tracks from which the variance of curves is estimated."""

OWN_DAMPING = (0.02, 0.005)
"""Standard deviations of a mode's own log damping ratio: constant, and along temperature."""

SCATTERED = (0.01, 1.0)
"""Least and largest standard deviation of modes' own log damping ratios looked for. Of a homogeneous sheet on
strings it is 0.01 to 0.03, of mounted plates 0.4; with 1 every third mode is off by a factor of 2.7."""

WIDE = (0.7, 0.2)
"""`OWN_DAMPING` of a first fit from which the scatter is learned: a factor of two either way is likely then, and
of two modes that hide each other neither takes all the damping."""

SCATTER_ABOUT_CURVES = (2e-4, 2e-3)
"""Scatter of log |lambda| and log damping ratio about the curves: real material laws are no polynomials."""


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
        Prior variances of each mode's coefficients; those of damping beyond the second are not used.
    scatter : (2,) ndarray
        Standard deviations of the scatter.

    The parameters of the tracks, called numbers below, are the common parts, sweep by sweep, then every mode's
    coefficients.
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
        frequency: tuple[float, ...] = (VARIANCE_OF_UNKNOWN,),
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
            Standard deviations of the coefficients of log |lambda|; the last holds for all higher ones,
            `CURVE_SIGMA` if only one is given.
        damping : (float, float)
            Those of the log damping ratio's constant and slope.
        degree : int
            Largest degree; lower where there are fewer than three sweeps per coefficient.
        """
        span = max(float(np.ptp(temperature)), 1e-9)
        degree = min(degree, max((len(temperature) - 1) // 3, 0))
        basis = np.polynomial.chebyshev.chebvander(2.0 * (temperature - temperature.min()) / span - 1.0, degree)
        own = np.full((base.shape[1], degree + 1, 2), 1e-12)
        later = frequency[1:] or (CURVE_SIGMA,)
        own[:, :, 0] = np.square([frequency[0], *(later[min(p, len(later) - 1)] for p in range(degree))])
        own[:, : min(2, degree + 1), 1] = np.square(damping)[: degree + 1]
        return cls(basis, base, own, np.array(SCATTER_ABOUT_CURVES))

    def estimated(self, place: NDArray[np.float64], active: NDArray[np.bool_]) -> "SmoothTracks":
        """Tracks with variances of the curves estimated from the modes present in every sweep.

        Without this limit, a track may change over to a neighbouring mode where either is hidden.

        Parameters
        ----------
        place : (T, J, 2) ndarray
            Log |lambda| and log damping ratio, of a fit.
        active : (T, J) ndarray of bool
            Modes that take part in a sweep.
        """
        modes = self.own[:, 0, 1] == self.own[:, 0, 1].min(initial=np.inf)  # background poles have no such limit
        whole = modes & active.all(axis=0)
        if whole.sum() < FEWEST_TRACKS:
            return self
        curves = np.linalg.lstsq(self.basis, (place - self.base)[:, whole, 0], rcond=None)[0][1:]
        unlike = median_deviation(curves, axis=1)[:, 0]
        own = self.own.copy()
        own[modes, 1:, 0] = np.minimum(own[modes, 1:, 0], np.maximum(unlike, self.scatter[0]) ** 2)
        return replace(self, own=own)

    def with_damping_of(
        self, place: NDArray[np.float64], variance: NDArray[np.float64], active: NDArray[np.bool_]
    ) -> "SmoothTracks":
        """Tracks with the scatter of the modes' own damping ratios as a fit with wide tracks shows it.

        Every mode's departure from `base`, less what is common to all, is a Gaussian number of the scatter's
        deviation d plus the error of the fit, from which the wide prior is taken out again, see `scatter_of`.

        Parameters
        ----------
        place : (T, J, 2) ndarray
            Log |lambda| and log damping ratio, of the fit.
        variance : (T, J) ndarray
            Posterior variances of the log damping ratios.
        active : (T, J) ndarray of bool
            Modes that take part in a sweep.
        """
        prior = self.own[:, 0, 1]
        away = np.where(active, place[:, :, 1] - self.base[:, :, 1], np.nan)
        seen = active.any(axis=0)
        away, spread = away[:, seen], np.where(active, variance, np.nan)[:, seen]
        own = np.nanmean(away - np.nanmedian(away, axis=1, keepdims=True), axis=0)
        posterior = np.nanmean(spread, axis=0)
        known = 1.0 / posterior - 1.0 / prior[seen]  # precision that the sweeps add to the prior's
        told = known > 0.05 / prior[seen]  # of the others the fit returns the prior
        if not told.any():
            return self
        error, own = 1.0 / known[told], own[told] / (posterior[told] * known[told])
        deviation = scatter_of(own, error, SCATTERED)
        slope = deviation * OWN_DAMPING[1] / OWN_DAMPING[0]
        changed = self.own.copy()
        changed[:, : min(2, self.own.shape[1]), 1] = np.square((deviation, slope))[: self.own.shape[1]]
        return replace(self, own=changed)

    def one_more(self) -> "SmoothTracks":
        """Tracks with one more mode, with the prior of any mode of the plate."""
        like = int(np.argmin(self.own[:, 0, 1]))
        base = np.concatenate([self.base, np.zeros_like(self.base[:, :1])], axis=1)
        return replace(self, base=base, own=np.concatenate([self.own, self.own[[like]]]))

    @property
    def count(self) -> int:
        """Number of parameters of common parts and curves."""
        return 2 * len(self.basis) + self.own.size

    @cached_property
    def prior_precision(self) -> NDArray[np.float64]:
        """One over the prior variances of these numbers, (count,)."""
        common = np.full(2 * len(self.basis), 1.0 / VARIANCE_OF_UNKNOWN)
        return np.concatenate([common, 1.0 / self.own.ravel()])

    def place(self, numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Poles on the curves, (T, J, 2)."""
        common, own = self._parts(numbers)
        place: NDArray[np.float64] = self.base + common[:, None, :] + np.einsum("tq,jqp->tjp", self.basis, own)
        return place

    def moves(self, matrices: NDArray[np.float64]) -> NDArray[np.float64]:
        """Multiply matrices (T, N, 2J) by the derivatives of all poles by the numbers: (T, N, count)."""
        sweeps, rows = matrices.shape[:2]
        apart = matrices.reshape(sweeps, rows, len(self.own), 2)
        moves = np.zeros((sweeps, rows, self.count))
        common = moves[:, :, : 2 * sweeps].reshape(sweeps, rows, sweeps, 2)
        each = np.arange(sweeps)
        common[each, :, each] = apart.sum(axis=2)
        curves = apart[:, :, :, None, :] * self.basis[:, None, None, :, None]
        moves[:, :, 2 * sweeps :] = curves.reshape(sweeps, rows, self.own.size)
        return moves

    def gathered(self, gradient: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient (count,) by the numbers, from that by the poles' parameters, (T, J, 2)."""
        return np.concatenate(
            [gradient.sum(axis=1).ravel(), np.einsum("tq,tjp->jqp", self.basis, gradient).ravel()]
        )

    def information(self, hessian: NDArray[np.float64]) -> NDArray[np.float64]:
        """Hessian (count, count) by the numbers, from that by the poles' parameters, (T, 2J, 2J).

        Every pole depends only on its sweep's common part and its mode's own curve, so a few sums suffice.
        """
        sweeps, degree = self.basis.shape
        modes, first = len(self.own), 2 * sweeps
        hessian = hessian.reshape(sweeps, modes, 2, modes, 2)
        found = np.zeros((self.count, self.count))
        common = found[:first, :first].reshape(sweeps, 2, sweeps, 2)
        each = np.arange(sweeps)
        common[each, :, each] = hessian.sum(axis=(1, 3))
        cross = hessian.sum(axis=1)[:, :, :, None, :] * self.basis[:, None, None, :, None]
        found[:first, first:] = cross.reshape(first, self.own.size)
        found[first:, :first] = found[:first, first:].T
        pairs = (self.basis[:, :, None] * self.basis[:, None, :]).reshape(sweeps, degree**2)
        curves = (pairs.T @ hessian.reshape(sweeps, 4 * modes**2)).reshape(degree, degree, modes, 2, modes, 2)
        found[first:, first:] = curves.transpose(2, 0, 3, 4, 1, 5).reshape(self.own.size, self.own.size)
        return found

    def _parts(self, numbers: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return common parts (T, 2) and coefficients (J, P, 2)."""
        first = 2 * len(self.basis)
        return numbers[:first].reshape(-1, 2), numbers[first:].reshape(self.own.shape)
