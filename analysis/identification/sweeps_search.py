"""Misfit and derivatives of all sweeps at given poles, and the Gauss-Newton step of poles and tracks."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from analysis.identification.lines import Lines
from analysis.identification.parameters import to_poles
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.variable_projection import Projection, project


@dataclass
class SweepsAt:
    """Misfit, gradient and Hessian of every sweep with its poles at x (T, J, 2), in variances of one number."""

    x: NDArray[np.float64]
    projections: list[Projection]
    misfit: NDArray[np.float64]
    gradient: NDArray[np.float64]
    hessian: NDArray[np.float64]

    def moved(self, other: "SweepsAt", sweeps: NDArray[np.bool_]) -> "SweepsAt":
        """Copy with some sweeps (T,) replaced by those of another point."""
        one, two = sweeps[:, None], sweeps[:, None, None]
        return SweepsAt(
            np.where(two, other.x, self.x),
            [
                new if yes else old
                for old, new, yes in zip(self.projections, other.projections, sweeps, strict=True)
            ],
            np.where(sweeps, other.misfit, self.misfit),
            np.where(one, other.gradient, self.gradient),
            np.where(two, other.hessian, self.hessian),
        )


@dataclass
class SweepsSearch:
    """Sweeps, the prior of their tracks, and projections evaluated before, one per sweep, or none."""

    lines: Sequence[Lines]
    terms: Sequence[ResidualTerms]
    active: NDArray[np.bool_]
    tracks: SmoothTracks
    known: Sequence[Projection] = ()

    def at(self, x: NDArray[np.float64], sweeps: NDArray[np.bool_], before: SweepsAt | None = None) -> SweepsAt:
        """Evaluate some sweeps at their poles (J, 2); the others are taken from `before`.

        Parameters
        ----------
        x : (T, J, 2) ndarray
            Log |lambda| and log damping ratio.
        sweeps : (T,) ndarray of bool
        """
        count, modes = self.active.shape
        misfit, gradient = np.zeros(count), np.zeros((count, 2 * modes))
        hessian, projections = np.zeros((count, 2 * modes, 2 * modes)), list(before.projections) if before else []
        for t in np.flatnonzero(sweeps).tolist():
            now = self._projected(t, x[t])
            own, error = np.flatnonzero(np.repeat(self.active[t], 2)), 0.5 * self.lines[t].redundancy
            gradient[t, own] = now.gradient / error
            hessian[t][np.ix_(own, own)] = now.hessian / error
            misfit[t] = now.misfit / error
            projections[t : t + 1] = [now]
        here = SweepsAt(x, projections, misfit, gradient, hessian)
        return here if before is None else before.moved(here, sweeps)

    def _projected(self, sweep: int, x: NDArray[np.float64]) -> Projection:
        """Projection of a sweep at its poles (J, 2), evaluated unless known already."""
        poles = to_poles(x[self.active[sweep]])
        for known in self.known[sweep : sweep + 1]:
            if np.array_equal(known.poles, poles):
                return known
        return project(self.lines[sweep], poles, self.terms[sweep])

    @property
    def precision(self) -> NDArray[np.float64]:
        """One over the variance of each of a sweep's parameters (2J,) about its track."""
        return np.tile(self.tracks.scatter**-2.0, self.active.shape[1])

    def departure(self, x: NDArray[np.float64], numbers: NDArray[np.float64]) -> NDArray[np.float64]:
        """Squared distance of every sweep's poles from the tracks, (T,), in standard deviations."""
        away = (x - self.tracks.place(numbers)) / self.tracks.scatter
        squared: NDArray[np.float64] = ((away * self.active[:, :, None]) ** 2).sum(axis=(1, 2))
        return squared

    def total(self, point: SweepsAt, numbers: NDArray[np.float64]) -> float:
        """Sum of misfits, squared distances of poles from the tracks, and of the tracks from their prior."""
        known = self.tracks.prior_precision * numbers**2
        return float(point.misfit.sum() + self.departure(point.x, numbers).sum() + known.sum())

    def nearest(
        self, x: NDArray[np.float64], numbers: NDArray[np.float64], scatter: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Parameters of the tracks that fit the active poles best, starting from given ones.

        Parameters
        ----------
        x : (T, J, 2) ndarray
            Log |lambda| and log damping ratio.
        numbers : (count,) ndarray
        scatter : (2,) ndarray
            Standard deviations about the tracks.

        Returns
        -------
        (count,) ndarray
        """
        weight = self.active[:, :, None] / scatter**2
        outer = self._nearness.get(scatter.tobytes())
        if outer is None:
            hessian = weight.reshape(len(x), -1, 1) * np.eye(x.shape[1] * 2)
            outer = cho_factor(self.tracks.information(hessian) + np.diag(self.tracks.prior_precision))
            self._nearness[scatter.tobytes()] = outer
        slope = (
            self.tracks.gathered(weight * (x - self.tracks.place(numbers))) - self.tracks.prior_precision * numbers
        )
        return numbers + np.asarray(cho_solve(outer, slope), dtype=np.float64)

    @cached_property
    def _nearness(self) -> dict[bytes, tuple[NDArray[np.float64], bool]]:
        """Cached factors of the equations for the nearest tracks, by the scatter about them."""
        return {}

    def curvature(
        self, point: SweepsAt, damping: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Inverse Hessians of the poles (T, 2J, 2J), their Schur complements, and the Hessian of the tracks."""
        precision, unit = self.precision, np.eye(len(self.precision))
        damped = precision + damping[:, None] * np.einsum("tii->ti", point.hessian)
        inverse = np.linalg.inv(point.hessian + unit * damped[:, None, :])
        schur = unit * precision - precision[:, None] * inverse * precision
        return inverse, schur, self.tracks.information(schur) + np.diag(self.tracks.prior_precision)

    def step(
        self, point: SweepsAt, numbers: NDArray[np.float64], damping: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Gauss-Newton step (T, J, 2) of the poles, with the tracks moved as well.

        Parameters
        ----------
        numbers : (count,) ndarray
            Of the tracks.
        damping : (T,) ndarray
            Share of every second derivative that is added to it.

        Returns
        -------
        (T, J, 2) ndarray
        """
        inverse, schur, outer = self.curvature(point, damping)
        precision, shape = self.precision, point.x.shape
        away = (self.tracks.place(numbers) - point.x).reshape(len(schur), -1)
        gradient = np.einsum("tij,tj->ti", schur, away) + precision * np.einsum(
            "tij,tj->ti", inverse, point.gradient
        )
        slope = self.tracks.gathered(gradient.reshape(shape)) + self.tracks.prior_precision * numbers
        further = numbers - np.linalg.solve(outer, slope)
        moved = precision * (self.tracks.place(further) - point.x).reshape(len(schur), -1) - point.gradient
        step: NDArray[np.float64] = np.einsum("tij,tj->ti", inverse, moved).reshape(shape)
        return step
