"""What an input module makes of a voltage: delay, coupling, noise, clipping, codes."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, oaconvolve

from drivers.ni.modules import InputModule

_BETA = 8.0
"""Kaiser window of the delay's filter: flat within 0.01 dB to 0.45 of the rate."""


def delay_taps(module: InputModule, sample_rate: float) -> NDArray[np.float64]:
    """Return the causal filter that stands for the module's decimation filter.

    A sinc, shifted by the module's delay and windowed around its centre, so that it never looks
    ahead: the delay of a 9234 is 38.4 samples and a little, not a whole number.

    Returns
    -------
    (L,) ndarray
    """
    delay = module.delay(sample_rate) * sample_rate
    half = np.floor(delay)
    offset = np.arange(2 * int(half) + 1) - delay
    inside = np.clip(1.0 - (offset / (half + 1.0)) ** 2, 0.0, None)
    taps = np.sinc(offset) * np.i0(_BETA * np.sqrt(inside)) / np.i0(_BETA)
    return np.asarray(taps / taps.sum())


def coupled(volts: NDArray[np.float64], corner: float, sample_rate: float) -> NDArray[np.float64]:
    """Return what passes a coupling capacitor that has been on 0 V before: a high-pass of first order.

    Parameters
    ----------
    volts : (..., M) ndarray
        V.
    corner : float
        Frequency of 3 dB attenuation, Hz.
    sample_rate : float
        Hz.

    Returns
    -------
    (..., M) ndarray
        V.
    """
    numerator, denominator = butter(1, corner, btype="highpass", fs=sample_rate)
    return np.asarray(lfilter(numerator, denominator, volts, axis=-1))


def delayed(volts: NDArray[np.float64], module: InputModule, sample_rate: float) -> NDArray[np.float64]:
    """Return voltages as they come out of the module's filter, 0 V before the first.

    Parameters
    ----------
    volts : (C, M) ndarray
        V.
    sample_rate : float
        Hz.

    Returns
    -------
    (C, M) ndarray
        V; late by the module's delay, see `delay_taps`.
    """
    taps = delay_taps(module, sample_rate)
    return np.asarray(oaconvolve(volts, taps[None], axes=1)[:, : volts.shape[1]])


def digitised(volts: NDArray[np.float64], module: InputModule, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return voltages with the module's noise, clipped at its full scale, rounded to its codes.

    Parameters
    ----------
    volts : (C, M) ndarray
        V.
    rng : numpy.random.Generator
        Of the noise.

    Returns
    -------
    (C, M) ndarray
        V; whole multiples of the module's quantum.
    """
    # Drawn sample by sample, not channel by channel: a longer record then begins like a shorter one.
    noisy = volts + module.noise * rng.standard_normal(volts.shape[::-1]).T
    codes = np.clip(np.round(noisy / module.quantum), -(2 ** (module.bits - 1)), 2 ** (module.bits - 1) - 1)
    return np.asarray(codes * module.quantum)
