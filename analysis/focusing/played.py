"""A sweep played through the taps and the panel: contrast in the time domain (paper Fig. 4)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.focusing.design import TapDesign
from analysis.focusing.fir import FirBank, suited_delay
from analysis.focusing.methods import METHODS, Constants, PanelModel, designer
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast

TAIL = 0.5
"""Seconds of silence behind the sweep, in which panel and filters ring out."""
BLOCKS = 100
"""Stretches of the sweep whose energies are told apart."""


@dataclass(frozen=True)
class Played:
    """All methods with taps: lines of the band, and a logarithmic sweep over it in the time domain.

    Attributes
    ----------
    methods : tuple of str
    delay : (m,) ndarray
        Modelling delay of each, samples.
    frequency : (F,) ndarray
        Hz.
    contrast : (m, F) ndarray
        With taps, from the response of each line.
    sweep_frequency : (B,) ndarray
        Of the sweep in the middle of each stretch, Hz.
    sweep_contrast : (m, B) ndarray
        Energy over the target over energy over the plate while it passes.
    total, expected : (m,) ndarray
        The same over the whole sweep, in the time domain, and from the lines of its spectrum.
    """

    methods: tuple[str, ...]
    delay: Real
    frequency: Real
    contrast: Real
    sweep_frequency: Real
    sweep_contrast: Real
    total: Real
    expected: Real


def sweep(band: tuple[float, float], seconds: float, rate: float) -> tuple[Real, Real]:
    """Logarithmic sweep of amplitude 1, and its instantaneous frequency.

    Parameters
    ----------
    band : (float, float)
        First and last frequency, Hz.
    seconds : float
        Length, s.
    rate : float
        Samples per second, Hz.

    Returns
    -------
    signal : (S,) ndarray
    frequency : (S,) ndarray, Hz
    """
    time = np.arange(int(seconds * rate)) / rate
    speed = np.log(band[1] / band[0]) / seconds
    frequency = band[0] * np.exp(speed * time)
    return np.sin(2.0 * np.pi * (frequency - band[0]) / speed), frequency


def play_methods(model: PanelModel, panel: Panel, constants: Constants, seconds: float = 2.0) -> Played:
    """Design every method's taps on one plate and play a sweep of the band through them.

    Parameters
    ----------
    model : PanelModel
    panel : Panel
    constants : (float, float, float)
        E, Pa, nu and eta.
    seconds : float
        Length of the sweep, s.

    Returns
    -------
    Played

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    settings, lines = panel.filters, panel.filters.frequency
    band = settings.in_band(lines)
    amplitude = model.amplitudes(*constants, lines)
    forms = model.space.forms([amplitude], panel.target.displacement)
    within = forms.at(slice(None), band)
    signal, instant = sweep(settings.band, seconds, settings.sample_rate)
    plate = _Plate.of(model, panel, constants, len(signal) + settings.taps)
    found, delays = [], []
    for method in METHODS:
        wanted = designer(method, model, panel, lines)(constants, amplitude, forms)
        free = method != "stif" and settings.delay is None
        delay = suited_delay(wanted[None], settings) if free else settings.middle
        design = TapDesign.of(panel, delay)
        bank = design.bank(design.taps(forms, wanted)[None], np.zeros(1))
        on_lines = contrast(within, bank.response(lines[band]))[0]
        found.append((on_lines, *plate.play(bank, signal)))
        delays.append(delay)
    edges = np.linspace(0, len(signal), BLOCKS + 1).astype(int)
    blocks = [_by_block(target, whole, edges, plate.step) for _, target, whole, _ in found]
    return Played(
        methods=METHODS,
        delay=np.array(delays, dtype=float),
        frequency=lines[band],
        contrast=np.array([one[0] for one in found]),
        sweep_frequency=instant[(edges[:-1] + edges[1:]) // 2],
        sweep_contrast=np.array(blocks),
        total=np.array([target.sum() / whole.sum() for _, target, whole, _ in found]),
        expected=np.array([one[3] for one in found]),
    )


@dataclass(frozen=True)
class _Plate:
    """The panel's answer at the lines of a long transform, every `step`-th sample of which is computed."""

    model: PanelModel
    amplitude: Complex
    lines: Real
    places: NDArray[np.intp]
    length: int
    step: int

    @classmethod
    def of(cls, model: PanelModel, panel: Panel, constants: Constants, samples: int) -> "_Plate":
        settings = panel.filters
        rate, (low, high) = settings.sample_rate, settings.twin_band
        step = max(1, int(rate / (2.2 * high)))
        length = step * int(2 ** np.ceil(np.log2((samples + TAIL * rate) / step)))
        frequency = np.arange(length // 2 + 1) * rate / length
        places = np.flatnonzero((frequency >= low) & (frequency <= high))
        return cls(model, model.amplitudes(*constants, frequency[places]), frequency[places], places, length, step)

    def play(self, bank: FirBank, signal: Real) -> tuple[Real, Real, float]:
        """Energy over target and plate (S/step,), and the contrast that the spectrum alone foretells."""
        from scipy.signal import fftconvolve

        drives = np.array([fftconvolve(signal, taps) for taps in bank.taps[0]])
        drive = np.fft.rfft(drives, self.length)[:, self.places]
        moved = np.einsum("nfr,nf->fr", self.amplitude, drive)
        spectrum = np.zeros((self.length // self.step // 2 + 1, moved.shape[1]), dtype=complex)
        spectrum[self.places] = moved
        motion = np.fft.irfft(spectrum, self.length // self.step, axis=0)
        energies = [
            ((motion @ root.T) ** 2).sum(axis=1) for root in (self.model.space.target, self.model.space.plate)
        ]
        # The same from the signal's spectrum and the taps' response, which knows nothing of time.
        heard = bank.response(self.lines)[0] * np.fft.rfft(signal, self.length)[self.places, None]
        field = np.einsum("nfr,fn->fr", self.amplitude, heard)
        parts = [
            float((np.abs(field @ root.T) ** 2).sum())
            for root in (self.model.space.target, self.model.space.plate)
        ]
        return energies[0], energies[1], parts[0] / parts[1]


def _by_block(target: Real, whole: Real, edges: NDArray[np.intp], step: int) -> Real:
    places = np.minimum(edges // step, len(whole) - 1)
    return np.asarray(np.add.reduceat(target, places)[:-1] / np.add.reduceat(whole, places)[:-1])
