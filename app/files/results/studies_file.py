"""``studies.h5``: what the figures of the paper show of a panel."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.compensation.outcome import Compensation, NetworkStudy
from analysis.focusing.over_temperature import Focusing
from analysis.focusing.panel import Panel
from analysis.focusing.played import Played
from app.files.atomic import atomic_hdf5
from app.files.hdf5_file import result_file
from app.files.results.filter_files import begin_result
from app.files.values import read_value, write_value


@dataclass(frozen=True)
class Surfaces:
    """Taps of the networks over temperature (paper Fig. 16).

    Attributes
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.
    taps : (T, N, M) ndarray
        V per unit of audio signal.
    sample_rate : float
        Hz.
    """

    temperature: NDArray[np.float64]
    taps: NDArray[np.float64]
    sample_rate: float

    def __post_init__(self) -> None:
        check_shapes(self, temperature="T", taps="T N M")
        check_finite(self, "taps")
        check_range(self, 0.0, np.inf, "sample_rate", unit="Hz", above=True)


@dataclass(frozen=True)
class Studies:
    """What the figures asked for need; None where no figure asked for it."""

    played: Played | None = None
    fixed: Focusing | None = None
    compensation: Compensation | None = None
    surfaces: Surfaces | None = None
    nodes: NetworkStudy | None = None
    spacings: NetworkStudy | None = None


KINDS: Mapping[str, type] = {
    "played": Played,
    "fixed": Focusing,
    "compensation": Compensation,
    "surfaces": Surfaces,
    "nodes": NetworkStudy,
    "spacings": NetworkStudy,
}


def save_studies(target: Path, panel: Panel, studies: Studies, made_from: Mapping[str, Any]) -> None:
    """Write what was computed, whole or not at all.

    Parameters
    ----------
    made_from : mapping
        Provenance.
    """
    with atomic_hdf5(target) as file:
        begin_result(file, panel, made_from)
        for name in KINDS:
            value = getattr(studies, name)
            if value is not None:
                write_value(file.create_group(name), value)


def load_studies(path: Path) -> Studies:
    """Read back what `save_studies` wrote."""
    with result_file(path, "study") as file:
        held: dict[str, Any] = {
            name: read_value(_group(file, name), kind) for name, kind in KINDS.items() if name in file
        }
        return Studies(**held)


def _group(file: h5py.File, name: str) -> h5py.Group:
    group: h5py.Group = file[name]
    return group
