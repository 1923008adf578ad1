"""Response of panel and taps to a sweep: contrast in the time domain (paper Fig. 4).

The plate's modes are integrated over time step by step, independent of transforms and transfer functions.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_shapes
from analysis.focusing.design import TapDesign
from analysis.focusing.energy import FieldSpace
from analysis.focusing.fir import FirBank, suited_delay
from analysis.focusing.methods import METHODS, designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel, PanelModes
from analysis.focusing.performance import contrast

SILENT_TAIL = 0.5
"""Silence after the sweep, s, in which panel and filters ring out."""
FADE = 0.05
"""Fade-in and fade-out of the sweep, s: outside its band, where some filters have high gain, it is silent."""
ENERGY_BLOCKS = 100
"""Number of blocks of the sweep with separate energies."""


@dataclass(frozen=True)
class Played:
    """Contrast of all methods with taps: at the lines of the band, and for a logarithmic sweep in time.

    Attributes
    ----------
    methods : tuple of str
    delay : (m,) ndarray
        Modelling delay of each, samples.
    frequency : (F,) ndarray
        Hz.
    contrast : (m, F) ndarray
        With taps, from the response at each line.
    sweep_frequency : (B,) ndarray
        Of the sweep in the middle of each block, Hz.
    sweep_contrast : (m, B) ndarray
        Energy over the target over energy over the plate, during each block.
    total, expected : (m,) ndarray
        The same over the whole sweep: with the modes integrated in time, and from the spectrum of the sweep and
        the panel's responses at its lines.
    """

    methods: tuple[str, ...]
    delay: Real
    frequency: Real
    contrast: Real
    sweep_frequency: Real
    sweep_contrast: Real
    total: Real
    expected: Real

    def __post_init__(self) -> None:
        check_shapes(
            self,
            methods="m",
            delay="m",
            frequency="F",
            contrast="m F",
            sweep_frequency="B",
            sweep_contrast="m B",
            total="m",
            expected="m",
        )
        check_ascending(self, "frequency", "sweep_frequency")


def sweep(band: tuple[float, float], seconds: float, rate: float) -> tuple[Complex, Real]:
    """Logarithmic sweep of amplitude 1 (the real part) with its quadrature, and its instantaneous frequency.

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
    signal : (S,) complex ndarray
    frequency : (S,) ndarray, Hz
    """
    time = np.arange(int(seconds * rate)) / rate
    speed = np.log(band[1] / band[0]) / seconds
    frequency = band[0] * np.exp(speed * time)
    fade = np.clip(np.minimum(time, time[-1] - time) / FADE, 0.0, 1.0)
    loudness = np.sin(0.5 * np.pi * fade) ** 2
    return -1j * loudness * np.exp(2j * np.pi * (frequency - band[0]) / speed), frequency


def play_methods(model: PanelModel, panel: Panel, constants: Constants, seconds: float = 2.0) -> Played:
    """Design every method's taps on one plate and play a sweep of the band through them.

    Parameters
    ----------
    constants : (float, float, float)
        E, Pa, nu and eta.
    seconds : float
        Length of the sweep, s.

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
        wanted = designer(method, model, panel, lines)(constants, lambda: amplitude, forms)
        free = method != "stif" and settings.delay is None
        delay = suited_delay(wanted[None], settings) if free else settings.middle
        design = TapDesign.of(panel, delay)
        bank = design.bank(design.taps(forms, wanted)[None], np.zeros(1))
        on_lines = contrast(within, bank.response(lines[band]))[0]
        found.append((on_lines, *plate.play(bank, signal)))
        delays.append(delay)
    edges = np.linspace(0, len(signal), ENERGY_BLOCKS + 1).astype(int)
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


POLE = np.sqrt(3.0) - 2.0
"""Pole of the recursive filter for the coefficients of a cubic spline through samples (Unser 1999)."""
NODES = 32
"""Number of Gauss points in a step, and one more for every radian of the mode: exact to rounding for all modes. A
reduced plate has some far above the rate, which carry its static flexibility."""
RIGID = (2.0 * np.pi) ** 2 * (1.0 + 1.0j)
"""Smallest eigenvalue, rad2/s2: rigid-body modes of a free plate are set to 1 Hz, far below the sweep."""


def modal_motion(modes: PanelModes, drive: Complex, rate: float, every: int = 1) -> Real:
    """Integrate q'' + ω²(1 + jη) q = f(t) of every mode, the drive a cubic spline through its samples.

    Parameters
    ----------
    modes : PanelModes
        m of them, of r coordinates.
    drive : (N, S) complex ndarray
        Analytic signal of every actuator, V or N: the real part is played, the imaginary part is a quarter of a
        period later. Zero at both ends.
    rate : float
        Samples per second, Hz.
    every : int
        Every how many samples one is returned.

    Returns
    -------
    (S / every, r) ndarray
        Generalised coordinates, the real part.

    Notes
    -----
    With s² = -ω²(1 + jη), Re s < 0, 1/(ω²(1 + jη) + p²) = (1/(p - s) - 1/(p + s)) / 2s. The first part is causal,
    y' = s y + f. The second has its pole in the right half plane and depends on the future, because hysteretic
    damping is not causal; it is integrated backward. Over a step of length h both are y(t + h) = exp(sh) y(t) plus
    a weighted sum of four spline coefficients. That is exact for the spline, whose error for a tone is about (2πf
    h)⁴/720: 7e-5 at 300 Hz and 4 kHz. The analytic signal has positive frequencies only, where the loss factor has
    one sign.
    """
    poles = 1j * np.sqrt(np.where(np.abs(modes.eigenvalues) < np.abs(RIGID), RIGID, modes.eigenvalues))
    spline = _spline(drive)
    coordinates = np.empty((len(poles), len(range(0, drive.shape[1], every))), dtype=complex)
    for place, (pole, coupling) in enumerate(zip(poles, modes.coupling.astype(complex), strict=True)):
        force = coupling @ spline
        both = _relaxed(force, pole, rate) + _relaxed(force[::-1], pole, rate)[::-1]
        coordinates[place] = both[::every] / (2.0 * pole)
    return np.asarray((modes.shapes @ coordinates).real.T)


def _spline(samples: Complex) -> Complex:
    """Coefficients (N, S) of the cubic B-splines whose sum passes through `samples` (N, S), zero beyond."""
    from scipy.signal import lfilter  # half a second of processor time; a report shows what was played before

    forward = lfilter([1.0], [1.0, -POLE], samples)
    return np.asarray(-6.0 * POLE * lfilter([1.0], [1.0, -POLE], forward[:, ::-1])[:, ::-1])


def _relaxed(force: Complex, pole: complex, rate: float) -> Complex:
    """Solve y' = pole · y + force from rest, at the samples; `force` (S,) in coefficients of a cubic spline."""
    from scipy.signal import lfilter

    x = pole / rate
    place, weight = np.polynomial.legendre.leggauss(NODES + int(abs(x)))
    u = 0.5 * (place + 1.0)
    pieces = np.array([u**3, 1.0 + 3.0 * u * (1.0 + u * (1.0 - u)), 4.0 - 3.0 * u**2 * (2.0 - u), (1.0 - u) ** 3])
    shares = pieces @ (0.5 * weight * np.exp(x * (1.0 - u))) / (6.0 * rate)
    return np.asarray(lfilter(shares, [1.0, -np.exp(x)], np.append(force[1:], 0.0)))


@dataclass(frozen=True)
class _Plate:
    """The panel computed in two independent ways: modes in time, and its response at the lines of a transform."""

    space: FieldSpace
    modes: PanelModes
    rate: float
    step: int
    amplitude: Complex
    lines: Real
    length: int

    @classmethod
    def of(cls, model: PanelModel, panel: Panel, constants: Constants, samples: int) -> "_Plate":
        """Prepare for `samples` of drive and the ringing after them; every `step`-th sample is evaluated."""
        rate, (low, high) = panel.filters.sample_rate, panel.filters.twin_band
        step = max(1, int(rate / (2.2 * high)))
        length = 2 * int((samples + SILENT_TAIL * rate) / 2)
        frequency = np.arange(length // 2 + 1) * rate / length
        lines = frequency[(frequency >= low) & (frequency <= high)]
        modes = model.modes(*constants, count=model.space.deflection.shape[1])
        return cls(model.space, modes, rate, step, model.amplitudes(*constants, lines), lines, length)

    def play(self, bank: FirBank, signal: Complex) -> tuple[Real, Real, float]:
        """Energy over target and plate (S/step,), and the contrast predicted from the spectrum."""
        from scipy.signal import lfilter

        silence = np.zeros(self.length - len(signal))
        drive = np.array([lfilter(taps, [1.0], np.append(signal, silence)) for taps in bank.taps[0]])
        motion = modal_motion(self.modes, drive, self.rate, self.step)
        target, plate = (((motion @ root.T) ** 2).sum(axis=1) for root in (self.space.target, self.space.plate))
        places = np.rint(self.lines * self.length / self.rate).astype(int)
        response = bank.response(self.lines)[0] * np.fft.rfft(signal.real, self.length)[places, None]
        field = np.einsum("nfr,fn->fr", self.amplitude, response)
        within, whole = (np.sum(np.abs(field @ root.T) ** 2) for root in (self.space.target, self.space.plate))
        return target, plate, float(within / whole)


def _by_block(target: Real, whole: Real, edges: NDArray[np.intp], step: int) -> Real:
    places = np.minimum(edges // step, len(whole) - 1)
    return np.asarray(np.add.reduceat(target, places)[:-1] / np.add.reduceat(whole, places)[:-1])
