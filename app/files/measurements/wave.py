"""Sound files, through scipy: channels ``1``, ``2``, ... in shares of full scale."""

import struct
import warnings
from pathlib import Path

import numpy as np

from app.files.measurements.columns import Columns

UNKNOWN = 4096
"""Recorders that do not know yet how much they will write declare 0 bytes, or this much less than 2 or 4 GB."""


def read(path: Path) -> Columns:
    """Read PCM of 8 to 32 bits or floats.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns
        Channels ``1``, ``2`` and so on, as shares of full scale.

    Raises
    ------
    ValueError
        Where the file was cut short.
    """
    from scipy.io import wavfile

    require_whole(path)
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


def require_whole(path: Path) -> None:
    """Raise ValueError where fewer samples follow than the head says; scipy gives what there is with a warning."""
    size = path.stat().st_size
    with path.open("rb") as file:
        begin = file.read(12)
        order = ">" if begin[:4] == b"RIFX" else "<"
        if begin[:4] not in (b"RIFF", b"RIFX"):
            return
        while len(head := file.read(8)) == 8:
            declared = int(struct.unpack(f"{order}4xI", head)[0])
            there = size - file.tell()
            if head[:4] == b"data":
                known = declared and declared % 2**31 < 2**31 - UNKNOWN
                if known and declared > there:
                    raise ValueError(
                        f"{there} bytes of samples, and its head says {declared}; cut short? copy it again"
                    )
                return
            file.seek(declared + declared % 2, 1)
