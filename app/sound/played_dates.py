"""Drive and response of a panel as sound files, as a later date of its health."""

from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.thermometry.bands import Decimator
from app.files.bad_file import ResultFileError
from app.files.sound_file import Sound, opened_sound

SAMPLES_AT_ONCE = 65_536
"""Samples read and filtered at a time."""


def played_signals(
    drive: Path, response: Path, inputs: tuple[str, ...], outputs: tuple[str, ...], highest: float
) -> tuple[Real, Real, float]:
    """Read two files that were recorded together, at the sample rate that the band needs.

    Parameters
    ----------
    inputs, outputs : tuple of str
        Names of the I inputs and K outputs of the baseline: a channel each, in this order.
    highest : float
        Of the band, Hz.

    Returns
    -------
    drives, responses : (I, n) and (K, n) ndarray
        In the units of the files.
    rate : float
        Hz.

    Raises
    ------
    ResultFileError
        For files that cannot be read, are not of this panel, or do not belong together.
    """
    with opened_sound(drive) as played, opened_sound(response) as measured:
        _require_of_panel(played, inputs, "inputs")
        _require_of_panel(measured, outputs, "outputs")
        if (played.sample_rate, played.frames) != (measured.sample_rate, measured.frames):
            raise ResultFileError(
                f"{response}: {measured.frames} samples at {measured.sample_rate} Hz; those of {drive.name} are "
                f"{played.frames} at {played.sample_rate} Hz: record both together"
            )
        if played.sample_rate < 2.0 * highest:
            raise ResultFileError(
                f"{drive}: sampled at {played.sample_rate} Hz; allowed: from {2.0 * highest:.0f} Hz, twice the "
                "highest line of the baseline"
            )
        down = Decimator(len(inputs) + len(outputs), played.sample_rate, highest)
        blocks = zip(played.blocks(SAMPLES_AT_ONCE), measured.blocks(SAMPLES_AT_ONCE), strict=True)
        every = np.hstack([down.take(np.vstack(pair)) for pair in blocks])
    return every[: len(inputs)], every[len(inputs) :], down.rate


def _require_of_panel(sound: Sound, names: tuple[str, ...], what: str) -> None:
    if sound.channels != len(names):
        raise ResultFileError(
            f"{sound.path}: {sound.channels} channels; the baseline has {len(names)} {what}: {', '.join(names)}, "
            "a channel each, in this order"
        )
