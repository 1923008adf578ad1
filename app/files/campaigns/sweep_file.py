"""One finished sweep: a closed HDF5 file that carries a digest of its own contents.

Those of versions that did not seal their files (see `app.files.hdf5_file`) are read, too: a measurement cannot
be made again.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.recordings.campaign import Sweep
from app.files.atomic import atomic_hdf5
from app.files.campaign_error import Problem
from app.files.campaigns.coverage import Place
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.isolation import require_readable

PLATE = ("plate_temperature_start", "plate_temperature_end")
"""Only where a sensor was on the plate."""
PROPERTIES = ("step", "direction", "level", "oven_temperature_start", "oven_temperature_end", "start_time")
DOUBT = "temperature_doubt"
"""Only where the rig doubted the plate's temperature; for people, and for the notes of results."""
REMEDY = "delete the folder and import the campaign again"


@dataclass(frozen=True)
class Source:
    """What a sweep came from: a recording's file, or the experiment it was acquired for.

    Attributes
    ----------
    file : str
        Its name.
    sha256 : str
    """

    file: str
    sha256: str


def file_name(sweep: Sweep, place: Place) -> str:
    """Name of a sweep's file: ``0006_up_T+012.0.h5``."""
    return f"{sweep.step:04d}_{sweep.direction}_T{place.temperature:+06.1f}.h5"


def digest(sweep: Sweep) -> str:
    """SHA-256 of a sweep's properties and samples, the same on every machine."""
    properties = json.dumps([getattr(sweep, name) for name in _properties(sweep)])
    found = hashlib.sha256(properties.encode())
    for samples in (sweep.drive, sweep.responses):
        found.update(repr(samples.shape).encode())
        found.update(np.ascontiguousarray(samples, dtype="<f4").tobytes())
    return found.hexdigest()


def write_sweep(
    path: Path,
    sweep: Sweep,
    sensors: tuple[str, ...],
    source: Source,
    notes: Mapping[str, str | int | float] | None = None,
    units: tuple[str, ...] = (),
) -> None:
    """Write a sweep, whole or not at all; nothing opens the file for writing again.

    Parameters
    ----------
    sensors : tuple of str
        Names of the responses.
    notes : mapping, optional
        Further attributes, for people: how often it was tried, say.
    units : tuple of str, optional
        Of the drive, then of each response; volts unless given.
    """
    with atomic_hdf5(path) as file:
        for name in _properties(sweep):
            file.attrs[name] = getattr(sweep, name)
        for name, value in (notes or {}).items():
            file.attrs[name] = value
        if sweep.doubt:
            file.attrs[DOUBT] = sweep.doubt
        file.attrs["sensors"] = json.dumps(sensors)
        file.attrs["source_file"] = source.file
        file.attrs["source_sha256"] = source.sha256
        file.attrs["sweep_sha256"] = digest(sweep)
        for name, samples in (("drive", sweep.drive), ("responses", sweep.responses)):
            data = file.create_dataset(name, data=samples.astype("<f4"))
            mine = units[:1] if name == "drive" else units[1:]
            data.attrs["unit"] = json.dumps(mine) if len(set(mine)) > 1 else (mine or ("V",))[0]
        file["drive"].attrs["axes"] = "repeat, sample"
        file["responses"].attrs["axes"] = "sensor, repeat, sample"


def read_sweep_file(path: Path, name: str) -> tuple[Sweep | None, Problem | None]:
    """Read a sweep back and hold it against its digest.

    Parameters
    ----------
    name : str
        What the problem calls the file.

    Returns
    -------
    sweep : Sweep or None
    problem : Problem or None
        One of both is None.
    """
    try:
        with opened_hdf5(path, unsealed=require_readable) as file:
            stored = str(file.attrs["sweep_sha256"])
            sweep = Sweep(
                step=int(file.attrs["step"]),
                direction=str(file.attrs["direction"]),  # type: ignore[arg-type]
                level=float(file.attrs["level"]),
                oven_temperature_start=float(file.attrs["oven_temperature_start"]),
                oven_temperature_end=float(file.attrs["oven_temperature_end"]),
                start_time=str(file.attrs["start_time"]),
                drive=file["drive"][()],
                responses=file["responses"][()],
                source=int(file.attrs.get("source", 0)),
                doubt=str(file.attrs.get(DOUBT, "")),
                **{name: float(file.attrs[name]) for name in PLATE if name in file.attrs},
            )
    except Hdf5FileError as error:
        return None, Problem(name, "", f"unreadable ({error})", "a whole sweep file", REMEDY)
    if digest(sweep) != stored:
        return None, Problem(name, "sweep_sha256", stored[:12], "the digest of the samples in the file", REMEDY)
    return sweep, None


def _properties(sweep: Sweep) -> tuple[str, ...]:
    plate = () if sweep.plate_temperature_start is None else PLATE
    return (*PROPERTIES, *plate, *(("source",) if sweep.source else ()))
