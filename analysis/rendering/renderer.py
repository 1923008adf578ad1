"""Audio and temperature in, one signal per actuator out, by uniformly partitioned convolution; and what is heard.

Overlap-save: filters are cut into partitions as long as a block, and every block of the input is transformed once,
whatever filters it meets later. A set of filters can be exchanged between two blocks, the input's past being kept
(Wefers, Partitioned convolution algorithms for real-time auralization, 2015).

At listeners the same turns volts into pascals. How well the field of a piece of sound is focused while the
temperature moves is the ratio of its energies.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms
from analysis.focusing.panel import Filters
from analysis.focusing.performance import contrast
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


RESPONSE_SAMPLES = 16_384
"""Samples of a response: 0.37 s at 44.1 kHz, in which a mode of 100 Hz and a loss factor of 6 % falls by 60 dB."""
SAMPLES_BEFORE_ZERO = 2_048
"""Samples of a response before its time 0, for the ringing of its band's edges."""
SAMPLES_AT_ONCE = 8_192
"""Samples convolved at a time; also those over which a new response fades in."""
RESPONSE_SPACING = 1.0
"""K between two responses of the panel. Resonances of polypropylene move by a percent, a tenth of their width."""

PanelResponse = Callable[[float, Real], Complex]
"""From the panel's state and frequency (F,), Hz, to pressure (L, F, N), Pa/V. The state of an evenly warm panel is
its temperature, °C; of a panel in a weather it is the time, s, which says its field of temperatures."""
Distance = Callable[[float, float], float]
"""Largest difference of temperature anywhere on the panel between two states, K."""


def between_temperatures(one: float, other: float) -> float:
    """`Distance` of states that are temperatures."""
    return abs(one - other)


@dataclass
class HeardRenderer:
    """Convolves the drive of a panel with its responses at L listeners.

    Attributes
    ----------
    response : callable
        See `PanelResponse`.
    settings : Filters
        Of the panel: the response is known within `twin_band`, and faded out between the edges and its ends.
    state : float
        Of the panel at first, see `PanelResponse`.
    distance : callable, optional
        See `Distance`; beyond `RESPONSE_SPACING` the panel's response is computed anew.
    """

    response: PanelResponse
    settings: Filters
    state: float
    distance: Distance = between_temperatures
    _waiting: list[Real] = field(default_factory=list, repr=False)
    _held: int = 0
    _skipped: int = 0
    _wanted: float = field(init=False, repr=False)
    _spectra: Complex = field(init=False, repr=False)
    _past: list[Past] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._wanted = self.state
        self._spectra = self._partitions(self.state)
        self._past = [Past(SAMPLES_AT_ONCE, self._spectra.shape[1]) for _ in range(len(self._spectra))]

    @property
    def ringing(self) -> int:
        """Samples of sound after the end of the drive."""
        return RESPONSE_SAMPLES - SAMPLES_BEFORE_ZERO

    def take(self, drive: Real, state: float) -> list[Real]:
        """Add drive and return the sound that is ready.

        Parameters
        ----------
        drive : (N, n) ndarray, V
        state : float
            Of the panel, see `PanelResponse`.

        Returns
        -------
        list of (L, n) ndarray
            Pa; n up to `SAMPLES_AT_ONCE`.
        """
        self._wanted = state
        self._waiting.append(drive)
        self._held += drive.shape[1]
        ready = []
        while self._held >= SAMPLES_AT_ONCE:
            whole = np.concatenate(self._waiting, axis=1)
            self._waiting, self._held = [whole[:, SAMPLES_AT_ONCE:]], self._held - SAMPLES_AT_ONCE
            ready.append(self._chunk(whole[:, :SAMPLES_AT_ONCE]))
        return [part for part in map(self._in_time, ready) if part.shape[1]]

    def rest(self) -> list[Real]:
        """Return what is still heard after the last drive; its last samples are those of `ringing`."""
        left, actuators = self._held + self.ringing + self._skipped, len(self._past)
        missing = (
            -(-(self._held + self.ringing + SAMPLES_BEFORE_ZERO) // SAMPLES_AT_ONCE) * SAMPLES_AT_ONCE - self._held
        )
        parts = self.take(np.zeros((actuators, missing)), self._wanted)
        whole = np.concatenate(parts, axis=1)
        return [whole[:, :left]]

    def _in_time(self, sound: Real) -> Real:
        """Leave out the samples before time 0."""
        gone = min(SAMPLES_BEFORE_ZERO - self._skipped, sound.shape[1])
        self._skipped += gone
        return sound[:, gone:]

    def _chunk(self, drive: Real) -> Real:
        for past, samples in zip(self._past, drive, strict=True):
            past.take(samples)
        sound = self._through(self._spectra)
        if self.distance(self._wanted, self.state) >= RESPONSE_SPACING:
            self.state, self._spectra = self._wanted, self._partitions(self._wanted)
            share = (np.arange(SAMPLES_AT_ONCE) + 0.5) / SAMPLES_AT_ONCE
            sound = sound + share * (self._through(self._spectra) - sound)
        return sound

    def _through(self, spectra: Complex) -> Real:
        parts = [past.product(own) for past, own in zip(self._past, spectra, strict=True)]
        return latest(np.asarray(np.sum(parts, axis=0)), SAMPLES_AT_ONCE)

    def _partitions(self, state: float) -> Complex:
        """Return transformed responses (N, P, L, SAMPLES_AT_ONCE + 1)."""
        found = impulse_responses(self.response, self.settings, state)
        return np.array([partitions(found[:, n], SAMPLES_AT_ONCE) for n in range(found.shape[1])])


def impulse_responses(response: PanelResponse, settings: Filters, state: float) -> Real:
    """Responses of L listeners to impulses of N actuators.

    Parameters
    ----------
    response : callable
        See `PanelResponse`.
    state : float
        See `PanelResponse`.

    Returns
    -------
    (L, N, `RESPONSE_SAMPLES`) ndarray
        Pa/V per sample, time 0 at sample `SAMPLES_BEFORE_ZERO`.
    """
    (lowest, highest), (foot, head) = settings.twin_band, settings.edges
    every = np.fft.rfftfreq(RESPONSE_SAMPLES, 1.0 / settings.sample_rate)
    inside = (every >= lowest) & (every <= highest)
    lines = every[inside]
    gain = np.clip((lines - lowest) / (foot - lowest), 0.0, 1.0) * np.clip(
        (highest - lines) / (highest - head), 0.0, 1.0
    )
    gain = np.sin(0.5 * np.pi * gain) ** 2
    known = response(state, np.asarray(lines, dtype=float))
    late = np.exp(-2j * np.pi * lines * SAMPLES_BEFORE_ZERO / settings.sample_rate)
    spectrum = np.zeros((len(known), known.shape[2], len(every)), dtype=complex)
    spectrum[:, :, inside] = (known * (gain * late)[None, :, None]).transpose(0, 2, 1)
    return np.asarray(np.fft.irfft(spectrum, RESPONSE_SAMPLES))


@dataclass(frozen=True)
class FieldContrast:
    """Contrast of the field at one moment, paper eq. (9), literal.

    Attributes
    ----------
    mean, worst : float
        Over the lines of the band.
    sound : float
        Of the sound that is played: energies weighted with its spectrum; NaN where it is silent in the band.
    """

    mean: float
    worst: float
    sound: float


def field_contrast(forms: EnergyForms, filters: Complex, spectrum: Real) -> FieldContrast:
    """Judge filters on a plate, line by line and for a sound.

    Parameters
    ----------
    forms : EnergyForms
        Of one temperature, at the F lines.
    filters : (F, N) ndarray
    spectrum : (F,) ndarray
        Power of the sound.
    """
    lines = contrast(forms, filters)[0]
    whole = np.einsum("fn,fnm,fm->f", filters.conj(), forms.plate[0], filters).real * spectrum
    played = float(whole.sum())
    return FieldContrast(
        mean=float(lines.mean()),
        worst=float(lines.min()),
        sound=float(lines @ whole) / played if played > 0.0 else float("nan"),
    )


def power_spectrum(samples: Real, sample_rate: float, frequency: Real) -> Real:
    """Power of a signal about each of some frequencies.

    Sums of the squared Fourier coefficients from half a spacing below to half above.

    Parameters
    ----------
    samples : (n,) ndarray
    sample_rate : float
        Hz.
    frequency : (F,) ndarray, Hz
        Evenly spaced.

    Returns
    -------
    (F,) ndarray
        In the square of the unit of `samples`.
    """
    power = np.abs(np.fft.rfft(samples)) ** 2
    lines = np.arange(len(power)) * sample_rate / len(samples)
    half = 0.5 * (frequency[1] - frequency[0])
    place = np.searchsorted(np.append(frequency - half, frequency[-1] + half), lines, side="right") - 1
    held = (place >= 0) & (place < len(frequency))
    found: Real = np.bincount(place[held], power[held], len(frequency)) / len(samples) ** 2
    return found
