"""All sweeps of a campaign fitted together, their poles held to tracks that are smooth in temperature.

Where damping is high, one FRF cannot tell two modes from one between them; sweeps of less damping can. So poles of
all sweeps, common parts and curves of their tracks are found together, residues eliminated sweep by sweep, by
Gauss-Newton steps on the posterior. Its Hessian gives the deviations, with neighbours and curves included.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.identification.lines import Lines
from analysis.identification.parameters import LARGEST_DAMPING, to_poles
from analysis.identification.residual_terms import ResidualTerms
from analysis.identification.smooth_tracks import SmoothTracks
from analysis.identification.variable_projection import Projection, project

SETTLED = 0.5
"""Fall of the misfit, in units of one line's, at which a fit of all sweeps stops."""

MOST_STEPS = 25

FARTHEST = 3.0
"""Half widths that a pole may move in one step."""


@dataclass(frozen=True)
class JointFit:
    """Outcome of the fit of all sweeps.

    Attributes
    ----------
    place : (T, J, 2) ndarray
        Log |lambda| and log damping ratio, on the curves where a mode takes no part in a sweep.
    covariance : (T, J, 2, 2) ndarray
        Of them.
    looks : tuple of Projection
        Every sweep's residues and misfit.
    active : (T, J) ndarray of bool
        Which modes take part.
    """

    place: NDArray[np.float64]
    covariance: NDArray[np.float64]
    looks: tuple[Projection, ...]
    active: NDArray[np.bool_]

    @property
    def loss(self) -> NDArray[np.float64]:
        """Rise of each sweep's misfit without each mode, all else held, (T, J)."""
        loss = np.zeros(self.active.shape)
        for t, look in enumerate(self.looks):
            loss[t, self.active[t]] = look.loss
        return loss


@dataclass
class _Search:
    """Sweeps at one point: misfit, gradient and Hessian of each by its poles, in units of one number's error."""

    lines: Sequence[Lines]
    terms: Sequence[ResidualTerms]
    active: NDArray[np.bool_]
    tracks: SmoothTracks
    error: NDArray[np.float64]

    def look(
        self, x: NDArray[np.float64]
    ) -> tuple[list[Projection], float, NDArray[np.float64], NDArray[np.float64]]:
        """Project every sweep at its poles (J, 2); also the sum of misfits, gradients and Hessians."""
        sweeps, modes = self.active.shape
        gradient, hessian = np.zeros((sweeps, 2 * modes)), np.zeros((sweeps, 2 * modes, 2 * modes))
        looks, total = [], 0.0
        for t, lines in enumerate(self.lines):
            now = project(lines, to_poles(x[t, self.active[t]]), self.terms[t])
            own = np.flatnonzero(np.repeat(self.active[t], 2))
            gradient[t, own] = now.gradient / self.error[t]
            hessian[t][np.ix_(own, own)] = now.hessian / self.error[t]
            total += now.misfit / self.error[t]
            looks.append(now)
        return looks, total, gradient, hessian

    def prior(self, x: NDArray[np.float64], numbers: NDArray[np.float64]) -> float:
        """Departure from the tracks, and of the tracks from what is known of them, in squared deviations."""
        away = (x - self.tracks.place(numbers)) / self.tracks.scatter
        return float((away**2).sum() + (self.tracks.certainty * numbers**2).sum())

    def solve(
        self,
        x: NDArray[np.float64],
        numbers: NDArray[np.float64],
        gradient: NDArray[np.float64],
        hessian: NDArray[np.float64],
        damping: float,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Gauss-Newton steps of poles and numbers; also the inverse matrices behind them."""
        design = self.tracks.design
        held = np.tile(self.tracks.scatter**-2.0, x.shape[1])
        inner = hessian + np.eye(len(held)) * (held + damping * np.einsum("tii->ti", hessian))[:, None, :]
        inverse = np.linalg.inv(inner)
        seen = np.eye(len(held)) * held - held[:, None] * inverse * held
        away = (self.tracks.place(numbers) - x).reshape(len(x), -1)
        pull = np.einsum("tij,tj->ti", seen, away) + held * np.einsum("tij,tj->ti", inverse, gradient)
        outer = np.diag(self.tracks.certainty)
        for t in range(len(x)):
            outer += design[t].T @ (seen[t] @ design[t])
        slope = np.einsum("tik,ti->k", design, pull) + self.tracks.certainty * numbers
        outer[np.diag_indices_from(outer)] *= 1.0 + damping
        step = -np.linalg.solve(outer, slope)
        moved = held * (away + design @ step) - gradient
        return np.einsum("tij,tj->ti", inverse, moved).reshape(x.shape), step, inverse, outer


def fit_together(
    lines: Sequence[Lines],
    terms: Sequence[ResidualTerms],
    start: NDArray[np.float64],
    active: NDArray[np.bool_],
    tracks: SmoothTracks,
    *,
    settled: float = SETTLED,
    most: int = MOST_STEPS,
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
        Modes that take part in a sweep; the others are where the tracks say.
    tracks : SmoothTracks
    settled : float
        Fall of the sum of squares, in units of one number's variance, at which to stop.
    most : int
        Steps at most.

    Returns
    -------
    JointFit
    """
    error = np.array([one.correlation * 0.5 for one in lines])
    search = _Search(lines, terms, active, tracks, error)
    x, numbers = _onto_tracks(start, active, tracks)
    looks, misfit, gradient, hessian = search.look(x)
    total, damping = misfit + search.prior(x, numbers), 1e-3
    for _ in range(most):
        dx, step, *_ = search.solve(x, numbers, gradient, hessian, damping)
        limit = np.stack([np.maximum(FARTHEST * np.exp(x[:, :, 1]), 1e-5), np.ones(active.shape)], axis=2)
        share = min(1.0, 1.0 / max(float(np.abs(dx / limit)[active].max(initial=0.0)), 1e-9))
        ahead, further = x + share * dx, numbers + share * step
        ahead[:, :, 1] = np.minimum(ahead[:, :, 1], np.log(LARGEST_DAMPING))
        ahead = np.where(active[:, :, None], ahead, tracks.place(further))
        trial = search.look(ahead)
        fall = total - (trial[1] + search.prior(ahead, further))
        if fall > 0.0:
            x, numbers, total = ahead, further, total - fall
            looks, misfit, gradient, hessian = trial
            damping = max(damping / 10.0, 1e-9)
            if fall < settled and share == 1.0:
                break
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e3:
                break
    return JointFit(x, _covariance(search, x, numbers, gradient, hessian), tuple(looks), active)


def _onto_tracks(
    start: NDArray[np.float64], active: NDArray[np.bool_], tracks: SmoothTracks
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Numbers of the tracks nearest to where the active poles are, and all poles on these tracks."""
    weight = np.repeat(active, 2, axis=1).astype(float) / np.tile(
        np.maximum(tracks.scatter, 1e-3) ** 2, active.shape[1]
    )
    wanted = (start - tracks.base).reshape(len(start), -1)
    outer, slope = np.diag(tracks.certainty), np.zeros(tracks.count)
    for design, w, y in zip(tracks.design, weight, wanted, strict=True):
        outer += (design.T * w) @ design
        slope += design.T @ (w * y)
    numbers = np.asarray(np.linalg.solve(outer, slope), dtype=np.float64)
    return tracks.place(numbers), numbers


def _covariance(
    search: _Search,
    x: NDArray[np.float64],
    numbers: NDArray[np.float64],
    gradient: NDArray[np.float64],
    hessian: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Posterior covariance of every pole, (T, J, 2, 2)."""
    *_, inverse, outer = search.solve(x, numbers, gradient, hessian, 0.0)
    known = np.linalg.inv(outer)
    held = np.tile(search.tracks.scatter**-2.0, x.shape[1])
    found = np.empty((*x.shape, 2))
    modes = np.arange(x.shape[1])
    for t, design in enumerate(search.tracks.design):
        follow = (inverse[t] * held) @ design
        spread = inverse[t] + follow @ known @ follow.T
        found[t] = spread.reshape(len(modes), 2, len(modes), 2)[modes, :, modes, :]
    return found
