"""Basis of the taps with energy in a band: discrete prolate spheroidal sequences (Slepian 1978)."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from analysis.arrays import Real
from analysis.focusing.panel import Filters

NEGLIGIBLE_ENERGY = 1e-14
"""Sequences with a smaller share of energy in the band are left out: the penalty outside makes them zero."""


@dataclass(frozen=True)
class ProlateTaps:
    """A basis of M taps for filters with gain below `edges[1]`, and its spectra at the lines of the settings.

    Taps are h = Σ c_k s_k. About the middle of the taps even sequences have real and odd ones imaginary
    spectra, so that every product of two is real: e_k(f) = r_k(f) for the first `even` and -j r_k(f) for the rest.

    Attributes
    ----------
    sequences : (k, M) ndarray
        Orthonormal, even ones first.
    even : int
    spectrum : (F, k) ndarray
        r_k at the lines.
    outside : (k, k) ndarray
        ∫ e_iᴴ e_j over the frequencies beyond the edges up to half the sample rate, in lines.
    """

    sequences: Real
    even: int
    spectrum: Real
    outside: Real

    @classmethod
    def of(cls, settings: Filters) -> Self:
        """Basis for the taps, rate and edges of `settings`."""
        count, rate, head = settings.taps, settings.sample_rate, settings.edges[1]
        lines = settings.frequency
        half_bandwidth = count * head / rate
        # The share inside falls from 1 to 0 within about log(NW) sequences near number 2 NW.
        most = min(count, int(2.0 * half_bandwidth + 8.0 * np.log(4.0 * half_bandwidth + 8.0)) + 6)
        found, share = _slepian(count, half_bandwidth / count, most)
        used = np.flatnonzero(share > NEGLIGIBLE_ENERGY)
        order = np.concatenate([used[used % 2 == 0], used[used % 2 == 1]])
        sequences, even = found[order], int(np.count_nonzero(used % 2 == 0))
        # Enough Gauss points for the lowest frequencies, where a spectrum of M taps oscillates M foot/fs times.
        nodes, weights = np.polynomial.legendre.leggauss(24 + int(4.0 * count * settings.edges[0] / rate))
        low = 0.5 * settings.edges[0] * (nodes + 1.0)
        below = _spectrum(sequences, even, low, rate)
        spacing = lines[1] - lines[0]
        foot = below.T @ (0.5 * settings.edges[0] * weights[:, None] * below) / spacing
        foot[:even, even:] = foot[even:, :even] = 0.0
        outside = 0.5 * rate / spacing * np.diag(np.maximum(1.0 - share[order], 0.0)) + foot
        return cls(sequences, even, _spectrum(sequences, even, lines, rate), outside)

    @property
    def middle(self) -> float:
        """Sample about which the sequences are even or odd."""
        return 0.5 * float(self.sequences.shape[1] - 1)


def _slepian(count: int, bandwidth: float, most: int) -> tuple[Real, Real]:
    """Compute the `most` concentrated sequences (k, M), and the share of their energy within ± `bandwidth` (k,).

    `bandwidth` is a share of the sample rate. Eigenvectors of the tridiagonal matrix that commutes with the sinc
    kernel; scipy.signal has them too, but its import takes half a second of processor time.
    """
    from scipy.linalg import eigh_tridiagonal

    place = np.arange(count)
    diagonal = (0.5 * (count - 1) - place) ** 2 * np.cos(2.0 * np.pi * bandwidth)
    beside = 0.5 * place[1:] * (count - place[1:])
    _, found = eigh_tridiagonal(diagonal, beside, select="i", select_range=(count - most, count - 1))
    sequences = np.ascontiguousarray(found.T[::-1])
    power = np.abs(np.fft.rfft(sequences, 2 * count, axis=1)) ** 2
    products = np.fft.irfft(power, axis=1)[:, :count]
    kernel = np.append(2.0 * bandwidth, 4.0 * bandwidth * np.sinc(2.0 * bandwidth * place[1:]))
    share: Real = products @ kernel
    return np.asarray(sequences, float), share


def _spectrum(sequences: Real, even: int, frequency: Real, rate: float) -> Real:
    time = np.arange(sequences.shape[1]) - 0.5 * (sequences.shape[1] - 1)
    phase = 2.0 * np.pi * np.outer(frequency, time) / rate
    return np.concatenate([np.cos(phase) @ sequences[:even].T, np.sin(phase) @ sequences[even:].T], axis=1)
