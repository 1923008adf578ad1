"""Filters as WAV files: impulse responses, for any convolution engine."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.files.bad_file import ResultFileError
from app.files.exports.destination import written_together
from app.files.exports.shipment import Shipment
from app.files.wav_file import WavFileError, create_wav


def write_wav(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write a file per temperature, one channel per actuator, float32 in V per unit of audio signal.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.

    Returns
    -------
    (T,) tuple of Path

    Raises
    ------
    ResultFileError
        For a sample rate that WAV does not hold, or a folder that cannot be written.
    """
    names = tuple(f"flexura_filters_{t:+07.2f}C.wav" for t in temperature)
    filters = shipment.filters
    taps = filters.taps(temperature)
    try:
        with written_together(folder, names) as paths:
            for path, one in zip(paths, taps, strict=True):
                with create_wav(path, filters.sample_rate, len(one), one.shape[1], shipment.stamp) as file:
                    file.write(one)
    except WavFileError as error:
        raise ResultFileError(f"{error}; take --to npz") from error
    return tuple(folder / name for name in names)
