"""Windows: over the segments of a stationary signal, and over a blow and its ring-down."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Shape = Literal["rectangular", "hann", "hamming", "blackman", "flattop"]


def segment_window(shape: Shape, samples: int) -> NDArray[np.float64]:
    """Window of a segment, periodic: (samples,) ndarray, 1 at its highest."""
    from scipy.signal import get_window  # a third of a verb's start, and seldom needed

    name = "boxcar" if shape == "rectangular" else shape
    window: NDArray[np.float64] = np.asarray(get_window(name, samples), dtype=float)
    window /= window.max()
    return window


def effective_averages(window: NDArray[np.float64], step: int, segments: int) -> float:
    """Return the number of independent segments with the information of overlapping ones.

    Welch, IEEE Trans. Audio Electroacoust. 15, 1967, eq. 10: neighbours share samples, by the window's own
    correlation at the step between them.

    Parameters
    ----------
    window : (M,) ndarray
    step : int
        Samples from one segment to the next.

    Returns
    -------
    float
        1 to `segments`.
    """
    length = len(window)
    energy = float((window**2).sum())
    doubled = 0.0
    for k in range(1, segments):
        if k * step >= length:
            break
        rho = float((window[: length - k * step] * window[k * step :]).sum()) / energy
        doubled += (1.0 - k / segments) * rho**2
    return segments / (1.0 + 2.0 * doubled)


@dataclass(frozen=True)
class RingdownWindow:
    """An exponential over drive and response of a blow, which takes leakage away and adds damping that is known.

    With exp(-rate t) on both, what is estimated is H(s + rate), exactly: every pole lies `rate` further left.

    Attributes
    ----------
    rate : float
        1/s; 0 for none.
    """

    rate: float = 0.0

    @classmethod
    def falling_to(cls, end: float, seconds: float) -> "RingdownWindow":
        """Return the window that has fallen to `end`, above 0 and at most 1, after `seconds`."""
        if not 0.0 < end <= 1.0:
            raise ValueError(f"exponential window to {end:g} at the end; above 0 to 1 allowed")
        return cls(-float(np.log(end)) / seconds)

    def values(self, samples: int, sample_rate: float) -> NDArray[np.float64]:
        """Window over a block, (samples,) ndarray."""
        decay: NDArray[np.float64] = np.exp(-self.rate * np.arange(samples) / sample_rate)
        return decay


def force_window(samples: int, begin: int, end: int) -> NDArray[np.float64]:
    """Window of 1 over a blow and 0 elsewhere, with cosine flanks: drops the noise after it.

    The flanks are as long as what is kept, and lie outside it: a soft tip's force ends slowly. Flanks of an eighth
    took 0.5 % of the spectrum of a raised cosine and 6 % of that of a Gaussian pulse, these 0.01 and 0.1 %.

    Parameters
    ----------
    begin, end : int
        First and last sample kept whole.

    Returns
    -------
    (samples,) ndarray
    """
    flank = max(end - begin, 4)
    place = np.arange(samples)
    outside = np.maximum(np.maximum(begin - place, place - end), 0)
    kept: NDArray[np.float64] = np.where(
        outside < flank, 0.5 * (1.0 + np.cos(np.pi * np.minimum(outside, flank) / flank)), 0.0
    )
    return kept


def without_window(
    poles: NDArray[np.complex128], covariance: NDArray[np.float64], rate: float
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Take the damping of an exponential window out of poles.

    Parameters
    ----------
    poles : (J,) complex ndarray
        As identified, rad/s.
    covariance : (J, 2, 2) ndarray
        Of log |pole| and log damping ratio.
    rate : float
        Of the window, 1/s.

    Returns
    -------
    poles : (J,) complex ndarray
        `rate` further right. Those that would not decay are left with a thousandth of the damping they had: the
        damping by the window hid theirs, and their covariance is large.
    covariance : (J, 2, 2) ndarray
        The same deviation of the pole in the complex plane: relative to what is left of the damping, more.
    """
    real = np.minimum(poles.real + rate, 1e-3 * poles.real)
    moved = real + 1j * poles.imag
    jacobian = np.linalg.inv(_pole_of_logs(moved)) @ _pole_of_logs(poles)
    known = np.asarray(np.isfinite(covariance).all(axis=(1, 2)))  # infinity times a derivative of 0 is no number
    spread: NDArray[np.float64] = np.where(known[:, None, None], covariance, 0.0)
    spread = jacobian @ spread @ jacobian.transpose(0, 2, 1)
    spread[~known] = covariance[~known]
    return moved, spread


def _pole_of_logs(poles: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the derivatives of real and imaginary part by log |pole| and log damping ratio, (J, 2, 2)."""
    w, zeta = np.abs(poles), -poles.real / np.abs(poles)
    by_w = np.stack([poles.real, poles.imag])
    by_zeta = np.stack([poles.real, -w * zeta**2 / np.sqrt(1.0 - zeta**2)])
    return np.stack([by_w, by_zeta], axis=1).transpose(2, 0, 1)
