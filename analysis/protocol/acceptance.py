"""What is wrong with a sweep just recorded: each fault in words, none for a good one.

A shot before a campaign: silence, then a short sweep twice. Shows faults of wiring, levels, noise and hum.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.protocol.protocol import AcquisitionProtocol, SweepSetPoint
from analysis.protocol.sweep import SweepSettings, clock_difference, compare_drive, stretched
from analysis.recordings.campaign import Sweep
from analysis.recordings.h1 import h1

Recorded = NDArray[np.float32]

SAME_LEVEL = 0.05
"""How far the drive as recorded may be from the drive as asked for, as a share: cards are within 1 %."""
LEAST_CORRELATION = 0.99
"""Least correlation of the drive recorded with the drive played; white noise 17 dB below it still passes."""
LARGEST_DELAY_DIFFERENCE = 0.1
"""Largest difference between two repeats' delays, samples."""
OWN_CLOCK = 1.0
"""On top of it where the output runs on a clock of its own: that has its next edge up to a sample later."""


def faults(
    sweep: Sweep,
    played: NDArray[np.float64],
    overloaded: NDArray[np.bool_],
    sample_rate: float,
    set_point: SweepSetPoint,
    protocol: AcquisitionProtocol,
) -> tuple[str, ...]:
    """Return what is wrong with `sweep`.

    Parameters
    ----------
    sweep : Sweep
        In volts, as the cards recorded it.
    played : (M,) ndarray, V
        The drive as asked for.
    overloaded : (1 + K,) ndarray
        Channels that came near the inputs' range in any repeat, drive first.
    sample_rate : float, Hz
    set_point : SweepSetPoint
        What it was to be.

    Returns
    -------
    tuple of str
        One sentence per fault; empty for a good sweep.
    """
    of_signals = signal_faults(
        sweep.drive, sweep.responses, played, sweep.level, overloaded, sample_rate, protocol
    )
    return (*_wrong_temperature(sweep, set_point, protocol), *of_signals)


def signal_faults(
    drive: Recorded,
    responses: Recorded,
    played: NDArray[np.float64],
    level: float,
    overloaded: NDArray[np.bool_],
    sample_rate: float,
    protocol: AcquisitionProtocol,
) -> tuple[str, ...]:
    """Return what is wrong with the signals of a sweep, whatever its temperature.

    Parameters
    ----------
    drive : (R, M) ndarray, V
    responses : (K, R, M) ndarray, V
    played : (M,) ndarray, V
        The drive as asked for.
    level : float
        Of the drive, V.
    overloaded : (1 + K,) ndarray
        Channels that came near the inputs' range in any repeat, drive first.
    sample_rate : float, Hz

    Returns
    -------
    tuple of str
        One sentence per fault; empty for good signals.
    """
    signals = (
        *_overload(overloaded, protocol),
        *_damaged_drive(drive, played, level, sample_rate, protocol),
        *_silence(drive, responses, protocol),
    )
    # Coherence adds nothing for signals that are already known to be faulty.
    return signals or tuple(_incoherence(drive, responses, sample_rate, protocol))


def _wrong_temperature(sweep: Sweep, set_point: SweepSetPoint, protocol: AcquisitionProtocol) -> Iterator[str]:
    watched = ["oven"] if sweep.plate_temperature_start is None else ["plate", "oven"]
    reach = protocol.programme.tolerance
    if abs(sweep.temperature - set_point.temperature) > reach:
        yield (
            f"mean temperature {sweep.temperature:.2f} °C; {set_point.temperature:g} °C within {reach:g} K allowed"
        )
    for where in watched:
        drift = getattr(sweep, f"{where}_temperature_end") - getattr(sweep, f"{where}_temperature_start")
        if abs(drift) > protocol.limits.drift:
            yield f"{where} moved by {drift:.2f} K during the sweep; at most {protocol.limits.drift:g} K allowed"


def _overload(overloaded: NDArray[np.bool_], protocol: AcquisitionProtocol) -> Iterator[str]:
    for channel in np.flatnonzero(overloaded):
        name = "the drive's input" if channel == 0 else protocol.response(int(channel) - 1)
        yield f"{name} is overloaded: lower the level or widen the input's range"


def _damaged_drive(
    drive: Recorded, played: NDArray[np.float64], level: float, sample_rate: float, protocol: AcquisitionProtocol
) -> Iterator[str]:
    """Hold each repeat's drive against the one played, a force against that of the first repeat.

    A force is no copy of the generator's voltage: the plate's resonances load the exciter.
    """
    if protocol.measured_force:
        reference, apart = drive[0].astype(np.float64), LARGEST_DELAY_DIFFERENCE + OWN_CLOCK
        unlike, louder = "the force is not that of repeat 1", "the force has {:.3f} times the level of repeat 1"
    else:
        difference = clock_difference(drive, played, sample_rate, protocol.sweep)
        reference, apart = played, LARGEST_DELAY_DIFFERENCE
        if difference:
            reference = stretched(played, difference, sample_rate, protocol.sweep, level)
            apart += OWN_CLOCK
        unlike = "the drive recorded is not the one played"
        louder = "the drive recorded has {:.3f} times the level played"
    delays = []
    for number, recorded in enumerate(drive, 1):
        gain, delay, correlation = compare_drive(recorded, reference, sample_rate, protocol.sweep.frequency_range)
        delays.append(delay)
        if correlation < LEAST_CORRELATION:
            cause = f"(correlation {correlation:.3f}): samples were lost, or its cable is off"
            yield f"repeat {number}: {unlike} {cause}"
        elif abs(gain - 1.0) > SAME_LEVEL:
            yield f"repeat {number}: {louder.format(gain)}"
    if max(delays) - min(delays) > apart:
        yield f"the repeats begin {max(delays) - min(delays):.2f} samples apart: they are not synchronous"


def _silence(drive: Recorded, responses: Recorded, protocol: AcquisitionProtocol) -> Iterator[str]:
    least = protocol.limits.silence
    named = [(protocol.response(number), response) for number, response in enumerate(responses)]
    if protocol.measured_force:
        named.insert(0, ("the force", drive))
    for name, signal in named:
        rms = float(np.sqrt(np.mean(np.square(signal, dtype=np.float64))))
        if not rms >= least:
            yield f"{name} is silent: {rms:.2g} V rms, at least {least:g} V wanted"


def _incoherence(
    drive: Recorded, responses: Recorded, sample_rate: float, protocol: AcquisitionProtocol
) -> Iterator[str]:
    if len(drive) < 2:  # one repeat is coherent with itself whatever it holds
        return
    grid = np.fft.rfftfreq(drive.shape[1], 1.0 / sample_rate)
    inside = (grid >= protocol.sweep.band[0]) & (grid <= protocol.sweep.band[1])
    for number, response in enumerate(responses):
        middle = float(np.median(h1(drive, response)[2][inside]))
        if not middle >= protocol.limits.coherence:
            yield (
                f"{protocol.response(number)} is not coherent over the repeats: median {middle:.3f} over the "
                f"band, at least {protocol.limits.coherence:g} wanted"
            )


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
