"""Test shot before a campaign: silence, then a short sweep twice, without the oven."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from analysis.protocol.acceptance import SILENCE, InputLevels, input_levels, shot_of, signal_faults
from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.sweep import drive_signal
from drivers.ni.cards import Cards, Record, go_on


@dataclass(frozen=True)
class Shot:
    """Result of a test shot.

    Attributes
    ----------
    faults : tuple of str
        By the criteria of a campaign's sweeps; empty if the campaign can begin.
    inputs : tuple of InputLevels
        Of the drive's input, then of the responses; empty if a fault ended the shot after the first repeat.
    """

    faults: tuple[str, ...]
    inputs: tuple[InputLevels, ...] = ()


def fire(cards: Cards, protocol: AcquisitionProtocol, check: Callable[[], None] = go_on) -> Shot:
    """Play silence and a short sweep over the campaign's band, and check what is recorded.

    A disconnected cable, a clipped input or a wrong output is reported after the first repeat. Low coherence of
    such a short sweep is no fault.

    Parameters
    ----------
    cards : Cards
        Open.
    protocol : AcquisitionProtocol
        Its sweep is shortened; only its first level is played.
    check : callable
        Called while a sweep plays; raises to abort it.

    Raises
    ------
    DaqError
        As `Cards.sweep`.
    """
    tolerant = protocol.limits.model_copy(update={"coherence": 0.0})
    short = replace(protocol, sweep=shot_of(protocol.sweep), limits=tolerant)
    rate = cards.sample_rate
    silence = cards.sweep(np.zeros(round(SILENCE * rate)), check)
    level = short.sweep.levels[0]
    played = drive_signal(short.sweep, level, rate)
    records: list[Record] = []
    for _ in range(short.sweep.repeats):
        record = cards.sweep(played, check)
        if record.drive.shape != played.shape:
            return Shot((f"{record.drive.size} samples came, {played.size} were played",))
        records.append(record)
        drive = np.stack([one.drive for one in records]).astype(np.float32)
        responses = np.stack([one.responses for one in records], axis=1).astype(np.float32)
        overloaded = np.any([one.overloaded for one in records], axis=0)
        if found := signal_faults(drive, responses, played, level, overloaded, rate, short):
            return Shot(found)
    grid = np.fft.rfftfreq(played.size, 1.0 / rate)
    inside = (grid >= short.sweep.band[0]) & (grid <= short.sweep.band[1])
    quiet = np.vstack([silence.drive[None], silence.responses])
    full = records[0].full_scale
    signals = (drive, *responses)
    return Shot(
        (), tuple(input_levels(q, drive, s, inside, rate, full) for q, s in zip(quiet, signals, strict=True))
    )
