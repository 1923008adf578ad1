"""``latest.h5``: the repeat recorded last, replaced by the next; for people to look at, never analysed."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_range, check_shapes
from app.files.atomic import atomic_hdf5
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.values import read_value, write_value

NAME = "latest.h5"


@dataclass(frozen=True)
class LatestRepeat:
    """One repeat as it came from the cards.

    Attributes
    ----------
    step, repeat : int
        Which sweep, and which of its repeats, from 0.
    place : str
        Temperature, direction and level in words.
    channels : tuple of str
        The drive, then the sensors.
    signals : (1 + K, M) ndarray
        V.
    overloaded : (1 + K,) bool ndarray
        Channels that came near the inputs' range.
    sample_rate : float
        Hz.
    full_scale : float
        V.
    """

    step: int
    repeat: int
    place: str
    channels: tuple[str, ...]
    signals: NDArray[np.float32]
    overloaded: NDArray[np.bool_]
    sample_rate: float
    full_scale: float

    def __post_init__(self) -> None:
        check_shapes(self, channels="c", signals="c M", overloaded="c")
        check_range(self, 0.0, np.inf, "sample_rate", unit="Hz", above=True)


def save_latest(folder: Path, latest: LatestRepeat) -> None:
    """Replace the file, whole or not at all."""
    with atomic_hdf5(folder / NAME) as file:
        write_value(file.create_group("repeat"), latest)


def load_latest(folder: Path) -> LatestRepeat | None:
    """Read it; None where there is none, or none that can be read just now."""
    try:
        with opened_hdf5(folder / NAME) as file:
            return read_value(file["repeat"], LatestRepeat)
    except Hdf5FileError:
        return None
