"""One stretch of drive and response: which temperature explains it, and how surely.

The response of a patch is y = g Σₙ hₙ(T) * uₙ + noise, the drives uₙ of the others known, the gain g not.
For every temperature of a grid the twin's answer to the drives is computed, with what they did before the stretch,
cut to the stretch and transformed; the one that leaves the least noise-weighted error at its own best gain is
refined between the grid's temperatures by Gauss and Newton. The power of the noise is that of what is left,
smoothed over lines.
"""

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes

TIME_BEFORE, TIME_AFTER = 0.5, 0.1
"""Seconds of drive ahead of a stretch, whose ringing reaches into it, and behind, over which it is faded out."""
SMOOTHED_LINES = 40
"""Lines to either side over which the power of the noise is averaged."""
LEAST_EXPLAINED = 0.5
"""Share of the response's energy below which it is not this panel's."""


class PatchResponse(Protocol):
    """A panel whose sensing patch can be computed."""

    def transfer(self, temperature: float, frequency: Real) -> Complex:
        """Response (N, F) of the sensing patch to each of N drives at a temperature, °C."""


@dataclass(frozen=True)
class ThermometerReading:
    """Result of one stretch.

    Attributes
    ----------
    temperature, sigma : float
        Degrees Celsius, and one standard deviation by the noise that was seen; NaN where refused.
    gain : float
        Response over what the twin answers, sign included.
    explained : float
        Share of the response's energy in the band that the twin explains.
    refused : str
        Why there is no temperature; empty where there is one.
    """

    temperature: float
    sigma: float
    gain: float
    explained: float
    refused: str = ""


@dataclass(frozen=True)
class Listener:
    """A panel's answers at a grid of temperatures, ready for stretches of one length.

    Attributes
    ----------
    temperature : (T,) ndarray
        Ascending, evenly spaced, degrees Celsius.
    transfer : (T, N, K) ndarray
        At the lines of a stretch with what is before and after it.
    sample_rate : float
        Hz.
    band : (float, float)
        Hz.
    frame : int
        Samples of a stretch.
    largest_sigma : float
        K above which a reading is refused.
    """

    temperature: Real
    transfer: Complex
    sample_rate: float
    band: tuple[float, float]
    frame: int
    largest_sigma: float = 1.0

    def __post_init__(self) -> None:
        check_shapes(self, temperature="T", transfer="T N K")
        check_finite(self, "transfer")
        check_ascending(self, "temperature")

    @classmethod
    def of(
        cls,
        panel: PatchResponse,
        temperature: Real,
        sample_rate: float,
        band: tuple[float, float],
        seconds: float = 1.0,
        largest_sigma: float = 1.0,
    ) -> Self:
        """Compute the responses of a panel over temperature.

        Parameters
        ----------
        temperature : (T,) ndarray, °C
            Ascending, evenly spaced.
        sample_rate : float
            Hz.
        band : (float, float)
            Hz.
        seconds : float
            Length of a stretch, s.
        largest_sigma : float
            K above which a reading is refused.

        Returns
        -------
        Listener
        """
        frame = round(seconds * sample_rate)
        lines, _ = _lines(_whole(frame, sample_rate), sample_rate, band)
        answers = np.array([panel.transfer(float(t), lines) for t in temperature])
        return cls(temperature, answers, sample_rate, band, frame, largest_sigma)

    @property
    def before(self) -> int:
        """Samples of drive that have to be known ahead of a stretch."""
        return round(TIME_BEFORE * self.sample_rate)

    @property
    def whole(self) -> int:
        """Samples of drive in all."""
        return _whole(self.frame, self.sample_rate)

    def read(self, drive: Real, response: Real) -> ThermometerReading:
        """Estimate the temperature.

        Parameters
        ----------
        drive : (N, whole) ndarray
        response : (frame,) ndarray
            From sample `before` of the drive on.
        """
        _, inside = _lines(self.frame, self.sample_rate, self.band)
        measured = np.fft.rfft(self._window * response)[inside]
        energy = float(np.sum(np.abs(measured) ** 2))
        answers = self._answers(drive)[:, inside]
        if not energy > 0.0 or not np.sum(np.abs(answers) ** 2) > 0.0:
            return ThermometerReading(np.nan, np.nan, np.nan, 0.0, "silence in the band")
        noise = np.full(len(measured), energy / len(measured))
        for _ in range(3):
            best = _nearest(answers, measured, noise)
            rest = measured - best.gain * answers[best.place]
            noise = _smoothed(np.abs(rest) ** 2)
        return self._judged(answers, measured, noise, _nearest(answers, measured, noise).place)

    def _judged(self, answers: Complex, measured: Complex, noise: Real, place: int) -> ThermometerReading:
        near = slice(max(place - 4, 0), place + 5)
        spline = CubicSpline(self.temperature[near], answers[near])
        low, high = (self.temperature[max(place - 1, 0)], self.temperature[min(place + 1, len(answers) - 1)])
        t = float(self.temperature[place])
        for _ in range(8):
            value, slope = spline(t), spline(t, 1)
            gain = _inner(value, measured, noise) / _inner(value, value, noise)
            across = slope - value * (_inner(value, slope, noise) / _inner(value, value, noise))
            bend = gain * _inner(across, across, noise)
            t = float(np.clip(t + _inner(across, measured - gain * value, noise) / bend, low, high))
        value = spline(t)
        gain = _inner(value, measured, noise) / _inner(value, value, noise)
        rest = measured - gain * value
        explained = 1.0 - float(np.sum(np.abs(rest) ** 2) / np.sum(np.abs(measured) ** 2))
        information = 2.0 * gain**2 * _inner(across, across, _smoothed(np.abs(rest) ** 2))
        sigma = float(np.sqrt(self._correlation / information)) if information > 0.0 else np.inf
        refused = ""
        if explained < LEAST_EXPLAINED:
            refused = f"the panel explains {100 * explained:.0f} % of the response"
        elif not sigma <= self.largest_sigma:
            refused = f"too little energy where the response moves with temperature (sigma {sigma:.2g} K)"
        elif not self.temperature[0] < t < self.temperature[-1]:
            refused = f"the nearest temperature is the end of the range, {t:g} °C"
        if refused:
            return ThermometerReading(np.nan, np.nan, gain, explained, refused)
        return ThermometerReading(t, sigma, gain, explained)

    def _answers(self, drive: Real) -> Complex:
        """Lines (T, F) of what the twin answers in the stretch, at every temperature of the grid."""
        _, inside = _lines(self.whole, self.sample_rate, self.band)
        faded = np.ones(self.whole)
        up, down = self.before // 2, round(TIME_AFTER * self.sample_rate)
        faded[:up] = np.sin(0.5 * np.pi * np.arange(up) / up) ** 2
        faded[len(faded) - down :] = np.cos(0.5 * np.pi * np.arange(down) / down) ** 2
        played = np.fft.rfft(faded * drive)[:, inside]
        spectrum = np.zeros((len(self.temperature), self.whole // 2 + 1), dtype=complex)
        spectrum[:, inside] = np.einsum("tnk,nk->tk", self.transfer, played)
        answer = np.fft.irfft(spectrum, self.whole)[:, self.before : self.before + self.frame]
        lines: Complex = np.fft.rfft(self._window * answer)
        return lines

    @property
    def _window(self) -> Real:
        """Squared-sine edges of an eighth of the stretch each."""
        edge = self.frame // 8
        window = np.ones(self.frame)
        window[:edge] = np.sin(0.5 * np.pi * (np.arange(edge) + 0.5) / edge) ** 2
        window[-edge:] = window[:edge][::-1]
        return window

    @property
    def _correlation(self) -> float:
        """Number of lines of windowed, correlated noise with the information of one of unwindowed noise."""
        power = self._window**2
        return float(self.frame * np.sum(power**2) / np.sum(power) ** 2)


@dataclass(frozen=True)
class _Nearest:
    place: int
    gain: float


def _nearest(answers: Complex, measured: Complex, noise: Real) -> _Nearest:
    weighted = answers.conj() / noise
    common = (weighted @ measured).real
    own = np.sum(weighted * answers, axis=1).real
    place = int(np.argmax(common**2 / own))
    return _Nearest(place, float(common[place] / own[place]))


def _inner(one: Complex, other: Complex, noise: Real) -> float:
    return float(np.sum((one.conj() * other).real / noise))


def _smoothed(power: Real) -> Real:
    """Mean of neighbouring lines; at the ends, of those there are. Never zero."""
    wide = np.ones(2 * SMOOTHED_LINES + 1)
    mean = np.convolve(power, wide, "same") / np.convolve(np.ones(len(power)), wide, "same")
    found: Real = np.maximum(mean, 1e-12 * mean.max() + np.finfo(float).tiny)
    return found


def _whole(frame: int, sample_rate: float) -> int:
    return round(TIME_BEFORE * sample_rate) + frame + round(TIME_AFTER * sample_rate)


def _lines(count: int, sample_rate: float, band: tuple[float, float]) -> tuple[Real, NDArray[np.bool_]]:
    """Lines of a transform of `count` samples inside the band, Hz, and which of all they are."""
    every: Real = np.fft.rfftfreq(count, 1.0 / sample_rate).astype(np.float64)
    inside = (every >= band[0]) & (every <= band[1])
    return every[inside], inside
