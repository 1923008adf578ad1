"""A panel one of whose patches listens while the others play, its signals, and the temperature from them."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.rendering.following import TemperatureProgramme
from analysis.rendering.renderer import Renderer
from analysis.thermometry import Decimator, Listener, Track, simulated_response
from app.files.bad_file import ResultFileError
from app.files.exports.shipment import Shipment
from app.files.sound_file import Sound
from app.sound.stretch import RecordingStretch
from app.twins.panel_twin import PanelTwin


@dataclass(frozen=True)
class ListeningPanel:
    """A panel whose patches drive, but for one, whose charge is measured.

    Attributes
    ----------
    twin : PanelTwin
    laws : MaterialLaws
        Of the panel's plate.
    sensor : int
        The patch used as sensor.
    """

    twin: PanelTwin
    laws: MaterialLaws
    sensor: int

    @property
    def driven(self) -> list[int]:
        """The other patches."""
        return [n for n in range(self.twin.reduced.capacitance.size) if n != self.sensor]

    def transfer(self, temperature: float, frequency: Real) -> Complex:
        """Charge of the listening patch per volt on each of the others.

        Parameters
        ----------
        temperature : float
            Degrees Celsius.
        frequency : (F,) ndarray
            Hz.

        Returns
        -------
        (N - 1, F) complex ndarray
            C/V.
        """
        material = self.laws.at(temperature)
        constants = (material.youngs_modulus, material.poisson_ratio, material.loss_factor)
        e, nu, eta = (float(value[0]) for value in constants)
        whole = self.twin.reduced.compliance(e, nu, eta, frequency)
        chosen: Complex = whole[self.sensor, self.driven]
        return chosen

    def law_sigma(self, temperature: float) -> float:
        """By how much one standard deviation of the law of E moves the reading.

        Parameters
        ----------
        temperature : float
            Degrees Celsius; beyond the law, that of its end.

        Returns
        -------
        float
            K; infinite where E does not depend on the temperature.
        """
        temperature = float(np.clip(temperature, *self.laws.temperature_range))
        spread = float(
            self.laws.sigma(temperature).youngs_modulus[0] / self.laws.at(temperature).youngs_modulus[0]
        )
        slope = abs(float(self.laws.local(temperature).slope[0]))
        return spread / slope if slope > 0.0 else np.inf


SAMPLES_AT_ONCE = 4096
"""Samples read and filtered at a time: recordings of any length need little memory."""
SILENT_SHARE = 1e-3
"""Share of the loudest channel that the listening patch's own channel may hold."""


@dataclass(frozen=True)
class PlayedSignals:
    """Drive and response at the low rate the band needs.

    Attributes
    ----------
    drive : (N - 1, n) ndarray
        V, of the patches that drive.
    response : (n,) ndarray
        Of the patch used as sensor, in any unit.
    sample_rate : float
        Hz.
    """

    drive: Real
    response: Real
    sample_rate: float

    def __post_init__(self) -> None:
        check_shapes(self, drive="N n", response="n")
        check_finite(self, "drive", "response")
        check_range(self, 0.0, np.inf, "sample_rate", unit="Hz", above=True)


TEMPERATURE_SPACING = 0.5
"""K between the temperatures at which the twin is asked; between them its answers are interpolated."""


def listened(
    panel: ListeningPanel,
    signals: PlayedSignals,
    band: tuple[float, float],
    span: tuple[float, float],
    seconds: float,
    largest_sigma: float,
    report: Progress = lambda _stage, _share: None,
) -> list[RecordingStretch]:
    """Return what every stretch of a recording says of the temperature, and the track through all.

    Parameters
    ----------
    band : (float, float)
        Hz.
    span : (float, float)
        Temperatures looked at, degrees Celsius.
    seconds : float
        Length of a stretch, s.
    largest_sigma : float
        A reading less certain than this is refused, K.
    report : callable, optional
        Called with the stage's name and the share done.

    Raises
    ------
    ResultFileError
        For signals shorter than a stretch.
    """
    grid = np.linspace(*span, max(round((span[1] - span[0]) / TEMPERATURE_SPACING), 8) + 1)
    listener = Listener.of(panel, grid, signals.sample_rate, band, seconds, largest_sigma)
    count, behind = len(signals.response), listener.whole - listener.before
    if count < listener.whole:
        raise ResultFileError(
            f"{count / signals.sample_rate:.1f} s of sound are too short for a stretch of {seconds:g} s, the "
            f"{(listener.whole - listener.frame) / signals.sample_rate:.1f} s about it included"
        )
    track, stretches = Track(), []
    for first in range(listener.before, count - behind + 1, listener.frame):
        drive = signals.drive[:, first - listener.before : first + behind]
        reading = listener.read(drive, signals.response[first : first + listener.frame])
        track.step(reading, listener.frame / signals.sample_rate)
        middle = (first + 0.5 * listener.frame) / signals.sample_rate
        stretches.append(RecordingStretch(middle, reading, track.temperature, track.sigma))
        report("Listening", min((first + listener.frame) / count, 1.0))
    report("Listening", 1.0)
    return stretches


def recorded(
    drive: Sound, response: Sound, panel: ListeningPanel, names: tuple[str, ...], highest: float
) -> PlayedSignals:
    """Read two files that were recorded together.

    Parameters
    ----------
    drive : Sound
        A channel for each of the N patches, V.
    response : Sound
        One channel, of the listening patch, in any unit.
    names : (N,) tuple of str
        Of the patches.
    highest : float
        Highest frequency to be kept, Hz.

    Raises
    ------
    ResultFileError
        For files that do not belong together, and a listening patch that is driven.
    """
    if drive.channels != len(names):
        raise ResultFileError(f"{drive.path}: {drive.channels} channels; the panel has {len(names)} patches")
    if response.channels != 1:
        raise ResultFileError(f"{response.path}: {response.channels} channels; allowed: 1, of the listening patch")
    if (drive.sample_rate, drive.frames) != (response.sample_rate, response.frames):
        raise ResultFileError(
            f"{response.path}: {response.frames} samples at {response.sample_rate} Hz; those of {drive.path.name} "
            f"are {drive.frames} at {drive.sample_rate} Hz: record both together"
        )
    down = Decimator(len(names) + 1, drive.sample_rate, highest)
    kept, loudest = [], np.zeros(len(names))
    for played, measured in zip(drive.blocks(SAMPLES_AT_ONCE), response.blocks(SAMPLES_AT_ONCE), strict=True):
        loudest = np.maximum(loudest, np.abs(played).max(axis=1))
        kept.append(down.take(np.vstack([played, measured])))
    if loudest[panel.sensor] > SILENT_SHARE * loudest.max():
        raise ResultFileError(
            f"{drive.path}: {names[panel.sensor]}, the patch used as sensor, is driven by up to "
            f"{loudest[panel.sensor]:.3g} V; leave it out of the drive, or name another with --sensor"
        )
    every = np.hstack(kept)
    return PlayedSignals(every[panel.driven], every[-1], down.rate)


def simulated(
    sound: Sound,
    shipment: Shipment,
    panel: ListeningPanel,
    programme: TemperatureProgramme,
    signal_to_noise: float,
    rng: np.random.Generator,
) -> PlayedSignals:
    """Play a sound through the panel's filters, the listening patch left out, and let the twin answer.

    Parameters
    ----------
    sound : Sound
        Its channels are averaged.
    programme : TemperatureProgramme
        Of the plate.
    signal_to_noise : float
        By how much the white noise lies below the response, dB.
    rng : numpy.random.Generator
        Of the noise.
    """
    settings = shipment.panel.filters
    renderer = Renderer(shipment.filters, float(programme.at(0.0)), SAMPLES_AT_ONCE)
    down = Decimator(len(panel.driven), sound.sample_rate, settings.edges[1])
    kept = []
    for place, block in enumerate(sound.blocks(SAMPLES_AT_ONCE)):
        renderer.follow(float(programme.at(place * SAMPLES_AT_ONCE / sound.sample_rate)))
        mono = np.zeros(SAMPLES_AT_ONCE)
        mono[: block.shape[1]] = block.mean(axis=0)
        kept.append(down.take(renderer.process(mono)[panel.driven]))
    drive = np.hstack(kept)
    response = simulated_response(panel, drive, down.rate, settings.edges, programme, signal_to_noise, rng)
    return PlayedSignals(drive, response, down.rate)
