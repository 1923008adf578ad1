"""Uniformly partitioned convolution of one signal with several filters, block by block.

Overlap-save: filters are cut into partitions as long as a block, and every block of the input is transformed once,
whatever filters it meets later. A set of filters can be exchanged between two blocks, the input's past being kept
(Wefers, Partitioned convolution algorithms for real-time auralization, 2015).
"""

from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Complex, Real


def partitions(taps: Real, block: int) -> Complex:
    """Transform filters (N, M), cut into P partitions of `block` samples: (P, N, block + 1)."""
    actuators, count = taps.shape
    parts = -(-count // block)
    padded = np.zeros((actuators, parts * block))
    padded[:, :count] = taps
    spectra: Complex = np.fft.rfft(padded.reshape(actuators, parts, block), 2 * block).transpose(1, 0, 2)
    return np.ascontiguousarray(spectra)


@dataclass
class Past:
    """Transformed blocks of an input, the latest first.

    Attributes
    ----------
    block : int
        Samples of a block.
    parts : int
        Blocks kept: as many as filters have partitions.
    """

    block: int
    parts: int
    _spectra: Complex = field(init=False, repr=False)
    _last: Real = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._spectra = np.zeros((self.parts, self.block + 1), dtype=complex)
        self._last = np.zeros(self.block)

    def take(self, samples: Real) -> None:
        """Add a block (block,) of the input."""
        self._spectra[1:] = self._spectra[:-1]
        self._spectra[0] = np.fft.rfft(np.concatenate([self._last, samples]))
        self._last = samples

    def through(self, filters: Complex) -> Real:
        """Return what `filters` (P, N, block + 1) make of the latest block: (N, block)."""
        return latest(self.product(filters), self.block)

    def product(self, filters: Complex) -> Complex:
        """Return the spectrum (N, block + 1) of that, to be added to others before `latest`."""
        product: Complex = (filters * self._spectra[:, None]).sum(axis=0)
        return product


def latest(spectra: Complex, block: int) -> Real:
    """Return samples (N, block) of the latest block, from spectra (N, block + 1)."""
    filtered: Real = np.fft.irfft(spectra, 2 * block)[:, block:]
    return filtered
