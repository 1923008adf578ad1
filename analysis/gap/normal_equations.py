"""Whitened least squares of every sweep at one state, and the arrow they form together.

Columns of a sweep: log E, nu, log eta, the plate's temperature, log gain, then parameters of effects. Laws belong
to a group, temperatures to a sweep, the rest to the campaign: eliminating group by group leaves a small matrix for
gain and effects, in which each effect is only what laws and readings cannot imitate.
"""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from analysis.gap.model import GapModel, SweepPoint, Tangent
from analysis.gap.state import GapState
from analysis.gap.sweeps import GapSweeps
from analysis.local_laws import LocalLaws

Real = NDArray[np.float64]

LAWS, TEMPERATURE, GLOBAL = 3, 3, 4
"""Places of the columns: three laws, the plate's temperature, then what is common to the campaign."""
RIDGE = 1e-12
"""Of a unit diagonal: keeps a material constant that no line depends on from breaking the elimination."""


@dataclass(frozen=True)
class SweepEquations:
    """One sweep linearised.

    Attributes
    ----------
    matrix : (5 + P, 5 + P) ndarray
        J'J of the whitened columns.
    gradient : (5 + P,) ndarray
        J'r.
    residual : (K, n) complex ndarray
        Data less model in units of noise, real and imaginary part each; zero where left out.
    predicted : (K, n) complex ndarray
        Spline coefficients of the model, V/V.
    """

    matrix: Real
    gradient: Real
    residual: NDArray[np.complex128] = field(repr=False)
    predicted: NDArray[np.complex128] = field(repr=False)

    @property
    def chi2(self) -> float:
        """Sum of squares of the whitened residual."""
        return float((np.abs(self.residual) ** 2).sum())


def linearise_all(
    model: GapModel, sweeps: GapSweeps, state: GapState, tangents: Sequence[Tangent], executor: Executor
) -> list[SweepEquations]:
    """Linearise all sweeps at `state`, the parameters of effects being those of `tangents`."""
    laws = sweeps.groups.laws(state.laws)
    jobs = [
        executor.submit(_linearise, model, sweeps, s, laws[sweeps.groups.of_sweep[s]], state, tangents)
        for s in range(sweeps.count)
    ]
    try:
        return [job.result() for job in jobs]
    finally:
        for job in jobs:
            job.cancel()


def _linearise(
    model: GapModel, sweeps: GapSweeps, sweep: int, laws: LocalLaws, state: GapState, tangents: Sequence[Tangent]
) -> SweepEquations:
    point = sweeps.points[sweep]
    moved = SweepPoint(point.temperature + float(state.away[sweep]), point.rate, point.level)
    line = model.linearise(moved, laws, state.effects, sweeps.nodes.frequency, tangents)
    gain = float(np.exp(state.log_gain))
    values = np.concatenate([line.transfer[None], line.by_material, line.by_temperature[None], line.by_parameter])
    splines = gain * sweeps.nodes.coefficients(values)
    splines[0] += gain * sweeps.defect[sweep]
    predicted = splines[0].copy()
    compressed = sweeps.compressed[sweep]
    columns = np.concatenate([splines[1:5], predicted[None], splines[5:]])
    stacked = np.concatenate([columns, (compressed.coefficients - predicted)[None]])
    white = compressed.whitened(stacked)
    white *= sweeps.rows[sweep]
    flat = white.reshape(len(white), -1)
    real = np.concatenate([flat.real, flat.imag], axis=1)
    products = real @ real.T
    return SweepEquations(products[:-1, :-1], products[:-1, -1], white[-1], predicted)


@dataclass(frozen=True)
class Arrow:
    """All sweeps together, laws and temperatures eliminated.

    Attributes
    ----------
    matrix : (1 + P, 1 + P) ndarray
        Schur complement for log gain and the effects' parameters.
    gradient : (1 + P,) ndarray
    raw : (1 + P, 1 + P) ndarray
        `matrix` before the elimination: the size of each column.
    promised : float
        Fall of chi2 that the eliminated unknowns promise by themselves.
    """

    matrix: Real
    gradient: Real
    raw: Real
    promised: float
    _blocks: tuple[tuple[NDArray[np.int_], Real, Real, Real], ...] = field(repr=False)
    _shape: tuple[int, int] = field(repr=False)

    def follow(self, step: Real) -> tuple[Real, Real]:
        """Return steps of laws (G, 3) and temperatures (T,) once gain and effects step by `step` (1 + P,)."""
        laws, away = np.zeros((self._shape[0], LAWS)), np.zeros(self._shape[1])
        for group, (members, lever, own, _) in enumerate(self._blocks):
            local = own - lever @ step
            laws[group] = local[:LAWS]
            if len(local) > LAWS:
                away[members] = local[LAWS:]
        return laws, away

    def law_sigma(self, joint: Real) -> Real:
        """Return standard deviations (G, 3) of the laws when gain and effects have covariance `joint`."""
        variance = [
            inverse[:LAWS] + ((lever[:LAWS] @ joint) * lever[:LAWS]).sum(1)
            for _, lever, _, inverse in self._blocks
        ]
        sigma: Real = np.sqrt(np.array(variance))
        return sigma


def arrow(
    sweeps: GapSweeps,
    equations: Sequence[SweepEquations],
    away: Real,
    *,
    damping: float = 0.0,
    frozen: bool = False,
    readings: bool = True,
) -> Arrow:
    """Eliminate the laws of every group and the temperatures of its sweeps.

    Parameters
    ----------
    equations : sequence of SweepEquations
        One per sweep.
    away : (T,) ndarray
        Present errors of the readings, K; their prior pulls them to zero.
    damping : float
        Of Levenberg and Marquardt, on the diagonals of the groups' blocks.
    frozen : bool
        Laws and temperatures do not move: nothing is eliminated.
    readings : bool
        False takes the temperatures for known: only laws are eliminated.
    """
    size = len(equations[0].gradient) - GLOBAL
    matrix = sum((e.matrix[GLOBAL:, GLOBAL:] for e in equations), np.zeros((size, size)))
    gradient = sum((e.gradient[GLOBAL:] for e in equations), np.zeros(size))
    raw = matrix
    promised, blocks = 0.0, []
    for group in range(len(sweeps.groups.reference)):
        members = np.flatnonzero(sweeps.groups.of_sweep == group)
        mine = [equations[int(s)] for s in members]
        local, coupling, pull = _group_block(mine, away[members], sweeps.reading_sigma, readings)
        if frozen:
            blocks.append((members, np.zeros_like(coupling), np.zeros_like(pull), np.zeros_like(pull)))
            continue
        scale = 1.0 / np.sqrt(np.maximum(np.diag(local), 1e-300))
        unit = local * scale[:, None] * scale + (RIDGE + damping) * np.eye(len(local))
        factor = cho_factor(unit)
        solved = scale[:, None] * cho_solve(factor, scale[:, None] * np.column_stack([coupling, pull]))
        lever, own = solved[:, :-1], solved[:, -1]
        matrix = matrix - coupling.T @ lever
        gradient = gradient - coupling.T @ own
        promised += float(pull @ own)
        inverse = scale**2 * np.diag(cho_solve(factor, np.eye(len(local))))
        blocks.append((members, lever, own, inverse))
    shape = (len(sweeps.groups.reference), sweeps.count)
    return Arrow(0.5 * (matrix + matrix.T), gradient, raw, promised, tuple(blocks), shape)


def _group_block(
    equations: Sequence[SweepEquations], away: Real, reading_sigma: float, readings: bool
) -> tuple[Real, Real, Real]:
    """Matrix of a group's own unknowns, their coupling to the common ones, and their gradient."""
    wobbling = len(equations) if readings and len(equations) > 1 else 0
    size = LAWS + wobbling
    common = len(equations[0].gradient) - GLOBAL
    local, coupling, pull = np.zeros((size, size)), np.zeros((size, common)), np.zeros(size)
    for place, e in enumerate(equations):
        own = np.arange(LAWS)
        if wobbling:
            own = np.append(own, LAWS + place)
            columns = np.arange(TEMPERATURE + 1)
            local[LAWS + place, LAWS + place] += reading_sigma**-2
            pull[LAWS + place] -= away[place] / reading_sigma**2
        else:
            columns = np.arange(LAWS)
        local[np.ix_(own, own)] += e.matrix[np.ix_(columns, columns)]
        coupling[own] += e.matrix[columns, GLOBAL:]
        pull[own] += e.gradient[columns]
    return local, coupling, pull
