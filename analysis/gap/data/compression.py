"""Lossless compression of a sweep: thousands of lines become a few hundred independent numbers.

A plate's transfer is smooth on the scale of half a resonance's width, eta f / 2; lines are much closer. A quintic
spline through nodes at a fraction of that width represents any transfer of a plate; the rest is noise. Where
resonances are so sharp that lines are no closer than nodes would be, each line is a node, and no rest remains.
With W the interpolation from nodes to lines and O the weights, chi2 of any smooth model H splits exactly into

    sum O |h - W H|^2 = sum O |h - W c|^2 + (c - H)^H W'OW (c - H),    c = (W'OW)^-1 W'O h,

of which the first part depends on no model. The spline's coefficients are used instead of its values at the nodes:
then W'OW is banded, and so is the Cholesky factor that turns c - H into independent numbers of unit variance.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded, solve_banded
from scipy.sparse import csr_array

from analysis.arrays import Complex, Real
from analysis.gap.thresholds import LINES_PER_NODE, NODES_PER_HALF_WIDTH

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

DEGREE = 5
"""Degree of the splines: a cubic needs twice the nodes of a quintic for the same error at a resonance."""


@dataclass(frozen=True)
class Nodes:
    """Splines over a band of frequencies, given by their values at nodes.

    Attributes
    ----------
    frequency : (n,) ndarray
        Where a model is evaluated, Hz.
    lines : (F,) ndarray
        The lines used, Hz.
    basis : (F, n) sparse array
        B-splines at the lines.
    interpolation : (2 DEGREE + 1, n) ndarray
        B-splines at the nodes, banded as `scipy.linalg.solve_banded` takes it.
    """

    frequency: Real
    lines: Real
    basis: csr_array = field(repr=False)
    interpolation: Real = field(repr=False)

    @classmethod
    def over(
        cls, lines: Real, loss_factor: float, *, spacing: float, per_half_width: float = NODES_PER_HALF_WIDTH
    ) -> "Nodes":
        """Place nodes for resonances no sharper than `loss_factor`.

        Parameters
        ----------
        lines : (F,) ndarray
            Frequencies of the lines used, Hz.
        loss_factor : float
            Smallest loss factor of a resonance.
        spacing : float
            Distance of neighbouring lines, Hz.
        per_half_width : float
            Number of nodes within half the width of a resonance.

        Returns
        -------
        Nodes

        Raises
        ------
        ValueError
            For fewer lines than nodes.
        """
        from scipy.interpolate import BSpline

        # below this frequency nodes would have to be closer than the lines: there each line is a node
        sharp = float(np.clip(2.0 * per_half_width * LINES_PER_NODE * spacing / loss_factor, lines[0], lines[-1]))
        single = lines[lines < sharp]
        # nodes nearly at one frequency would give more degrees of freedom than there are lines
        begin = min(max(sharp, single[-1] + spacing), lines[-1]) if single.size else sharp
        grid = np.linspace(begin, lines[-1], 4001)
        step = np.maximum(loss_factor * grid / 2.0 / per_half_width, LINES_PER_NODE * spacing)
        count = np.concatenate([[0.0], np.cumsum(0.5 * (1.0 / step[1:] + 1.0 / step[:-1]) * np.diff(grid))])
        further = max(int(np.ceil(count[-1])) + 1, 2 * DEGREE - single.size)
        frequency = np.concatenate([single, np.interp(np.linspace(0.0, count[-1], further), count, grid)])
        n = frequency.size
        if n > len(lines):
            raise ValueError(
                f"{len(lines)} lines over {lines[0]:g} to {lines[-1]:g} Hz cannot carry {n} nodes; a wider "
                "band or a longer record is needed"
            )
        knots = _knots(frequency)
        square = BSpline.design_matrix(frequency, knots, DEGREE).toarray()
        banded = np.zeros((2 * DEGREE + 1, n))
        for offset in range(-DEGREE, DEGREE + 1):
            row = np.diagonal(square, offset)
            banded[DEGREE - offset, max(offset, 0) : max(offset, 0) + row.size] = row
        return cls(frequency, lines, csr_array(BSpline.design_matrix(lines, knots, DEGREE)), banded)

    def coefficients(self, values: Complex) -> Complex:
        """Coefficients (..., n) of the splines through `values` (..., n) at the nodes."""
        columns = values.reshape(-1, values.shape[-1])
        parts = np.concatenate([columns.real, columns.imag]).T
        solved = solve_banded((DEGREE, DEGREE), self.interpolation, parts, check_finite=False).T
        return (solved[: len(columns)] + 1j * solved[len(columns) :]).reshape(values.shape)

    def spline(self, coefficients: Complex) -> "BSpline[np.complex128]":
        """Splines with `coefficients` (..., n): called with frequencies (m,), Hz, they give values (m, ...)."""
        from scipy.interpolate import BSpline

        return BSpline(_knots(self.frequency), np.moveaxis(coefficients, -1, 0), DEGREE)

    def at_nodes(self, coefficients: Complex) -> Complex:
        """Values (..., n) at the nodes of splines with `coefficients` (..., n)."""
        return np.moveaxis(np.asarray(self.spline(coefficients)(self.frequency)), 0, -1)

    def slope(self, coefficients: Complex) -> Complex:
        """Differentiate splines with `coefficients` (..., n) at the nodes, per Hz: (..., n)."""
        return np.moveaxis(np.asarray(self.spline(coefficients).derivative()(self.frequency)), 0, -1)

    def at_lines(self, coefficients: Complex) -> Complex:
        """Values (..., F) at the lines of splines with `coefficients` (..., n)."""
        columns = coefficients.reshape(-1, coefficients.shape[-1])
        values = np.asarray(self.basis @ columns.T).T
        return values.reshape(*coefficients.shape[:-1], -1)


def _knots(nodes: Real) -> Real:
    """Knots of the spline through `nodes`, with not-a-knot ends."""
    inner = nodes[(DEGREE + 1) // 2 : -(DEGREE + 1) // 2]
    ends = np.full(DEGREE + 1, nodes[0]), np.full(DEGREE + 1, nodes[-1])
    return np.concatenate([ends[0], inner, ends[1]])


@dataclass(frozen=True)
class CompressedSweep:
    """One sweep as spline coefficients with their covariance.

    Attributes
    ----------
    nodes : Nodes
    coefficients : (K, n) complex ndarray
        Weighted least-squares splines of the measured FRFs, V/V.
    factor : (K, DEGREE + 1, n) ndarray
        Upper banded Cholesky factors of twice the weighted Gram matrices: with them real and imaginary parts of
        a residual are independent and of unit variance.
    chi2_within : (K, B) ndarray
        2 sum |h - spline|^2 / variance over blocks of neighbouring lines.
    block_dof : (B,) ndarray
        Degrees of freedom of each block: those of the nodes are subtracted in proportion to their density.
    power_within : (K,) ndarray
        sum |h - spline|^2, (V/V)^2.
    """

    nodes: Nodes
    coefficients: Complex
    factor: Real
    chi2_within: Real
    block_dof: Real
    power_within: Real

    @property
    def dof_within(self) -> int:
        """Degrees of freedom of a channel's `chi2_within` over all blocks."""
        return 2 * (self.nodes.lines.size - self.nodes.frequency.size)

    def whitened(self, coefficients: Complex, channels: slice = slice(None)) -> Complex:
        """Whiten `coefficients` (..., K, n): real and imaginary parts in standard deviations of noise.

        Of all channels, or of some.
        """
        n, factor = coefficients.shape[-1], self.factor[channels]
        white = factor[:, DEGREE] * coefficients
        for offset in range(1, DEGREE + 1):
            white[..., : n - offset] += factor[:, DEGREE - offset, offset:] * coefficients[..., offset:]
        return white

    def only_channels(self, channels: Sequence[int]) -> "CompressedSweep":
        """Return the same sweep with some of its channels."""
        kept = list(channels)
        by_channel = ("coefficients", "factor", "chi2_within", "power_within")
        return replace(self, **{name: getattr(self, name)[kept] for name in by_channel})

    def rescaled(self, ratio: Real) -> "CompressedSweep":
        """Return the same sweep with the variance of each channel multiplied by `ratio` (K,)."""
        return replace(
            self,
            factor=self.factor / np.sqrt(ratio)[:, None, None],
            chi2_within=self.chi2_within / ratio[:, None],
        )


BLOCKS = 16
"""Number of blocks of the band in which the noise is compared with the stated one."""


def compress(h: Complex, variance: Real, nodes: Nodes) -> CompressedSweep:
    """Compress one sweep.

    Parameters
    ----------
    h : (K, F) complex ndarray
        Measured FRFs at the lines of `nodes`, V/V.
    variance : (K, F) ndarray
        E|h - H|^2, (V/V)^2.
    nodes : Nodes

    Returns
    -------
    CompressedSweep

    Raises
    ------
    ValueError
        Where a block of the band holds no lines.
    """
    coefficients, factors, local, power = [], [], [], []
    count = nodes.frequency.size
    # a block's share of the nodes' degrees of freedom is proportional to their density there
    leverage = np.interp(nodes.lines, nodes.frequency, np.gradient(np.arange(count, dtype=float), nodes.frequency))
    between = ~np.isin(nodes.lines, nodes.frequency)
    leverage[~between] = 1.0
    if between.any():
        leverage[between] *= (count - np.count_nonzero(~between)) / leverage[between].sum()
    edges = np.linspace(0, nodes.lines.size, BLOCKS + 1).astype(int)[:-1]
    block_freedom = 2.0 * np.maximum(np.add.reduceat(1.0 - leverage, edges), 1e-9)
    for row, spread in zip(h, variance, strict=True):
        weighted = nodes.basis.multiply(2.0 / spread[:, None]).tocsr()
        gram = (weighted.T @ nodes.basis).todia()
        banded = np.zeros((DEGREE + 1, count))
        for offset in range(DEGREE + 1):
            banded[DEGREE - offset, offset:] = gram.diagonal(offset)
        try:
            factor = cholesky_banded(banded)
        except LinAlgError:
            raise ValueError("a stretch of the band holds too few usable lines for its nodes") from None
        moment = weighted.T @ row
        solved = cho_solve_banded((factor, False), np.stack([moment.real, moment.imag], axis=1))
        coefficients.append(solved[:, 0] + 1j * solved[:, 1])
        factors.append(factor)
        missed = np.abs(row - nodes.basis @ coefficients[-1]) ** 2
        local.append(np.add.reduceat(2.0 * missed / spread, edges))
        power.append(missed.sum())
    return CompressedSweep(
        nodes=nodes,
        coefficients=np.array(coefficients),
        factor=np.array(factors),
        chi2_within=np.array(local),
        block_dof=block_freedom,
        power_within=np.array(power),
    )
