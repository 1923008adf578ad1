"""Filters that follow the temperature, in 16-bit integers."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.rendering.following import FollowingBank, TiltBank

Short = NDArray[np.int16]
LARGEST_SHORT = 32_767
"""Of int16; its negative is used as the least, so that signs are symmetric."""


@dataclass(frozen=True)
class FixedPoint:
    """Banks, taps and signals of 16 bits.

    Attributes
    ----------
    banks : (N, K, M) int16 ndarray
    bank_scale : (N, K) ndarray
        V per unit of audio signal of one count of `banks`.
    tap_scale : float
        V per unit of audio signal of one count of a tap, the same for all actuators and temperatures.
    shift : int
        Bits by which the sum of tap times sample is shifted to the right to make an output of 16 bits, so that no
        input whatever overflows it.
    tilt_banks : (N, 4, K', M) int16 ndarray or None
        Of `TiltBank`.
    tilt_scale : (N, 4, K') ndarray or None
        Value of one count of `tilt_banks`.
    """

    banks: Short
    bank_scale: Real
    tap_scale: float
    shift: int
    tilt_banks: Short | None = None
    tilt_scale: Real | None = None

    @classmethod
    def of(cls, following: FollowingBank, tilt: TiltBank | None = None, temperatures: int = 241) -> Self:
        """Round a bank; how large its taps become is looked up at so many temperatures of its range."""
        banks, scale = _rounded(following.banks)
        every = np.linspace(*following.input.temperature_range, temperatures)
        taps = following.taps(every)
        largest, whole = float(np.abs(taps).max()), float(np.abs(taps).sum(axis=2).max())
        if tilt is not None:
            largest, whole = tilt.loudest(every, taps)
        tap_scale = 1.001 * max(largest, float(np.finfo(np.float32).tiny)) / LARGEST_SHORT
        # The sum of |tap| bounds the output whatever the input is: -32768 at every sample, in the worst order.
        loudest = 32_768.0 * (whole / tap_scale + 0.5 * taps.shape[2])
        shift = max(0, int(np.ceil(np.log2(loudest / (LARGEST_SHORT - 1)))))
        return cls(banks, scale, tap_scale, shift, *(() if tilt is None else _rounded(tilt.banks)))

    @property
    def volts_per_count(self) -> float:
        """Volts of one count of the output, where full scale of the input is one unit of audio signal."""
        return self.tap_scale * 2.0**self.shift / 32_768.0

    def taps(self, following: FollowingBank, temperature: Real) -> Short:
        """Taps (T, N, M) that the program on the target computes, in counts."""
        weights = following.weights.at(following.input.at(temperature)) * self.bank_scale
        volts = np.einsum("tnk,nkm->tnm", weights, self.banks.astype(float))
        counts: Short = np.clip(np.round(volts / self.tap_scale), -LARGEST_SHORT, LARGEST_SHORT).astype(np.int16)
        return counts


def _rounded(banks: Real) -> tuple[Short, Real]:
    """Return banks (..., M) in counts, and the value (...) of one count of each."""
    peak = np.abs(banks).max(axis=-1)
    scale = np.where(peak > 0.0, peak, 1.0) / LARGEST_SHORT
    return np.round(banks / scale[..., None]).astype(np.int16), scale
