"""What the patches play and the listening one answers: recorded, or simulated."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.rendering.following import TemperatureProgramme
from analysis.rendering.renderer import Renderer
from analysis.thermometry.bands import Decimator
from analysis.thermometry.simulated import simulated_response
from app.files.bad_file import ResultFileError
from app.files.exports.shipment import Shipment
from app.files.sound_file import Sound
from app.sound.listening_panel import ListeningPanel

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
