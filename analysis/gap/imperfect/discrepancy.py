"""Discrepancy of a twin that no named effect explains: scatter of resonances, from all that nobody declared.

On a real structure joints, coupled air, strings and humidity move each resonance a little and damp it a little
differently, alike at all temperatures. To first order each mode gets a relative shift a of its frequency, a
change b of its half loss factor and a relative change c of its residue, all independent: a line of it is off by

    (a + i b) f dH/df + c H.

Every line of a mode, in all channels and sweeps, has the same a, b and c. N numbers with one error of variance D
beside their own noise v tell what they share with the variance v / N + D. So does each alone with the variance
v + N D; lines weighted by v / (v + N D) therefore carry as much as they really do. a acts along the direction of
f dH/df in the complex plane and b across it: the two parts of a line are weighted by themselves. What differs
between the lines of one mode, or between temperatures, is known better than that; this is on the safe side.

The standard deviations of a, b and c are those of maximum likelihood, for each set of effects by its own residual
(type-II maximum likelihood, as for the variance components of a mixed model).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from analysis.arrays import Complex, Real
from analysis.gap.data.sweeps import GapSweeps, LineWeights

LARGEST = 1.0
"""Largest scatter that is tried: resonances that are nowhere near."""

SMALLEST = 1e-6
"""Smallest scatter that is tried: a thousandth of the twin's numerical error."""

PROMINENCE = 0.3
"""Least height of the peak of a resonance over the dips beside it, as a logarithm of power."""

MIXED = np.array([[1.0, 0.1], [0.1, 1.0]])
"""Shares of a's and b's variance along and across the direction of f dH/df: the direction of one mode's error is
that of all modes together only as far as these do not overlap. Without it, where b was 0, the part of a modulus'
tangent that is across (a loss factor times the part along) told the modulus as exactly as the noise allowed."""

MOST_FITTED = 0.75
"""Largest share of the independent errors that fitted unknowns are taken to have absorbed."""


@dataclass(frozen=True)
class Discrepancy:
    """Scatter of the resonances of a plate about those of its twin, as standard deviations.

    Attributes
    ----------
    frequency : float
        Of the relative differences of modal frequencies.
    damping : float
        Of half the differences of modal loss factors.
    amplitude : float
        Of the relative differences of residues.
    """

    frequency: float
    damping: float
    amplitude: float

    @property
    def logarithms(self) -> Real:
        """Of the three, (3,)."""
        return np.log([self.frequency, self.damping, self.amplitude])


@dataclass(frozen=True)
class DiscrepancyShape:
    """How a discrepancy of unit size acts on every whitened number of some sweeps.

    Attributes
    ----------
    direction : (T, K, n) complex ndarray
        Of f dH/df, of unit size.
    by_frequency, by_amplitude : (T, K, n) ndarray
        Variance of a part of the number, in units of the noise's, for a scatter of 1: of the part along
        `direction` by a, or across it by b; and of each part by c. The mean over a mode: beside a resonance
        f dH/df may vanish where the shares of two modes cancel, and their errors do not.
    together : (T, n) ndarray
        Numbers that share one error: those of a mode, over all channels and sweeps. A mode has the lines nearer
        to its resonance than to others, and at least those within its width.
    """

    direction: Complex = field(repr=False)
    by_frequency: Real = field(repr=False)
    by_amplitude: Real = field(repr=False)
    together: Real = field(repr=False)

    @classmethod
    def of(cls, sweeps: GapSweeps, predicted: NDArray[np.complex128], loss_factor: Real) -> "DiscrepancyShape":
        """Take it from a fitted twin.

        Parameters
        ----------
        sweeps : GapSweeps
        predicted : (T, K, n) complex ndarray
            The twin's spline coefficients, V/V.
        loss_factor : (T,) ndarray
            Of the plate, for the width of resonances.

        Returns
        -------
        DiscrepancyShape
        """
        nodes, shape = sweeps.nodes, predicted.shape
        frequency = nodes.frequency
        # in nodes: the area under a resonance's power is pi/2 half-power widths times its peak
        width = 0.5 * np.pi * loss_factor[:, None] * frequency / np.gradient(frequency)
        together = np.clip(width, 1.0, frequency.size)
        direction, by_frequency, by_amplitude = np.empty(shape, complex), np.empty(shape), np.empty(shape)
        for s, (sweep, coefficients) in enumerate(zip(sweeps.compressed, predicted, strict=True)):
            slope = frequency * nodes.slope(coefficients)
            mode = _modes((np.abs(slope) ** 2).sum(axis=0))
            shift = sweep.whitened(nodes.coefficients(slope))
            direction[s] = np.exp(1j * np.angle(shift))
            by_frequency[s] = _mean_over(mode, np.abs(shift) ** 2)
            by_amplitude[s] = 0.5 * _mean_over(mode, np.abs(sweep.whitened(coefficients)) ** 2)
            together[s] = np.maximum(together[s], np.bincount(mode)[mode])
        return cls(direction, by_frequency, by_amplitude, together * len(sweeps.channels) * sweeps.count)

    def within_a_sweep(self, sweeps: GapSweeps) -> "DiscrepancyShape":
        """Return the same with an error that the lines and channels of one sweep share, and no other sweep."""
        return replace(self, together=self.together / sweeps.count)

    def only(self, sweeps: Sequence[int]) -> "DiscrepancyShape":
        """Return that of some of the sweeps."""
        kept = list(sweeps)
        return DiscrepancyShape(
            self.direction[kept], self.by_frequency[kept], self.by_amplitude[kept], self.together[kept]
        )

    def variances(self, scatter: Discrepancy) -> Real:
        """Variances of the parts of every number along and across, (2, T, K, n), in units of the noise's."""
        shares = MIXED @ np.array([scatter.frequency, scatter.damping]) ** 2
        found: Real = shares[:, None, None, None] * self.by_frequency + scatter.amplitude**2 * self.by_amplitude
        return found

    def weights(self, scatter: Discrepancy) -> LineWeights:
        """Weigh every number as much as it carries beside a discrepancy."""
        along, across = 1.0 / np.sqrt(1.0 + self.together[:, None] * self.variances(scatter))
        return LineWeights(self.direction, along, across)

    def penalty(self, sweeps: GapSweeps, scatter: Discrepancy) -> float:
        """Minus the log evidence of the scatter itself, beside that of the weighted fit, nats.

        For N numbers with one error of variance D beside noise of variance 1, minus twice the log likelihood is
        log(1 + N D) + N m^2 / (1 + N D) + what they scatter about their mean m. Weighted by 1 / (1 + N D), this
        scatter counts too little by its expectation.
        """
        shared = np.broadcast_to(self.together[:, None], sweeps.rows.shape)[sweeps.rows]
        error = shared * self.variances(scatter)[:, sweeps.rows]
        return 0.5 * float((np.log1p(error) / shared - (1.0 - 1.0 / shared) / (1.0 + error)).sum())

    def scatter(self, sweeps: GapSweeps, residual: NDArray[np.complex128], fitted: float) -> Discrepancy:
        """Find the likeliest scatter behind a residual.

        Parameters
        ----------
        sweeps : GapSweeps
        residual : (T, K, n) complex ndarray
            In units of the noise.
        fitted : float
            Number of unknowns that the residual has been fitted with, beside those of single temperatures.

        Returns
        -------
        Discrepancy
        """
        rows = sweeps.rows
        turned = (residual * self.direction.conj())[rows]
        power = np.stack([turned.real**2, turned.imag**2])
        by_frequency, by_amplitude = self.by_frequency[rows], self.by_amplitude[rows]
        # fitted unknowns took a part of the independent errors away
        errors = 2.0 * float((1.0 / np.broadcast_to(self.together[:, None], rows.shape)[rows]).sum())
        lost = 1.0 / (1.0 - min(fitted / errors, MOST_FITTED))

        def unlikely(logs: Real) -> float:
            shares = np.exp(2.0 * logs)
            variance = (MIXED @ shares[:2])[:, None] * by_frequency + shares[2] * by_amplitude
            return float((np.log1p(variance) + power / (1.0 + variance)).mean())

        starts = [np.log([a, a, c]) for a in (1e-5, 1e-3, 3e-2) for c in (1e-5, 1e-2, 1e-1)]
        bounds = [(np.log(SMALLEST), np.log(LARGEST))] * 3
        found = minimize(unlikely, min(starts, key=unlikely), method="Nelder-Mead", bounds=bounds)
        return Discrepancy(*(np.exp(found.x) * np.sqrt(lost)).tolist())


def _modes(power: Real) -> NDArray[np.int_]:
    """Tell the number of the mode that each node belongs to, (n,).

    Modes are told apart by the peaks of `power` |f dH/df|^2 (n,), which is highest at resonances; modes that
    overlap count as one, which is on the safe side.
    """
    from scipy.signal import find_peaks  # half a second of processor time, which an update is spared

    peaks = find_peaks(np.log(np.maximum(power, 1e-300)), prominence=PROMINENCE)[0]
    edges = np.ceil(0.5 * (peaks[1:] + peaks[:-1]))
    return np.searchsorted(edges, np.arange(power.size), side="right")


def _mean_over(mode: NDArray[np.int_], values: Real) -> Real:
    """Mean of `values` (K, n) over the nodes of each mode, at every node."""
    size = np.bincount(mode)
    means = np.array([np.bincount(mode, row) / size for row in values])
    return np.asarray(means[:, mode])
