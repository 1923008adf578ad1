"""A panel as its own thermometer: temperature from what one of its patches answers while the others play.

Which temperature explains a stretch of drive and response, how surely, and readings tracked over time.

The response of a patch is y = g Σₙ hₙ(T) * uₙ + noise, the drives uₙ of the others known, the gain g not.
For every temperature of a grid the twin's answer to the drives is computed, with what they did before the stretch,
cut to the stretch and transformed; the one that leaves the least noise-weighted error at its own best gain is
refined between the grid's temperatures by Gauss and Newton. The power of the noise is that of what is left,
smoothed over lines. Signals are brought to the low sample rate that the band needs first.
"""

from dataclasses import dataclass, field
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.signal import cheby2, sosfilt

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_finite, check_shapes
from analysis.rendering.following import TemperatureProgramme


@dataclass
class Decimator:
    """Keeps every `factor`-th sample of channels, block by block, with what would be folded back filtered out.

    Drive and response have to go through the same filter: it then changes nothing of what joins them.

    Attributes
    ----------
    channels : int
    sample_rate : float
        Before, Hz.
    highest : float
        Of the band, Hz: up to there nothing is lost or folded back.
    """

    channels: int
    sample_rate: float
    highest: float
    _state: Real = field(init=False, repr=False)
    _seen: int = field(init=False, default=0, repr=False)

    def __post_init__(self) -> None:
        self._state = np.zeros((len(self._sections), self.channels, 2))

    @property
    def factor(self) -> int:
        """Samples of which one is kept: the new rate is 2.56 times the band, or a little more."""
        return max(1, int(self.sample_rate / (2.56 * self.highest)))

    @property
    def rate(self) -> float:
        """Sample rate after, Hz."""
        return self.sample_rate / self.factor

    @property
    def _sections(self) -> Real:
        if self.factor == 1:
            return np.array([[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]])
        # 80 dB down where what is folded back would reach the band.
        edge = 2.0 * (self.rate - self.highest) / self.sample_rate
        sections: Real = cheby2(12, 80.0, edge, output="sos")
        return sections

    def take(self, samples: Real) -> Real:
        """Filter a block (channels, n) and return the samples kept of it."""
        filtered, self._state = sosfilt(self._sections, samples, axis=-1, zi=self._state)
        first = -self._seen % self.factor
        self._seen += samples.shape[1]
        kept: Real = filtered[:, first :: self.factor]
        return kept


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


@dataclass
class Track:
    """Temperature and its rate, the rate wandering at random (integrated white noise).

    Attributes
    ----------
    wander : float
        Standard deviation of what the rate gains in a second, K/s.
    first_rate : float
        Standard deviation of the rate at the beginning, K/s.
    gate : float
        Standard deviations beyond which a reading is passed over; three such readings on end begin the track anew.
    """

    wander: float = 0.002
    first_rate: float = 0.05
    gate: float = 5.0
    _state: Real = field(init=False, default_factory=lambda: np.full(2, np.nan), repr=False)
    _covariance: Real = field(init=False, default_factory=lambda: np.zeros((2, 2)), repr=False)
    _strange: int = field(init=False, default=0, repr=False)

    @property
    def temperature(self) -> float:
        """Degrees Celsius; NaN before the first reading."""
        return float(self._state[0])

    @property
    def sigma(self) -> float:
        """One standard deviation, K; infinite before the first reading."""
        return float(np.sqrt(self._covariance[0, 0])) if self._known else np.inf

    @property
    def _known(self) -> bool:
        return bool(np.isfinite(self._state[0]))

    def step(self, reading: ThermometerReading, seconds: float) -> None:
        """Predict `seconds` ahead and update with the reading there; a refused reading is not used."""
        if self._known:
            move = np.array([[1.0, seconds], [0.0, 1.0]])
            s = seconds
            noise = self.wander**2 * np.array([[s**3 / 3.0, s**2 / 2.0], [s**2 / 2.0, s]])
            self._state = move @ self._state
            self._covariance = move @ self._covariance @ move.T + noise
        if reading.refused:
            return
        variance = reading.sigma**2
        beyond = reading.temperature - self.temperature
        if self._known and beyond**2 > self.gate**2 * (self._covariance[0, 0] + variance):
            self._strange += 1
            if self._strange < 3:
                return
        if not self._known or self._strange:
            if not self._known or self._strange >= 3:
                self._state = np.array([reading.temperature, 0.0])
                self._covariance = np.diag([variance, self.first_rate**2])
                self._strange = 0
                return
            self._strange = 0
        gain = self._covariance[:, 0] / (self._covariance[0, 0] + variance)
        self._state = self._state + gain * beyond
        self._covariance = self._covariance - np.outer(gain, self._covariance[0])


STATE_SPACING = 1.0
"""Seconds between the temperatures at which the panel is asked; in between its answers are mixed."""
RINGING_TIME = 1.0
"""Seconds of drive ahead that still ring."""


def simulated_response(
    panel: PatchResponse,
    drive: Real,
    sample_rate: float,
    band: tuple[float, float],
    programme: TemperatureProgramme,
    signal_to_noise: float,
    rng: np.random.Generator,
) -> Real:
    """Response of the sensing patch to drives, with white noise.

    The panel answers in the band only; it is linear, and slower in its temperature than in its ringing.

    Parameters
    ----------
    drive : (N, n) ndarray, V
    sample_rate : float
        Hz.
    band : (float, float)
        Hz.
    signal_to_noise : float
        dB.
    rng : numpy Generator
        Draws the noise.

    Returns
    -------
    (n,) ndarray, V
    """
    step, memory = round(STATE_SPACING * sample_rate), round(RINGING_TIME * sample_rate)
    behind = memory // 4
    length = memory + 2 * step + behind
    response = np.zeros(drive.shape[1] + 3 * step)
    padded = np.pad(drive, ((0, 0), (memory + step, 3 * step + behind)))
    lines: Real = np.fft.rfftfreq(length, 1.0 / sample_rate).astype(np.float64)
    inside = (lines >= band[0]) & (lines <= band[1])
    ramp = np.arange(step) / step
    share = np.concatenate([ramp, 1.0 - ramp])
    faded = np.ones(length)
    faded[: memory // 2] = np.sin(0.5 * np.pi * np.arange(memory // 2) / (memory // 2)) ** 2
    faded[length - behind :] = np.cos(0.5 * np.pi * np.arange(behind) / behind) ** 2
    for first in range(-step, drive.shape[1], step):
        middle = (first + step) / sample_rate
        block = padded[:, first + step : first + step + length] * faded
        spectrum = np.zeros(len(lines), dtype=complex)
        transfer = panel.transfer(float(programme.at(middle)), lines[inside])
        spectrum[inside] = np.sum(transfer * np.fft.rfft(block)[:, inside], axis=0)
        answer = np.fft.irfft(spectrum, length)[memory : memory + 2 * step] * share
        response[first + step : first + 3 * step] += answer
    clean = response[step : step + drive.shape[1]]
    level = np.sqrt(np.mean(clean**2)) * 10.0 ** (-signal_to_noise / 20.0)
    noisy: Real = clean + level * rng.standard_normal(len(clean))
    return noisy
