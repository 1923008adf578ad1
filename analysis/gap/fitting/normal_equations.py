"""Whitened least squares of every sweep at one state.

Columns of a sweep: log E, nu and log eta at its temperature, their slopes and curvatures, the plate's temperature,
log gain of every input, then parameters of effects. The gains of inputs that did not drive the sweep have columns
of zeros.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.state import GapState
from analysis.material import LocalLaws
from analysis.twin_model import Linearisation, Tangent, TwinModel

VALUES, LAWS, TEMPERATURE, GLOBAL = slice(0, 3), slice(0, 9), 9, 10
"""Indices of the columns: laws without and with derivatives, unknown of a sweep, first unknown of the campaign."""


MOST_KEPT = 2e7
"""Complex numbers of columns that are kept: 320 MB."""

BLOCK = 2_000_000
"""Whitened numbers of one sweep that are held at once, about; with its copies each takes 100 bytes. All columns of
a laser scan of 200 points are 30 million."""

ALIKE = 1e-10
"""Ratio of singular values below which laws and gain of one sweep are not told apart."""


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

    @classmethod
    def summed(cls, parts: Sequence["SweepEquations"]) -> "SweepEquations":
        """Join those of a sweep's channels, in order: they have unknowns in common and noise of their own."""
        if len(parts) == 1:
            return parts[0]
        return cls(
            np.sum([one.matrix for one in parts], axis=0),
            np.sum([one.gradient for one in parts], axis=0),
            np.concatenate([one.residual for one in parts]),
            np.concatenate([one.predicted for one in parts]),
        )

    @property
    def chi2(self) -> float:
        """Sum of squares of the whitened residual."""
        return float((np.abs(self.residual) ** 2).sum())

    @property
    def _kept(self) -> NDArray[np.complex128]:
        if self.columns is None:
            raise ValueError("the columns of these equations were not kept")
        return self.columns

    def with_last(self, known: "SweepEquations", count: int, shared: int) -> "SweepEquations":
        """Join the last `count` columns that were computed at another state, near this one.

        What those have in common with laws and gains follows these to the present state; only the rest is that of
        the other. Else thickness and modulus, say, that act alike at every state, would seem to differ by as much
        as derivatives change between two, and the data to tell one from the other.

        Parameters
        ----------
        known : SweepEquations
            Of the same sweep.
        count : int
        shared : int
            Number of columns before those of effects, which both begin with.

        Raises
        ------
        ValueError
            Where the columns of one of them were not kept.
        """
        columns, last = self._kept, known._kept[-count:]
        rows = [*range(VALUES.stop), *range(GLOBAL, shared)]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(known.matrix)[rows], np.finfo(float).tiny))
        unit = known.matrix[np.ix_(rows, rows)] * scale[:, None] * scale
        alike = scale[:, None] * np.linalg.lstsq(unit, scale[:, None] * known.matrix[rows, -count:], ALIKE)[0]
        last = last + np.tensordot(alike.T, columns[rows] - known._kept[rows], 1)
        across = np.tensordot(columns.conj(), last, ((1, 2), (1, 2))).real
        pull = np.tensordot(last.conj(), self.residual, 2).real
        own = np.tensordot(last.conj(), last, ((1, 2), (1, 2))).real
        return replace(
            self,
            matrix=np.block([[self.matrix, across], [across.T, own]]),
            gradient=np.concatenate([self.gradient, pull]),
            columns=np.concatenate([columns, last]),
        )

    def changed_from(self, known: "SweepEquations") -> float:
        """Relative change of the derivative by log E: of all derivatives near resonances, about.

        Raises
        ------
        ValueError
            Where the columns of one of them were not kept.
        """
        now, then = self._kept[0], known._kept[0]
        return float(np.linalg.norm(now - then) / np.linalg.norm(then))

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
        columns = self._kept
        second = left - self.residual + np.tensordot(step, columns, 1)
        pull = np.tensordot(columns.conj(), second, 2).real
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

    kept = keep and sweeps.rows.size * (GLOBAL + len(state.log_gain) + len(tangents)) <= MOST_KEPT

    def linearised(sweep: int) -> SweepEquations:
        line = _linearised(model, sweeps, sweep, laws, state, tangents)
        parts = channel_blocks(GLOBAL + len(state.log_gain) + len(tangents) + 1, *line.transfer.shape)
        return SweepEquations.summed(
            [_whitened(line, sweeps, sweep, state, part).equations(keep=kept) for part in parts]
        )

    return list(executor.map(linearised, range(sweeps.count)))


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
        line = _linearised(model, sweeps, sweep, laws, state, tangents)
        rows, shape = GLOBAL + len(state.log_gain) + len(tangents) + 1, line.transfer.shape
        white, predicted = np.empty((rows, *shape), complex), np.empty(shape, complex)
        for part in channel_blocks(rows, *shape):
            one = _whitened(line, sweeps, sweep, state, part)
            white[:, part], predicted[part] = one.white, one.predicted
        return WhitenedSweep(white, predicted)

    return list(executor.map(whitened, range(sweeps.count)))


def channel_blocks(rows: int, channels: int, nodes: int) -> Iterator[slice]:
    """Channels of a sweep in turn, so many at once that their whitened columns are about `BLOCK` numbers.

    Parameters
    ----------
    rows : int
        Columns, and the residual.
    channels : int
        K.
    nodes : int

    Yields
    ------
    slice
    """
    size = max(1, BLOCK // (rows * nodes))
    for first in range(0, channels, size):
        yield slice(first, min(first + size, channels))


def _linearised(
    model: TwinModel,
    sweeps: GapSweeps,
    sweep: int,
    laws: Sequence[LocalLaws],
    state: GapState,
    tangents: Sequence[Tangent],
) -> Linearisation:
    """Linearise the model at the nodes of one sweep."""
    moved = state.circumstances(sweep, sweeps.points[sweep])
    group = sweeps.groups.of_sweep[sweep]
    # errors of the slopes about the oven's own temperature change only the effects that use them (lag, gradient);
    # about the group's reference they would be collinear with errors of the readings
    near = laws[group].tilted(state.tilt[group], state.bend[group], moved.temperature)
    line = model.linearise(near, sweeps.nodes.frequency, state.on, moved, tangents)
    return line.only_channels(sweeps.heard) if sweeps.heard else line


def _whitened(line: Linearisation, sweeps: GapSweeps, sweep: int, state: GapState, part: slice) -> WhitenedSweep:
    """Whiten the columns of some channels of one sweep."""
    source = sweeps.points[sweep].source
    driving = np.arange(len(state.log_gain)) == source
    gain, transfer = float(np.exp(state.log_gain[source])), line.transfer[part]
    local = (line.by_material, line.by_slope, line.by_curvature, line.by_temperature[None])
    splines = gain * sweeps.nodes.coefficients(
        np.concatenate(
            [
                *(one[:, part] for one in local),
                driving[:, None, None] * transfer,
                line.by_parameter[:, part],
                np.zeros_like(transfer)[None],
            ]
        )
    )
    predicted = splines[GLOBAL + source].copy()
    compressed = sweeps.compressed[sweep]
    splines[-1] = compressed.coefficients[part] - predicted
    white = sweeps.weights.weigh(compressed.whitened(splines, part), sweep, part)
    white *= sweeps.rows[sweep, part]
    return WhitenedSweep(white, predicted)
