"""Schur complement of the normal equations of all sweeps.

Laws and their slopes belong to a group of sweeps, temperatures to a sweep, gains and effects to the campaign:
eliminating group by group leaves a small matrix for gains and effects, in which each effect keeps only the part
that is independent of laws and readings. A reading error common to all sweeps of a group is equivalent to a change
of the laws at the group's mean reading; so only contrasts of the errors are unknowns.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, helmert

from analysis.arrays import Mask, Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.normal_equations import GLOBAL, LAWS, SLOPES, TEMPERATURE, SweepEquations
from analysis.gap.fitting.state import GapState

OWN = 6
"""Unknowns of every group: three laws and their slopes; contrasts of its readings follow."""
RIDGE = 1e-12
"""Ridge relative to a unit diagonal, for material constants that no line depends on."""


@dataclass(frozen=True)
class Block:
    """Elimination of one group's unknowns, with what is needed to compute them later.

    Attributes
    ----------
    members : (m,) int ndarray
        Its sweeps.
    contrasts : (m, m - 1) ndarray
        Orthonormal contrasts of its readings.
    lever : (q, I + P) ndarray
        Minus the derivative of its unknowns with respect to gains and effects.
    own : (q,) ndarray
        Their step at fixed gains and effects.
    variance : (q,) ndarray
        At fixed gains and effects.
    """

    members: NDArray[np.int_]
    contrasts: Real
    lever: Real
    own: Real
    variance: Real


@dataclass(frozen=True)
class LocalStep:
    """Steps of laws (G, 3), of slopes (G, 3) in their standard deviations, and of temperatures (T,)."""

    laws: Real
    tilt: Real
    away: Real

    def times(self, share: float) -> "LocalStep":
        """Return the steps scaled by `share`."""
        return LocalStep(share * self.laws, share * self.tilt, share * self.away)


@dataclass(frozen=True)
class WithoutGains:
    """Normal equations of the effects' parameters, with log gains eliminated.

    Attributes
    ----------
    matrix : (P, P) ndarray
        For the effects' parameters.
    gradient : (P,) ndarray
    covariance : (I, I) ndarray
        Of the log gains at fixed parameters; 0 for those held.
    lever : (I, P) ndarray
        Minus the derivative of the log gains with respect to the parameters.
    """

    matrix: Real
    gradient: Real
    covariance: Real
    lever: Real


@dataclass(frozen=True)
class SchurComplement:
    """Normal equations of all sweeps, with laws and temperatures eliminated.

    Attributes
    ----------
    gains : int
        Number I of inputs.
    matrix : (I + P, I + P) ndarray
        Schur complement for the log gains and the effects' parameters.
    gradient : (I + P,) ndarray
    raw : (I + P, I + P) ndarray
        `matrix` before the elimination: the size of each column.
    predicted_decrease : float
        Predicted decrease of chi2 by the eliminated unknowns alone.
    blocks : tuple of Block
    """

    gains: int
    matrix: Real
    gradient: Real
    raw: Real
    predicted_decrease: float
    blocks: tuple[Block, ...] = field(repr=False)

    def follow(self, step: Real, sweeps: int) -> LocalStep:
        """Return the steps of the eliminated unknowns for a `step` (I + P,) of gains and effects."""
        local = [block.own - block.lever @ step for block in self.blocks]
        away = np.zeros(sweeps)
        for block, steps in zip(self.blocks, local, strict=True):
            if len(steps) > OWN:
                away[block.members] = block.contrasts @ steps[OWN:]
        return LocalStep(np.array([x[LAWS] for x in local]), np.array([x[SLOPES] for x in local]), away)

    @property
    def seen(self) -> Mask:
        """Which gains the sweeps determine: those of inputs that drove one of them, (I,)."""
        found: Mask = np.diag(self.raw)[: self.gains] > 0.0
        return found

    def without_gains(self, free: bool = True) -> "WithoutGains":
        """Eliminate the log gains, or hold them; those of inputs that drove no sweep are held."""
        count, moving = self.gains, self.seen & free
        covariance = np.zeros((count, count))
        covariance[np.ix_(moving, moving)] = np.linalg.inv(self.matrix[:count, :count][np.ix_(moving, moving)])
        lever = covariance @ self.matrix[:count, count:]
        left = self.matrix[count:, count:] - self.matrix[count:, :count] @ lever
        gradient = self.gradient[count:] - lever.T @ self.gradient[:count]
        return WithoutGains(0.5 * (left + left.T), gradient, covariance, lever)

    def law_sigma(self, joint: Real) -> Real:
        """Return standard deviations (G, 3) of the laws when gains and effects have covariance `joint`."""
        variance = [b.variance[LAWS] + ((b.lever[LAWS] @ joint) * b.lever[LAWS]).sum(1) for b in self.blocks]
        sigma: Real = np.sqrt(np.array(variance))
        return sigma


def schur_complement(
    sweeps: GapSweeps,
    equations: Sequence[SweepEquations],
    state: GapState,
    *,
    damping: float = 0.0,
    frozen: bool = False,
    readings: bool = True,
) -> SchurComplement:
    """Eliminate laws, slopes and readings of every group.

    Parameters
    ----------
    sweeps : GapSweeps
    equations : sequence of SweepEquations
        One per sweep, at `state`.
    state : GapState
    damping : float
        Levenberg-Marquardt damping on the diagonals of the groups' blocks.
    frozen : bool
        Whether laws and temperatures are held: nothing is eliminated.
    readings : bool
        If False, temperatures and slopes are taken as known: only laws are eliminated.

    Returns
    -------
    SchurComplement
    """
    size = len(equations[0].gradient) - GLOBAL
    matrix = sum((e.matrix[GLOBAL:, GLOBAL:] for e in equations), np.zeros((size, size)))
    gradient = sum((e.gradient[GLOBAL:] for e in equations), np.zeros(size))
    raw, predicted_decrease, blocks = matrix, 0.0, []
    for group, tilt in enumerate(state.tilt):
        members = np.flatnonzero(sweeps.groups.of_sweep == group)
        mine = [equations[int(s)] for s in members]
        contrasts = helmert(len(members)).T if len(members) > 1 else np.zeros((1, 0))
        local, coupling, pull = _group(mine, contrasts, state.away[members], tilt, sweeps.reading_sigma)
        if frozen:
            blocks.append(Block(members, contrasts, 0.0 * coupling, 0.0 * pull, 0.0 * pull))
            continue
        if not readings:
            local[OWN:] = local[:, OWN:] = local[SLOPES] = local[:, SLOPES] = 0.0
            coupling[OWN:] = coupling[SLOPES] = 0.0
            local += np.diag((np.diag(local) == 0.0).astype(float))
        scale = 1.0 / np.sqrt(np.maximum(np.diag(local), 1e-300))
        unit = local * scale[:, None] * scale + (RIDGE + damping) * np.eye(len(local))
        factor = cho_factor(unit)
        solved = scale[:, None] * cho_solve(factor, scale[:, None] * np.column_stack([coupling, pull]))
        lever, own = solved[:, :-1], solved[:, -1]
        matrix = matrix - coupling.T @ lever
        gradient = gradient - coupling.T @ own
        predicted_decrease += float(pull @ own)
        variance = scale**2 * np.diag(cho_solve(factor, np.eye(len(local))))
        blocks.append(Block(members, contrasts, lever, own, variance))
    return SchurComplement(
        len(state.log_gain), 0.5 * (matrix + matrix.T), gradient, raw, predicted_decrease, tuple(blocks)
    )


def _group(
    equations: Sequence[SweepEquations], contrasts: Real, away: Real, tilt: Real, reading_sigma: float
) -> tuple[Real, Real, Real]:
    """Return matrix of a group's own unknowns, their coupling to the common ones, and their gradient."""
    size = OWN + contrasts.shape[1]
    local, pull = np.zeros((size, size)), np.zeros(size)
    coupling = np.zeros((size, len(equations[0].gradient) - GLOBAL))
    for e, row in zip(equations, contrasts, strict=True):
        spread = np.zeros((GLOBAL, size))
        spread[:OWN, :OWN] = np.eye(OWN)
        spread[TEMPERATURE, OWN:] = row
        local += spread.T @ e.matrix[:GLOBAL, :GLOBAL] @ spread
        coupling += spread.T @ e.matrix[:GLOBAL, GLOBAL:]
        pull += spread.T @ e.gradient[:GLOBAL]
    local[SLOPES, SLOPES] += np.eye(3)
    pull[SLOPES] -= tilt
    local[OWN:, OWN:] += np.eye(size - OWN) / reading_sigma**2
    pull[OWN:] -= contrasts.T @ away / reading_sigma**2
    return local, coupling, pull
