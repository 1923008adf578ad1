"""``frf.h5``: the FRFs of a campaign."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py

from analysis.frf import Frf
from app.files.atomic import atomic_hdf5
from app.files.provenance import stamp
from app.files.values import read_value, write_value


def save_frf(target: Path, frf: Frf, made_from: Mapping[str, Any]) -> None:
    """Write FRFs, whole or not at all."""
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        write_value(file.create_group("frf"), frf)


def load_frf(path: Path) -> Frf:
    """Read back what `save_frf` wrote."""
    with h5py.File(path) as file:
        return read_value(file["frf"], Frf)
