"""What a patch answers while the temperature moves, with noise: for trying the thermometer without a panel."""

import numpy as np

from analysis.arrays import Real
from analysis.rendering.following import TemperatureProgramme
from analysis.thermometry.listening import PatchResponse

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
