"""Sound from a file: WAV, FLAC and whatever else libsndfile reads, in blocks, checked as it comes."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from app.files.bad_file import ResultFileError


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
        if file.frames <= 0:
            raise ResultFileError(f"{path}: holds no samples")
        if sample_rate is not None and file.samplerate != sample_rate:
            raise ResultFileError(
                f"{path}: sampled at {file.samplerate} Hz; the filters run at {sample_rate:g} Hz: convert it "
                f"to that rate, or make filters of its rate: flexura focus RUN --sample-rate {file.samplerate}"
            )
        yield Sound(path, file.samplerate, file.frames, file.channels, file)


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
