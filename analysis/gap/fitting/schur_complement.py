"""Schur complement of the normal equations of all sweeps.

Laws belong to a group of sweeps, temperatures to a sweep, gains and effects to the campaign: eliminating laws and
temperatures leaves a small matrix for gains and effects, in which each effect keeps only the part that is
independent of laws and readings. The laws' derivatives follow from the values at all temperatures, up to errors
that are unknowns too, see `LawSmoothness`. A reading error common to all sweeps of a group is equivalent to a
change of the laws at the group's mean reading; so only contrasts of the errors are unknowns.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_factor, cho_solve, helmert

from analysis.arrays import Mask, Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.normal_equations import GLOBAL, LAWS, TEMPERATURE, SweepEquations
from analysis.gap.fitting.state import GapState

RIDGE = 1e-12
"""Ridge relative to a unit diagonal, for material constants that no line depends on."""


@dataclass(frozen=True)
class LocalStep:
    """Steps of laws (G, 3), of errors of their derivatives as in `LawSmoothness`, and of temperatures (T,)."""

    laws: Real
    errors: Real
    away: Real

    @classmethod
    def of(cls, local: Real, columns: Real, groups: int) -> "LocalStep":
        """Split a step (N,) of the unknowns of `law_columns`."""
        laws, errors, _ = np.split(local, [3 * groups, len(local) - (len(columns) - groups)])
        return cls(laws.reshape(-1, 3), errors, columns[:, TEMPERATURE] @ local)

    def times(self, share: float) -> "LocalStep":
        """Return the steps scaled by `share`."""
        return LocalStep(share * self.laws, share * self.errors, share * self.away)


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

    def joint(self, parameters: Real) -> Real:
        """Covariance of log gains and parameters (I + P, I + P), when the latter's is `parameters`."""
        across = -self.lever @ parameters
        return np.block([[self.covariance - across @ self.lever.T, across], [across.T, parameters]])


@dataclass(frozen=True)
class SchurComplement:
    """Normal equations of all sweeps, with laws and temperatures eliminated.

    Attributes
    ----------
    gains, groups : int
        Number I of inputs, and number G of groups.
    matrix : (I + P, I + P) ndarray
        Schur complement for the log gains and the effects' parameters.
    gradient : (I + P,) ndarray
    raw : (I + P, I + P) ndarray
        `matrix` before the elimination: the size of each column.
    predicted_decrease : float
        Predicted decrease of chi2 by the eliminated unknowns alone.
    columns : (T, 10, N) ndarray
        Derivative of each sweep's own columns, of `SweepEquations`, by the eliminated unknowns: the laws of every
        group, the errors of their derivatives, and orthonormal contrasts of the readings of each group.
    lever : (N, I + P) ndarray
        Minus the derivative of the eliminated unknowns with respect to gains and effects; zero for those that are
        held.
    own : (N,) ndarray
        Their step at fixed gains and effects.
    variance : (N,) ndarray
        At fixed gains and effects.
    within : (G, 3, 3) ndarray
        Covariance of each group's laws, likewise.
    """

    gains: int
    groups: int
    matrix: Real
    gradient: Real
    raw: Real
    predicted_decrease: float
    columns: Real = field(repr=False)
    lever: Real = field(repr=False)
    own: Real = field(repr=False)
    variance: Real = field(repr=False)
    within: Real = field(repr=False)

    def follow(self, step: Real) -> Real:
        """Return the step (N,) of the eliminated unknowns for a `step` (I + P,) of gains and effects."""
        return np.asarray(self.own - self.lever @ step)

    def parts(self, local: Real) -> LocalStep:
        """Split a step (N,) of the eliminated unknowns."""
        return LocalStep.of(local, self.columns, self.groups)

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

    @property
    def law_lever(self) -> Real:
        """Minus the derivative of the laws by gains and parameters, (3G, I + P)."""
        return self.lever[: 3 * self.groups]

    def law_sigma(self, joint: Real) -> Real:
        """Return standard deviations (G, 3) of the laws when gains and effects have covariance `joint`."""
        lever = self.law_lever
        variance = self.variance[: 3 * self.groups] + ((lever @ joint) * lever).sum(axis=1)
        return np.asarray(np.sqrt(variance)).reshape(-1, 3)

    def law_covariance(self, joint: Real) -> Real:
        """Return the covariance (G, 3, 3) of each group's laws when gains and effects have covariance `joint`."""
        lever = self.law_lever.reshape(self.groups, 3, len(joint))
        return np.asarray(self.within + lever @ joint @ lever.transpose(0, 2, 1))


def schur_complement(
    sweeps: GapSweeps,
    equations: Sequence[SweepEquations],
    state: GapState,
    *,
    weight: float = 1.0,
    damping: float = 0.0,
    frozen: bool = False,
    readings: bool = True,
) -> SchurComplement:
    """Eliminate the laws with their derivatives, and the readings.

    Parameters
    ----------
    sweeps : GapSweeps
    equations : sequence of SweepEquations
        One per sweep, at `state`.
    state : GapState
    weight : float
        Of the data against the priors: less than 1 if their errors are larger than stated.
    damping : float
        Levenberg-Marquardt damping on the diagonal of the eliminated unknowns.
    frozen : bool
        Whether laws and temperatures are held: nothing is eliminated.
    readings : bool
        If False, temperatures and the laws' derivatives, given their values, are taken as known: only laws are
        eliminated.

    Returns
    -------
    SchurComplement
    """
    columns = law_columns(sweeps, state)
    data = weight * np.array([e.matrix for e in equations])
    pulls = weight * np.array([e.gradient for e in equations])
    every = columns.reshape(-1, columns.shape[2]).T
    matrix = every @ (data[:, :GLOBAL, :GLOBAL] @ columns).reshape(every.T.shape)
    coupling = every @ data[:, :GLOBAL, GLOBAL:].reshape(every.shape[1], -1)
    gradient = every @ pulls[:, :GLOBAL].ravel()
    raw, direct = data[:, GLOBAL:, GLOBAL:].sum(axis=0), pulls[:, GLOBAL:].sum(axis=0)
    values = 3 * len(sweeps.groups.size)
    now, precision = local_priors(sweeps, state, columns)
    moving = 0 if frozen else len(precision) if readings else values
    local, pull = (matrix + np.diag(precision))[:moving, :moving], (gradient - precision * now)[:moving]
    coupling = coupling[:moving]
    scale = 1.0 / np.sqrt(np.maximum(np.diag(local), 1e-300))
    unit = local * scale[:, None] * scale + (RIDGE + damping) * np.eye(moving)
    known = scale[:, None] * np.column_stack([coupling, pull, np.eye(moving)])
    solved = scale[:, None] * cho_solve(cho_factor(unit), known) if moving else known
    common = len(direct)
    lever, own_step = solved[:, :common], solved[:, common]
    left = raw - coupling.T @ lever
    held = len(precision) - moving
    return SchurComplement(
        gains=len(state.log_gain),
        groups=len(sweeps.groups.size),
        matrix=0.5 * (left + left.T),
        gradient=direct - coupling.T @ own_step,
        raw=raw,
        predicted_decrease=float(pull @ own_step),
        columns=columns,
        lever=np.pad(lever, ((0, held), (0, 0))),
        own=np.pad(own_step, (0, held)),
        variance=np.pad(np.diag(solved[:, common + 1 :]), (0, held)),
        within=np.zeros((values // 3, 3, 3)) if frozen else _blocks(solved[:values, common + 1 :]),
    )


def local_priors(sweeps: GapSweeps, state: GapState, columns: Real) -> tuple[Real, Real]:
    """Values and inverse prior variances of the unknowns of `law_columns`, (N,) each.

    The laws have none, the errors of their derivatives are standard normal, those of the readings have one sigma.
    """
    values, errors = 3 * len(sweeps.groups.size), sweeps.smoothness.errors(state.tilt, state.bend)
    contrasts = columns[:, TEMPERATURE, values + errors.size :]
    now = np.concatenate([np.zeros(values), errors, contrasts.T @ state.away])
    precision = np.repeat([0.0, 1.0, sweeps.reading_sigma**-2], [values, errors.size, contrasts.shape[1]])
    return now, precision


def _blocks(covariance: Real) -> Real:
    """Blocks (G, 3, 3) on the diagonal of (3G, N)."""
    return np.array([covariance[k : k + 3, k : k + 3] for k in range(0, len(covariance), 3)]).reshape(-1, 3, 3)


def law_columns(sweeps: GapSweeps, state: GapState) -> Real:
    """Differentiate each sweep's own columns by the unknowns of temperatures and sweeps, (T, 10, N)."""
    groups, smoothness = sweeps.groups, sweeps.smoothness
    laws, contrasts = 3 * len(groups.size) + smoothness.unknowns, sweeps.count - len(groups.size)
    found = np.zeros((sweeps.count, GLOBAL, laws + contrasts))
    for sweep, (group, point) in enumerate(zip(groups.of_sweep, sweeps.points, strict=True)):
        temperature = state.circumstances(sweep, point).temperature
        found[sweep, LAWS, :laws] = smoothness.seen(group, temperature - groups.reference[group])
    first = laws
    for group, size in enumerate(groups.size):
        found[groups.of_sweep == group, TEMPERATURE, first : first + size - 1] = helmert(size).T
        first += size - 1
    return found
