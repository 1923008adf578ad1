"""WAV files of 32-bit floats, written as they come: values beyond 1 are kept, so that a sample can be a volt.

Written here and not by libsndfile, which puts the time of day into float files: the same input gives the same
bytes.
"""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

FLOAT = bytes.fromhex("0300000000001000800000aa00389b71")
"""Identity of IEEE floats in an extensible format chunk."""
LARGEST_RIFF_FILE = 2**32 - 1
"""Bytes of a RIFF file, whose sizes are 32-bit numbers."""


class WavFileError(ValueError):
    """What is to be written does not fit into a WAV file; the message says why."""


@dataclass
class WavFile:
    """An open file to which blocks are added.

    Attributes
    ----------
    file : BinaryIO
    channels : int
    """

    file: BinaryIO
    channels: int

    def write(self, samples: NDArray[np.float64]) -> None:
        """Add samples (channels, count)."""
        if len(samples) != self.channels:
            raise ValueError(f"samples {samples.shape} for {self.channels} channels")
        self.file.write(np.ascontiguousarray(samples.T, dtype="<f4").tobytes())


@contextmanager
def create_wav(path: Path, sample_rate: float, channels: int, frames: int, comment: str) -> Iterator[WavFile]:
    """Yield a file to write float32 samples to.

    Parameters
    ----------
    sample_rate : float
        A whole number of Hz.
    frames : int
        Samples of a channel that are going to be written.
    comment : str
        Goes in as text that players show.

    Raises
    ------
    WavFileError
        For more than 4 GB, or a rate that is no whole number of Hz: before the file is begun.
    ValueError
        Where fewer or more samples were written.
    """
    head = _head(sample_rate, channels, frames, comment)
    with path.open("wb") as file:
        file.write(head)
        yield WavFile(file, channels)
        written = (file.tell() - len(head)) // (4 * channels)
        if written != frames:
            raise ValueError(f"{path}: {written} samples written of {frames}")


def _head(sample_rate: float, channels: int, frames: int, comment: str) -> bytes:
    rate = round(sample_rate)
    if rate != sample_rate:
        raise WavFileError(f"a sample rate of {sample_rate:g} Hz; WAV files hold whole numbers of Hz")
    form = (
        struct.pack("<HHIIHHHHI", 0xFFFE, channels, rate, 4 * channels * rate, 4 * channels, 32, 22, 32, 0) + FLOAT
    )
    text = comment.encode() + b"\0"
    text += b"\0" * (len(text) % 2)
    before = _chunk(b"fmt ", form) + _chunk(b"fact", struct.pack("<I", frames))
    before += _chunk(b"LIST", b"INFO" + _chunk(b"ICMT", text))
    size = 4 * channels * frames
    whole = 4 + len(before) + 8 + size
    if whole > LARGEST_RIFF_FILE:
        most = (LARGEST_RIFF_FILE - whole + size) // (4 * channels) / sample_rate / 60.0
        raise WavFileError(
            f"{frames / sample_rate / 60.0:.0f} minutes of {channels} channels; "
            f"a WAV file holds {most:.0f} of them"
        )
    return b"RIFF" + struct.pack("<I", whole) + b"WAVE" + before + b"data" + struct.pack("<I", size)


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content
