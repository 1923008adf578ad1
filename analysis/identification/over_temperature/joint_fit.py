"""Joint fit of all sweeps of a campaign, with poles held near tracks that are smooth in temperature.

Where damping is high, one FRF cannot distinguish two modes from one between them; sweeps with less damping can. So
the poles of all sweeps and the parameters of their tracks are found jointly, by Gauss-Newton steps on the log
posterior with the residues eliminated in each sweep. Its Hessian gives the standard deviations, including the
correlation with neighbouring modes and with the tracks.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from analysis.identification.lines import Lines
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.pole_residue import LARGEST_DAMPING, ResidualTerms, to_poles
from analysis.identification.pole_search import PREDICTED_FALL_FACTOR, Projection, project

SETTLED_FALL = 0.1
"""Fall of a sweep's sum of squares, in variances of one number, below which it is not evaluated again."""

LEAST_DAMPING = 1e-5
"""Smallest damping of a step, as a share of every second derivative: badly determined poles would move far."""

MOST_DAMPING = 1e3
"""Damping of a step at which the search stops."""

MOST_STEPS = 25
"""Bound of the cost, for a search that does not reach `MOST_DAMPING` before."""

LARGEST_POLE_STEP = 3.0
"""Largest step of a pole, in half widths."""


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


@dataclass(frozen=True)
class JointFit:
    """Outcome of the fit of all sweeps.

    Attributes
    ----------
    place : (T, J, 2) ndarray
        Log |lambda| and log damping ratio, on the curves where a mode takes no part in a sweep.
    projections : tuple of Projection
        Residues and misfit of every sweep at its final poles.
    active : (T, J) ndarray of bool
        Which modes take part.
    search : SweepsSearch
        What was searched.
    hidden : (T, J, 2, 2) ndarray or float
        What hidden modes add to the covariance.
    """

    place: NDArray[np.float64]
    projections: tuple[Projection, ...]
    active: NDArray[np.bool_]
    search: SweepsSearch
    hidden: NDArray[np.float64] | float = 0.0

    @cached_property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of every pole's log |lambda| and log damping ratio, (T, J, 2, 2)."""
        every = np.ones(len(self.projections), dtype=bool)
        return _covariance(self.search, self.search.at(self.place, every)) + self.hidden

    @property
    def loss(self) -> NDArray[np.float64]:
        """Rise of each sweep's misfit without each mode, all else held, (T, J)."""
        loss = np.zeros(self.active.shape)
        for t, projection in enumerate(self.projections):
            loss[t, self.active[t]] = projection.loss
        return loss


def fit_together(
    lines: Sequence[Lines],
    terms: Sequence[ResidualTerms],
    start: NDArray[np.float64],
    active: NDArray[np.bool_],
    tracks: SmoothTracks,
    *,
    settled: float = SETTLED_FALL,
    most: int = MOST_STEPS,
    target: float | None = None,
    known: Sequence[Projection] = (),
) -> JointFit:
    """Fit poles of all sweeps and their tracks.

    Parameters
    ----------
    lines : sequence of Lines
        T sweeps.
    terms : sequence of ResidualTerms
        Of each.
    start : (T, J, 2) ndarray
        Log |lambda| and log damping ratio to start from.
    active : (T, J) ndarray of bool
        Modes that take part in a sweep; the others are placed on their tracks.
    settled : float
        Fall of the sum of squares, in units of one number's variance, at which to stop.
    most : int
        Steps at most.
    target : float, optional
        Stop once the Gauss-Newton model predicts no sum of squares as low as this, in variances of one number.
    known : sequence of Projection
        Of the same lines and terms, one per sweep: used instead of a new evaluation where the poles are equal.
    """
    search = SweepsSearch(lines, terms, active, tracks, known)
    now, numbers = _first_point(search, start)
    total, damping = search.total(now, numbers), np.full(len(lines), 1e-3)
    converged = np.zeros(len(lines), dtype=bool)
    for _ in range(most):
        step = search.step(now, numbers, damping)
        share = 1.0 / (np.abs(step) / _farthest(now.x) * active[:, :, None]).max(axis=(1, 2), initial=1.0)
        moving = ~converged & (_squared_size(step, now, search.precision) > settled)
        if not moving.any() or (target is not None and _predicted(step, now) > target):
            break
        ahead = now.x + np.where(moving, share, 0.0)[:, None, None] * step
        ahead[:, :, 1] = np.minimum(ahead[:, :, 1], np.log(LARGEST_DAMPING))
        trial, further, better = _improved(search, now, numbers, ahead, moving)
        fall = total - search.total(trial, further)
        better &= fall > 0.0
        damping = np.where(better, damping / 10.0, np.where(moving, np.maximum(10.0 * damping, 1e-3), damping))
        damping = np.maximum(damping, LEAST_DAMPING)
        if better.any():
            now, numbers, total = trial, further, total - fall
        if damping[moving].min() > MOST_DAMPING:
            break
        # sweeps that have converged are not moved while others repeat a rejected step
        small = fall < settled * len(lines) and (share[moving] == 1.0).all()
        converged = converged | better if small else np.zeros(len(lines), dtype=bool)
    return JointFit(now.x, tuple(now.projections), active, replace(search, known=tuple(now.projections)))


def _first_point(search: SweepsSearch, start: NDArray[np.float64]) -> tuple[SweepsAt, NDArray[np.float64]]:
    """All sweeps at the start (T, J, 2), inactive modes on their tracks, and the tracks' parameters (count,)."""
    active, tracks = search.active[:, :, None], search.tracks
    wide = np.maximum(tracks.scatter, 1e-3)
    numbers = search.nearest(np.where(active, start, tracks.base), np.zeros(tracks.count), wide)
    point = search.at(np.where(active, start, tracks.place(numbers)), np.ones(len(start), dtype=bool))
    return point, search.nearest(point.x, numbers, tracks.scatter)


def _improved(
    search: SweepsSearch,
    now: SweepsAt,
    numbers: NDArray[np.float64],
    ahead: NDArray[np.float64],
    moving: NDArray[np.bool_],
) -> tuple[SweepsAt, NDArray[np.float64], NDArray[np.bool_]]:
    """Move the sweeps whose own misfit falls to `ahead` (T, J, 2).

    Returns the point, its tracks' parameters (count,), and which of the `moving` sweeps (T,) were moved.
    """
    tracks = search.tracks
    trial = search.at(ahead, moving, now)
    further = search.nearest(ahead, numbers, tracks.scatter)
    rise = trial.misfit + search.departure(ahead, further) - now.misfit - search.departure(now.x, further)
    better = moving & (rise <= 0.0)
    mixed = now.moved(trial, better)
    further = search.nearest(mixed.x, numbers, tracks.scatter)
    mixed.x = np.where(search.active[:, :, None], mixed.x, tracks.place(further))
    return mixed, further, better


def _farthest(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Largest step of poles (T, J, 2)."""
    return np.stack([np.maximum(LARGEST_POLE_STEP * np.exp(x[:, :, 1]), 1e-5), np.ones(x.shape[:2])], axis=2)


def _squared_size(
    step: NDArray[np.float64], point: SweepsAt, precision: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Squared size of every sweep's step, in standard deviations of its poles, (T,)."""
    flat = step.reshape(len(step), -1)
    size: NDArray[np.float64] = np.einsum("ti,tij,tj->t", flat, point.hessian, flat)
    size += (precision * flat**2).sum(axis=1)
    return size


def _predicted(step: NDArray[np.float64], point: SweepsAt) -> float:
    """Sum of squares after a step if it falls by `PREDICTED_FALL_FACTOR` times what the model predicts."""
    flat = step.reshape(len(step), -1)
    bent = np.einsum("ti,tij,tj->", flat, point.hessian, flat)
    return float(point.misfit.sum() + PREDICTED_FALL_FACTOR * min(2.0 * (flat * point.gradient).sum() + bent, 0.0))


def _covariance(search: SweepsSearch, point: SweepsAt) -> NDArray[np.float64]:
    """Posterior covariance of every pole, (T, J, 2, 2)."""
    inverse, _, outer = search.curvature(point, np.zeros(len(point.x)))
    follow = search.tracks.moves(inverse * search.precision)
    # only the 2 x 2 block of each pole, with the covariance of the tracks' parameters propagated to it
    rows = follow.reshape(*point.x.shape, search.tracks.count)
    known = np.linalg.inv(outer)
    modes = np.arange(point.x.shape[1])
    own = inverse.reshape(*point.x.shape, *point.x.shape[1:])[:, modes, :, modes, :].transpose(1, 0, 2, 3)
    spread: NDArray[np.float64] = own + (rows @ known) @ rows.swapaxes(-1, -2)
    return spread
