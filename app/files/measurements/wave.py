"""Sound files, through scipy: channels ``1``, ``2``, ... in shares of full scale."""

import warnings
from pathlib import Path

import numpy as np

from app.files.measurements.columns import Columns


def read(path: Path) -> Columns:
    """Read PCM of 8 to 32 bits or floats.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns
        Channels ``1``, ``2`` and so on, as shares of full scale.
    """
    from scipy.io import wavfile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # chunks of recorders that are no sound
        rate, samples = wavfile.read(path)
    channels = np.atleast_2d(np.asarray(samples).T)
    if channels.dtype == np.uint8:
        shares = (channels.astype(float) - 128.0) / 128.0
    elif channels.dtype.kind == "i":
        shares = channels.astype(float) / -float(np.iinfo(channels.dtype).min)
    else:
        shares = channels.astype(float)
    names = [str(number) for number in range(1, len(shares) + 1)]
    return Columns(
        dict(zip(names, shares, strict=True)),
        dict.fromkeys(names, "FS"),
        dict.fromkeys(names, float(rate)),
    )
