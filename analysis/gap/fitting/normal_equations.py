"""Whitened least squares of every sweep at one state.

Columns of a sweep: log E, nu and log eta at its temperature, their slopes and curvatures, the plate's temperature,
log gain of every input, then parameters of effects. The gains of inputs that did not drive the sweep have columns
of zeros.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.state import GapState
from analysis.local_laws import LocalLaws
from analysis.twin_model import Tangent, TwinModel

Made = TypeVar("Made")

VALUES, LAWS, TEMPERATURE, GLOBAL = slice(0, 3), slice(0, 9), 9, 10
"""Indices of the columns: laws without and with derivatives, unknown of a sweep, first unknown of the campaign."""


MOST_KEPT = 2e7
"""Complex numbers of columns that are kept: 320 MB."""


@dataclass(frozen=True)
class SweepEquations:
    """One sweep linearised.

    Attributes
    ----------
    matrix : (10 + I + P, 10 + I + P) ndarray
        J'J of the whitened columns, of I inputs and P parameters.
    gradient : (10 + I + P,) ndarray
        J'r.
    residual : (K, n) complex ndarray
        Data less model in units of noise, real and imaginary part each; zero where left out.
    predicted : (K, n) complex ndarray
        Spline coefficients of the model, V/V.
    columns : (10 + I + P, K, n) complex ndarray or None
        J; None where it was not kept.
    """

    matrix: Real
    gradient: Real
    residual: NDArray[np.complex128] = field(repr=False)
    predicted: NDArray[np.complex128] = field(repr=False)
    columns: NDArray[np.complex128] | None = field(repr=False, default=None)

    @property
    def chi2(self) -> float:
        """Sum of squares of the whitened residual."""
        return float((np.abs(self.residual) ** 2).sum())

    def bent(self, step: Real, left: NDArray[np.complex128]) -> "SweepEquations":
        """Return equations whose solution allows for what a step leaves beyond first order.

        Parameters
        ----------
        step : (10 + I + P,) ndarray
        left : (K, n) complex ndarray
            Residual after it.

        Returns
        -------
        SweepEquations
            Their gradient is that of the residual plus its second order along the step.

        Raises
        ------
        ValueError
            Where the columns were not kept.
        """
        if self.columns is None:
            raise ValueError("the columns of these equations were not kept")
        second = left - self.residual + np.tensordot(step, self.columns, 1)
        pull = np.tensordot(self.columns.conj(), second, 2).real
        return replace(self, gradient=self.gradient + pull)


@dataclass(frozen=True)
class WhitenedSweep:
    """One sweep's columns in units of noise, before the normal equations are formed.

    Attributes
    ----------
    white : (11 + I + P, K, n) complex ndarray
        The columns, and after them the residual.
    predicted : (K, n) complex ndarray
        As in `SweepEquations`.
    """

    white: NDArray[np.complex128] = field(repr=False)
    predicted: NDArray[np.complex128] = field(repr=False)

    def equations(self, *, keep: bool = False) -> SweepEquations:
        """Form the normal equations, and `keep` the columns."""
        flat = self.white.reshape(len(self.white), -1)
        real = np.concatenate([flat.real, flat.imag], axis=1)
        products = real @ real.T
        kept = self.white[:-1] if keep else None
        return SweepEquations(products[:-1, :-1], products[:-1, -1], self.white[-1].copy(), self.predicted, kept)

    def after(self, step: Real) -> NDArray[np.complex128]:
        """Residual (K, n) after a step (10 + I + P,), to first order."""
        left: NDArray[np.complex128] = self.white[-1] - np.tensordot(step, self.white[:-1], 1)
        return left


@runtime_checkable
class CampaignEquations(Protocol):
    """A model of whole sweeps that needs no twin to be linearised."""

    def equations(self, sweeps: GapSweeps, state: GapState, tangents: Sequence[Tangent]) -> list[SweepEquations]:
        """Do what `linearise_all` does.

        Parameters
        ----------
        sweeps : GapSweeps
        state : GapState
        tangents : sequence of Tangent

        Returns
        -------
        list of SweepEquations
        """
        ...


def linearise_all(
    model: TwinModel,
    sweeps: GapSweeps,
    state: GapState,
    tangents: Sequence[Tangent],
    executor: Executor,
    *,
    keep: bool = False,
) -> list[SweepEquations]:
    """Linearise all sweeps at one state.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    state : GapState
    tangents : sequence of Tangent
        The P parameters of effects by which to differentiate.
    executor : Executor
        Sweeps are linearised on it.
    keep : bool
        Whether the columns are kept, unless they take more than `MOST_KEPT`.

    Returns
    -------
    list of SweepEquations
        One per sweep.

    Raises
    ------
    ValueError
        Where the model refuses the state: outside its box, or an effect outside its certified range.
    """
    if isinstance(model, CampaignEquations):
        return model.equations(sweeps, state, tangents)
    laws = sweeps.smoothness.laws(state.laws)
    model = model.counted(laws, state.on)

    numbers = sweeps.rows.size * (GLOBAL + len(state.log_gain) + len(tangents))

    def linearised(sweep: int) -> SweepEquations:
        found = _whitened(model, sweeps, sweep, laws, state, tangents)
        return found.equations(keep=keep and numbers <= MOST_KEPT)

    return _for_all(linearised, sweeps, executor)


def whiten_all(
    model: TwinModel, sweeps: GapSweeps, state: GapState, tangents: Sequence[Tangent], executor: Executor
) -> list[WhitenedSweep]:
    """Linearise all sweeps like `linearise_all`, and keep the columns.

    Memory grows with the number of sweeps times the number of tangents.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    state : GapState
    tangents : sequence of Tangent
        The P parameters of effects by which to differentiate.
    executor : Executor
        Sweeps are linearised on it.

    Returns
    -------
    list of WhitenedSweep
        One per sweep.

    Raises
    ------
    ValueError
        As `linearise_all`.
    """
    laws = sweeps.smoothness.laws(state.laws)
    model = model.counted(laws, state.on)

    def whitened(sweep: int) -> WhitenedSweep:
        return _whitened(model, sweeps, sweep, laws, state, tangents)

    return _for_all(whitened, sweeps, executor)


def _for_all(work: Callable[[int], Made], sweeps: GapSweeps, executor: Executor) -> list[Made]:
    jobs = [executor.submit(work, sweep) for sweep in range(sweeps.count)]
    try:
        return [job.result() for job in jobs]
    finally:
        for job in jobs:
            job.cancel()


def _whitened(
    model: TwinModel,
    sweeps: GapSweeps,
    sweep: int,
    laws: Sequence[LocalLaws],
    state: GapState,
    tangents: Sequence[Tangent],
) -> WhitenedSweep:
    point = sweeps.points[sweep]
    moved = state.circumstances(sweep, point)
    frequency = sweeps.nodes.frequency
    group = sweeps.groups.of_sweep[sweep]
    # errors of the slopes about the oven's own temperature change only the effects that use them (lag, gradient);
    # about the group's reference they would be collinear with errors of the readings
    near = laws[group].tilted(state.tilt[group], state.bend[group], moved.temperature)
    line = model.linearise(near, frequency, state.on, moved, tangents)
    driving = np.arange(len(state.log_gain)) == point.source
    gain = float(np.exp(state.log_gain[point.source]))
    local = np.concatenate([line.by_material, line.by_slope, line.by_curvature, line.by_temperature[None]])
    splines = gain * sweeps.nodes.coefficients(
        np.concatenate(
            [local, driving[:, None, None] * line.transfer, line.by_parameter, np.zeros_like(line.transfer)[None]]
        )
    )
    predicted = splines[GLOBAL + point.source].copy()
    compressed = sweeps.compressed[sweep]
    splines[-1] = compressed.coefficients - predicted
    white = compressed.whitened(splines)
    white = sweeps.weights.weigh(white, sweep)
    white *= sweeps.rows[sweep]
    return WhitenedSweep(white, predicted)
