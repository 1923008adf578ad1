"""Sound files: read in blocks, checked as they come, and written as WAV of 32-bit floats.

Read are WAV, FLAC and whatever else libsndfile reads. Values beyond 1 are kept when they are written, so that a
sample can be a volt. Written here and not by libsndfile, which puts the time of day into float files: the same
input gives the same bytes.
"""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from app.files.bad_file import ResultFileError
from app.files.measurements.wave import require_whole


@dataclass(frozen=True)
class Sound:
    """An open file.

    Attributes
    ----------
    path : Path
    sample_rate : int
        Hz.
    frames : int
        Samples of a channel.
    channels : int
    """

    path: Path
    sample_rate: int
    frames: int
    channels: int
    _file: Any

    @property
    def seconds(self) -> float:
        """Duration."""
        return self.frames / self.sample_rate

    def blocks(self, count: int) -> Iterator[Real]:
        """Yield all channels (channels, count) in turn, the last block as long as it is.

        Raises
        ------
        ResultFileError
            For samples that are no numbers, and a file that ends before its time.
        """
        read = 0
        while read < self.frames:
            with _faults_named(self.path):
                block: Real = self._file.read(count, dtype="float64", always_2d=True)
            if not len(block):
                raise ResultFileError(f"{self.path}: ends after {read} of {self.frames} samples; it was cut short")
            if not np.isfinite(block).all():
                wrong = read + int(np.flatnonzero(~np.isfinite(block).all(axis=1))[0])
                raise ResultFileError(
                    f"{self.path}: sample {wrong}, at {wrong / self.sample_rate:.3f} s, is {_shown(block)}; "
                    "allowed: finite numbers"
                )
            read += len(block)
            yield np.ascontiguousarray(block.T)


@contextmanager
def opened_sound(path: Path, sample_rate: float | None = None) -> Iterator[Sound]:
    """Yield a file's sound.

    Parameters
    ----------
    sample_rate : float, optional
        What its rate has to be, Hz.

    Raises
    ------
    ResultFileError
        For a file that cannot be read, holds nothing, or is of another rate.
    """
    try:
        import soundfile
    except ImportError as error:
        raise ResultFileError(
            f"{path}: sound needs the package soundfile: pip install 'flexura[audio]'"
        ) from error
    if not path.is_file():
        raise ResultFileError(f"{path}: no such file")
    with _faults_named(path):
        file = soundfile.SoundFile(path)
    with file:
        _require_whole(path)
        if file.frames <= 0:
            raise ResultFileError(f"{path}: holds no samples")
        if sample_rate is not None and file.samplerate != sample_rate:
            raise ResultFileError(
                f"{path}: sampled at {file.samplerate} Hz; the filters run at {sample_rate:g} Hz: convert it "
                f"to that rate, or make filters of its rate: flexura focus with --sample-rate {file.samplerate}, "
                "and after it flexura compensate where compensation.h5 is there"
            )
        yield Sound(path, file.samplerate, file.frames, file.channels, file)


def _require_whole(path: Path) -> None:
    """Raise ResultFileError for a copy that was cut short: libsndfile gives what there is, without a word."""
    try:
        require_whole(path)
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error


@contextmanager
def _faults_named(path: Path) -> Iterator[None]:
    import soundfile

    try:
        yield
    except (soundfile.LibsndfileError, OSError, TypeError) as error:
        raise ResultFileError(
            f"{path}: cannot be read as sound ({error}); allowed: WAV, FLAC and the like"
        ) from error


def _shown(block: Real) -> str:
    return "NaN" if np.isnan(block).any() else "infinite"


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
