"""FIR filters by least squares of the error of the field, not of the filters."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.fir import taper
from analysis.focusing.panel import Filters
from analysis.focusing.prolate import ProlateTaps

OUT_OF_BAND_WEIGHT = 3e-4
"""Weight of a filter's response outside the band, relative to the median largest field energy in the band."""


@dataclass(frozen=True)
class FieldFit:
    """Least-squares problem for one set of settings; each temperature needs one solution.

    Attributes
    ----------
    basis : ProlateTaps
    gain : (F,) ndarray
        Weight of each line: 1 in the band, falling to 0 at the edges.
    products : tuple of (F, i, j) ndarray
        Weighted products of spectra: even with even, odd with odd, even with odd.
    inside, outside : (k, k) ndarray
        Energy of a filter in the band, and outside it, in lines; between band and edges it is divided by the
        taper.
    frequency : (F,) ndarray
        Hz.
    sample_rate : float
        Hz.
    """

    basis: ProlateTaps
    gain: Real
    products: tuple[Real, Real, Real]
    inside: Real
    outside: Real
    frequency: Real
    sample_rate: float

    @classmethod
    def of(cls, settings: Filters) -> Self:
        """Prepare the part common to all temperatures."""
        basis, lines = ProlateTaps.of(settings), settings.frequency
        gain = taper(lines, settings)
        even, odd = basis.spectrum[:, : basis.even], basis.spectrum[:, basis.even :]
        weighted = gain[:, None, None]
        products = (
            weighted * even[:, :, None] * even[:, None, :],
            weighted * odd[:, :, None] * odd[:, None, :],
            weighted * even[:, :, None] * odd[:, None, :],
        )
        inside = _blocks(basis, gain)
        return cls(
            basis, gain, products, inside, basis.outside + _blocks(basis, 1.0 - gain), lines, settings.sample_rate
        )

    def problem(self, weight: Complex, largest: Real, filters: Complex, delay: int) -> "FieldProblem":
        """Set up the least squares for the taps of one temperature.

        Parameters
        ----------
        weight : (F, N, N) ndarray
            P, Hermitian: weight of the actuators' errors.
        largest : (F,) ndarray
            Largest eigenvalue of P.
        filters : (F, N) ndarray
            R, the complex filters to be approximated.
        delay : int
            Modelling delay, samples.

        Notes
        -----
        Minimised over real taps with the response e(f) is

            Σ g (e - R z)ᴴ P (e - R z) + w Σ_outside |e|²,   z = exp(-j2πf·delay/fs),

        g being the band's taper and w small. The normal matrix is block-Toeplitz in the taps; written in the
        prolate sequences with energy in the band it is exact to rounding, and of order 6 × 45 instead of 6 × 512.
        """
        count, basis = filters.shape[1], self.basis
        size, even = len(basis.sequences), basis.even
        normal = np.empty((count, size, count, size))
        real, imaginary = (part.reshape(len(weight), -1) for part in (weight.real, weight.imag))
        first, second = slice(None, even), slice(even, None)
        for product, part, rows, columns in (
            (self.products[0], real, first, first),
            (self.products[1], real, second, second),
            (self.products[2], imaginary, first, second),
        ):
            lines, i, j = product.shape
            block = (product.reshape(lines, -1).T @ part).reshape(i, j, count, count)
            normal[:, rows, :, columns] = block.transpose(2, 0, 3, 1)
        normal[:, second, :, first] = normal[:, first, :, second].transpose(2, 3, 0, 1)
        small = OUT_OF_BAND_WEIGHT * float(np.median(largest[self.gain == 1.0]))
        for actuator in range(count):
            normal[actuator, :, actuator] += small * self.outside
        right = self._right((weight @ filters[..., None])[..., 0], delay).ravel()
        return FieldProblem(basis.sequences, normal, right, self.inside)

    def alike(self, filters: Complex, delay: int) -> Real:
        """Least-squares taps (B, M) of `filters` (F, B), delayed, with equal weight on all lines."""
        solved = np.linalg.solve(self.inside + OUT_OF_BAND_WEIGHT * self.outside, self._right(filters, delay).T).T
        return np.asarray(solved @ self.basis.sequences)

    def _right(self, wanted: Complex, delay: int) -> Real:
        """Right-hand sides (B, k) for `wanted` (F, B)."""
        even = self.basis.even
        turn = self.gain * np.exp(-2j * np.pi * self.frequency * (delay - self.basis.middle) / self.sample_rate)
        turned = turn[:, None] * wanted
        even_part = turned.real.T @ self.basis.spectrum[:, :even]
        return np.concatenate([even_part, -turned.imag.T @ self.basis.spectrum[:, even:]], axis=1)


@dataclass(frozen=True)
class FieldProblem:
    """Normal equations of one temperature, to be solved with a penalty on each actuator's drive.

    Attributes
    ----------
    sequences : (k, M) ndarray
    normal : (N, k, N, k) ndarray
    right : (N k,) ndarray
    inside : (k, k) ndarray
        Energy of an actuator's filter in the band.
    """

    sequences: Real
    normal: Real
    right: Real
    inside: Real

    def solve(self, penalty: Real) -> Real:
        """Taps (N, M) with a penalty on each actuator's filter of `penalty` (N,) times its energy in the band."""
        from scipy.linalg import cho_factor, cho_solve

        count, size, *_ = self.normal.shape
        penalised = self.normal.copy()
        for actuator in np.flatnonzero(penalty):
            penalised[actuator, :, actuator] += penalty[actuator] * self.inside
        factor = cho_factor(penalised.reshape(count * size, -1), lower=True, overwrite_a=True, check_finite=False)
        solved: Real = cho_solve(factor, self.right, check_finite=False).reshape(count, size)
        return solved @ self.sequences


def _blocks(basis: ProlateTaps, weight: Real) -> Real:
    """Σ weight · Re(e_iᴴ e_j) over the lines (k, k); even and odd spectra are orthogonal."""
    found: Real = basis.spectrum.T @ (weight[:, None] * basis.spectrum)
    found[: basis.even, basis.even :] = found[basis.even :, : basis.even] = 0.0
    return found
