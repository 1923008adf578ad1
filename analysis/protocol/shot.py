"""A shot before a campaign: silence, then a short sweep twice. Shows faults of wiring, levels, noise and hum."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.protocol.sweep import SweepSettings
from analysis.recordings.h1 import h1

DURATION, TAIL, SILENCE, REPEATS = 0.6, 0.2, 0.4, 2
"""Of the shot, s and a count: cables that are off are found within three seconds."""
FADE = 0.02
"""Share of the shot's duration that each of its fades takes."""
MAINS = (50.0, 60.0)
"""Hz."""
HARMONICS = 3
"""Of the mains, the fundamental among them, whose level is told."""


@dataclass(frozen=True)
class InputLevels:
    """What one input recorded.

    Attributes
    ----------
    peak : float
        Largest magnitude, share of where the input clips.
    level : float
        Root mean square of the sweep, V.
    noise : float
        Root mean square of the silence before, its mean left out, V.
    hum : float
        Of that, harmonics of the mains, V.
    mains : float
        Their fundamental, Hz.
    coherence : float
        Median over the band, over the repeats.
    """

    peak: float
    level: float
    noise: float
    hum: float
    mains: float
    coherence: float


def shot_of(sweep: SweepSettings) -> SweepSettings:
    """Return a short sweep at the highest level, of the same band as far as it ends no higher, its fade included.

    A shorter sweep climbs further in its fade: where the campaign's ends just below half of the sample rate, the
    shot's would end beyond.
    """
    (low, high), top = sweep.band, sweep.frequency_range[1]
    climb = FADE / (1.0 - 2.0 * FADE)  # the shot ends at high (high / low)**climb
    return SweepSettings(
        kind="logarithmic",
        band=(low, min(high, low * (top / low) ** (1.0 / (1.0 + climb)))),
        duration=DURATION,
        taper=FADE * DURATION,
        tail=TAIL,
        repeats=REPEATS,
        levels=(max(sweep.levels),),
    )


def input_levels(
    silence: Real,
    drive: NDArray[np.float32],
    signal: NDArray[np.float32],
    inside: NDArray[np.bool_],
    rate: float,
    full: float,
) -> InputLevels:
    """Judge one input.

    Parameters
    ----------
    silence : (S,) ndarray, V
        Recorded while nothing was played.
    drive, signal : (R, M) ndarray, V
        Repeats of the drive as recorded, and of this input.
    inside : (M // 2 + 1,) ndarray of bool
        Lines of the band.
    rate : float
        Hz.
    full : float
        Where the input clips, V.
    """
    quiet = silence - silence.mean()
    by_mains = {mains: _hum(quiet, mains, rate) for mains in MAINS}
    mains = max(by_mains, key=lambda one: by_mains[one])
    coherence = h1(drive, signal)[2][inside]
    return InputLevels(
        peak=float(np.abs(signal).max()) / full,
        level=float(np.sqrt(np.mean(np.square(signal, dtype=np.float64)))),
        noise=float(np.sqrt(np.mean(quiet**2))),
        hum=by_mains[mains],
        mains=mains,
        coherence=float(np.median(coherence)),
    )


def _hum(quiet: Real, mains: float, rate: float) -> float:
    """Return the root mean square of what is at a mains frequency and its harmonics, by least squares."""
    angle = 2.0 * np.pi * np.outer(np.arange(quiet.size), mains * np.arange(1, HARMONICS + 1)) / rate
    columns = np.hstack([np.cos(angle), np.sin(angle)])
    found = columns @ np.linalg.lstsq(columns, quiet, rcond=None)[0]
    return float(np.sqrt(np.mean(found**2)))
