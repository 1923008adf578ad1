"""Audio and temperature in, one signal per actuator out, by uniformly partitioned convolution.

Overlap-save: filters are cut into partitions as long as a block, and every block of the input is transformed once,
whatever filters it meets later. A set of filters can be exchanged between two blocks, the input's past being kept
(Wefers, Partitioned convolution algorithms for real-time auralization, 2015).
"""

from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Complex, Real
from analysis.rendering.following import FADE_TIME, TEMPERATURE_STEP, FollowingBank, raised_cosine
from analysis.weather.family import Across, TiltFamily


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


@dataclass
class Renderer:
    """Filters audio in blocks; the exported C code does the same.

    Attributes
    ----------
    filters : FollowingBank
    temperature : float
        Of the filters in use, or faded to, degrees Celsius. At first, that of the first block.
    across : (float, float)
        Tilt of the panel for which they are, along x and y, K.
    block : int
        Samples of a block.
    family : TiltFamily, optional
        Filters of tilted panels, by which a tilt is followed; the exported C code has none.
    changes : int
        Fades begun so far.
    """

    filters: FollowingBank
    temperature: float
    block: int = 512
    family: TiltFamily | None = None
    across: Across = (0.0, 0.0)
    changes: int = 0
    _past: Past = field(init=False, repr=False)
    _now: Complex = field(init=False, repr=False)
    _before: Complex = field(init=False, repr=False)
    _faded: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.block < 1:
            raise ValueError(f"block {self.block} samples; allowed: 1 or more")
        self.temperature = self._inside(self.temperature)
        self._now = self._before = self._spectra()
        self._past = Past(self.block, len(self._now))
        self._faded = self._fade

    @property
    def _fade(self) -> int:
        return round(FADE_TIME * self.filters.sample_rate)

    def follow(self, temperature: float, across: Across = (0.0, 0.0)) -> bool:
        """Take a temperature, °C, and a tilt, K; return whether the filters begin to fade to them. NaN is ignored.

        A reading nearer than `TEMPERATURE_STEP` to the filters in use, at any edge of the panel, or one during a
        fade, changes nothing.
        """
        wanted = self._inside(temperature)
        tilted = 0.5 * max(abs(new - old) for new, old in zip(across, self.across, strict=True))
        moved = abs(wanted - self.temperature) + (tilted if self.family is not None else 0.0)
        if not moved >= TEMPERATURE_STEP or self._faded < self._fade:
            return False
        self.temperature, self.across, self._before, self._faded = wanted, across, self._now, 0
        self._now = self._spectra()
        self.changes += 1
        return True

    def process(self, samples: Real) -> Real:
        """Filter a block (block,) into (N, block), V per unit of the signal.

        Raises
        ------
        ValueError
            For a block of another length.
        """
        if samples.shape != (self.block,):
            raise ValueError(f"a block of {samples.shape} samples; allowed: ({self.block},)")
        self._past.take(samples)
        new = self._past.through(self._now)
        if self._faded >= self._fade:
            return new
        old = self._past.through(self._before)
        share = raised_cosine(self._faded, self.block, self._fade)
        self._faded = min(self._faded + self.block, self._fade)
        return old + share * (new - old)

    def _inside(self, temperature: float) -> float:
        low, high = self.filters.input.temperature_range
        return min(max(temperature, low), high) if temperature == temperature else temperature

    def _spectra(self) -> Complex:
        taps = self.filters.taps(self.temperature)[0]
        if self.family is not None and any(self.across):
            taps = taps + self.family.tilt(self.temperature, self.across)
        return partitions(taps, self.block)


def partitions(taps: Real, block: int) -> Complex:
    """Transform filters (N, M), cut into P partitions of `block` samples: (P, N, block + 1)."""
    actuators, count = taps.shape
    parts = -(-count // block)
    padded = np.zeros((actuators, parts * block))
    padded[:, :count] = taps
    spectra: Complex = np.fft.rfft(padded.reshape(actuators, parts, block), 2 * block).transpose(1, 0, 2)
    return np.ascontiguousarray(spectra)


def latest(spectra: Complex, block: int) -> Real:
    """Return samples (N, block) of the latest block, from spectra (N, block + 1)."""
    filtered: Real = np.fft.irfft(spectra, 2 * block)[:, block:]
    return filtered
