"""FIR filters by inverse FFT, with modelling delay and band taper, and the energy that truncation loses."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.focusing.panel import Filters


@dataclass(frozen=True)
class FirBank:
    """One FIR filter per temperature and actuator.

    Attributes
    ----------
    taps : (T, N, M) ndarray
        V per unit of audio signal.
    temperature : (T,) ndarray
        Degrees Celsius.
    sample_rate : float
        Hz.
    delay : int
        Modelling delay in `taps`, samples.
    """

    taps: Real
    temperature: Real
    sample_rate: float
    delay: int

    def __post_init__(self) -> None:
        if self.taps.ndim != 3 or self.temperature.shape != self.taps.shape[:1]:
            raise ValueError(
                f"taps {self.taps.shape} and temperature {self.temperature.shape}: (T, N, M) and (T,)"
            )
        if not 0 <= self.delay < self.taps.shape[-1]:
            raise ValueError(f"delay {self.delay} samples is outside the {self.taps.shape[-1]} taps")

    def response(self, frequency: Real) -> Complex:
        """Frequency response (T, F, N) at `frequency` (F,), Hz, with the modelling delay removed."""
        time = (np.arange(self.taps.shape[-1]) - self.delay) / self.sample_rate
        phase = 2.0 * np.pi * np.outer(time, frequency)
        temperatures, actuators, length = self.taps.shape
        every = self.taps.reshape(-1, length)
        response = np.empty((temperatures, len(phase[0]), actuators), dtype=complex)
        # Two real products instead of one complex: the taps are real.
        for part, turn in ((response.real, np.cos(phase)), (response.imag, -np.sin(phase))):
            part[...] = (every @ turn).reshape(temperatures, actuators, -1).transpose(0, 2, 1)
        return response


@dataclass(frozen=True)
class FirEnergy:
    """Distribution of the untruncated impulse responses' energy, as shares of the whole, each (T, N).

    Attributes
    ----------
    before : ndarray
        Before the first tap: lost, because a causal filter cannot respond before its input.
    inside : ndarray
        Within the taps.
    after : ndarray
        After the last tap: lost ringing.
    pre_ringing : ndarray
        Within the taps, but before the modelling delay: pre-echo.
    """

    before: Real
    inside: Real
    after: Real
    pre_ringing: Real

    def __post_init__(self) -> None:
        check_shapes(self, before="T N", inside="T N", after="T N", pre_ringing="T N")


def taper(frequency: Real, settings: Filters) -> Real:
    """Gain (F,): 1 in the band, falling as a squared sine to 0 at the edges."""
    (low, high), (foot, head) = settings.band, settings.edges
    gain = ((frequency >= foot) & (frequency <= head)).astype(float)
    if low > foot:
        gain *= np.sin(0.5 * np.pi * np.clip((frequency - foot) / (low - foot), 0.0, 1.0)) ** 2
    if head > high:
        gain *= np.cos(0.5 * np.pi * np.clip((frequency - high) / (head - high), 0.0, 1.0)) ** 2
    return gain


def inverse_fft(filters: Complex, temperature: Real, settings: Filters, delay: int) -> FirBank:
    """Truncate filters to taps by the inverse FFT, as in the paper.

    Parameters
    ----------
    filters : (T, F, N) ndarray
        At `settings.frequency`, V per unit of audio signal.
    temperature : (T,) ndarray, °C
    delay : int
        Modelling delay, samples.

    Returns
    -------
    FirBank
        `settings.taps` taps of each filter.

    Notes
    -----
    Tap m is the inverse FFT of taper · R · exp(-j2πf·delay/fs) at sample m, evaluated for the taps alone: 512 of
    the 16384 samples of the fine transform.
    """
    spectrum = _spectrum(filters, settings)
    count = settings.taps
    time = (np.arange(count) - delay) / settings.sample_rate
    phase = 2.0 * np.pi * np.outer(settings.frequency, time)
    turned = spectrum.transpose(0, 2, 1)
    taps = turned.real @ np.cos(phase) - turned.imag @ np.sin(phase)
    return FirBank(2.0 / settings.transform_length * taps, temperature, settings.sample_rate, delay)


def energy(filters: Complex, settings: Filters, delay: int) -> FirEnergy:
    """Distribution of the untruncated impulse responses' energy about the taps.

    Parameters
    ----------
    filters : (T, F, N) ndarray
        At the lines of `settings`.
    delay : int
        Modelling delay, samples.
    """
    temperatures, _, actuators = filters.shape
    squares = [np.square(impulse) for impulse in _impulses(filters, settings)]
    taps, length = settings.taps, settings.transform_length
    # The transform is periodic: sample 0 is time 0, and the samples outside the taps are divided evenly.
    turned = np.roll(np.array(squares), delay, axis=-1).reshape(temperatures, actuators, length)
    middle = taps + (length - taps) // 2
    whole = np.maximum(turned.sum(axis=-1), np.finfo(float).tiny)
    return FirEnergy(
        before=turned[..., middle:].sum(axis=-1) / whole,
        inside=turned[..., :taps].sum(axis=-1) / whole,
        after=turned[..., taps:middle].sum(axis=-1) / whole,
        pre_ringing=turned[..., :delay].sum(axis=-1) / whole,
    )


def suited_delay(filters: Complex, settings: Filters) -> int:
    """Modelling delay, samples, for which the taps contain most of the energy of `filters` (T, F, N).

    STIF rings as long as it pre-rings; time reversal only pre-rings, and half the taps would lose most of it.
    """
    squares = sum(np.square(impulse).sum(axis=0) for impulse in _impulses(filters, settings))
    # Sample -d first: the window of a delay d holds the samples -d to taps - 1 - d.
    around = np.concatenate([squares[-(settings.taps - 1) :], squares[: settings.taps]])
    held = np.convolve(around, np.ones(settings.taps), mode="valid")[::-1]
    return int(np.argmax(held))


def _impulses(filters: Complex, settings: Filters) -> Iterator[Real]:
    """Untruncated impulse responses (N, transform_length), one temperature at a time to save memory."""
    lines = np.round(settings.frequency * settings.transform_length / settings.sample_rate).astype(int)
    for spectrum in _spectrum(filters, settings):
        full = np.zeros((filters.shape[2], settings.transform_length // 2 + 1), dtype=complex)
        full[:, lines] = spectrum.T
        yield np.fft.irfft(full, settings.transform_length)


def _spectrum(filters: Complex, settings: Filters) -> Complex:
    frequency = settings.frequency
    if filters.ndim != 3 or filters.shape[1] != len(frequency):
        raise ValueError(
            f"filters {filters.shape} must be (T, F, N) at the {len(frequency)} lines of the settings"
        )
    spectrum: Complex = filters * taper(frequency, settings)[None, :, None]
    return spectrum
