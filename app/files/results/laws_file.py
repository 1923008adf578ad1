"""``laws.h5``: what updating found: E, nu, eta per sweep, the laws through them, and the twin's FRFs.

Filters in a folder of their own, named with ``--out``, know where the laws are that they were made from.

``laws.json`` holds one path, relative to its folder: ``laws``, a run folder or a file of laws, or ``twin``, a twin
file. Whether these are still the laws that the filters were made from, their SHA-256 in ``filters.h5`` says.
"""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes
from analysis.gap.data.groups import FEWEST, distinct_temperatures
from analysis.material import MaterialLaws
from analysis.updated import Updated
from app.files.atomic import atomic_hdf5, write_json
from app.files.bad_file import ResultFileError, quoted
from app.files.hdf5_file import read_value, result_file, write_value
from app.files.parsed_text import parse_json, read_text
from app.files.provenance import read_stamp, stamp
from app.files.results.pairing_json import checked_pairing

PAIRING = "pairing"


@dataclass(frozen=True)
class TwinFrf:
    """What the updated twin answers, gain included.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    h : (T, K, F) complex ndarray
        In the units of the transfers, one row per sweep.
    basis_error : float
        Stated error of the twin's reduced model, share of the peak.
    density : float
        Of the plate, kg/m3.
    """

    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    basis_error: float
    density: float

    def __post_init__(self) -> None:
        check_shapes(self, frequency="F", h="T K F")
        check_finite(self, "h")
        check_ascending(self, "frequency")
        check_range(self, 0.0, np.inf, "density", unit="kg/m3", above=True)


def save_laws(
    target: Path,
    updated: Updated,
    laws: MaterialLaws | None,
    twin: TwinFrf,
    made_from: Mapping[str, Any],
    pairing: Mapping[str, Any] | None = None,
) -> None:
    """Write the result of updating, whole or not at all.

    Parameters
    ----------
    laws : MaterialLaws or None
        None where there are too few temperatures for any.
    made_from : mapping
        Provenance.
    pairing : mapping, optional
        Of `app.files.results.pairing_json.pairing_record`.
    """
    with atomic_hdf5(target) as file:
        stamp(file, made_from)
        write_value(file.create_group("updated"), updated)
        write_value(file.create_group("twin"), twin)
        if laws is not None:
            write_value(file.create_group("laws"), laws)
        if pairing is not None:
            file.create_dataset(PAIRING, data=json.dumps(pairing, allow_nan=False))


def load_pairing(path: Path) -> dict[str, Any] | None:
    """Read the record of the paired modes; None where there is none, as in files of earlier versions."""
    with result_file(path, "update") as file:
        if PAIRING not in file:
            return None
        record: dict[str, Any] = parse_json(file[PAIRING].asstr()[()])
        return checked_pairing(record)


def load_laws(path: Path) -> MaterialLaws:
    """Read the laws; ResultFileError where updating had too few temperatures to make any."""
    found = laws_if_any(path)
    if found is None:
        updated, _ = load_updated(path)
        count = distinct_temperatures(updated.temperature[updated.settled])
        raise ResultFileError(
            f"{path}: holds estimates but no laws: they need settled estimates at {FEWEST} temperatures or more, "
            f"and there are {count}; measure more, then make it again: flexura update"
        )
    return found


def laws_if_any(path: Path) -> MaterialLaws | None:
    """Read the laws; None where updating had too few temperatures to make any."""
    with result_file(path, "update") as file:
        return read_value(file["laws"], MaterialLaws) if "laws" in file else None


def effects_in_laws(path: Path) -> dict[str, Any]:
    """Return the effects that were switched on when the laws were fitted, with their values; mostly none.

    ResultFileError where the file cannot be read.
    """
    with result_file(path, "update") as file:
        return dict(read_stamp(file)["settings"].get("effects", {}))


def load_updated(path: Path) -> tuple[Updated, TwinFrf]:
    """Read the estimates per sweep and the twin's FRFs."""
    with result_file(path, "update") as file:
        return read_value(file["updated"], Updated), read_value(file["twin"], TwinFrf)


POINTER, OWN = "laws.json", "laws.h5"


@dataclass(frozen=True)
class LawsElsewhere:
    """Where laws are: one of both.

    Attributes
    ----------
    laws : Path or None
        Run folder, or file of laws.
    twin : Path or None
        Twin file.
    """

    laws: Path | None = None
    twin: Path | None = None


def remember_laws(folder: Path, laws: Path, *, kind: Literal["run", "file", "twin"]) -> None:
    """Write where the laws are that results in a folder were made from, unless it is the run folder itself.

    Parameters
    ----------
    folder : Path
        Of the results.
    laws : Path
        File that they were read from.
    kind : str
        ``run``: the folder of that file, with its best twin; ``file``: that file alone; ``twin``: a twin file.
    """
    if (folder / OWN).is_file() or folder.resolve() == laws.resolve().parent:
        return
    target = laws.resolve().parent if kind == "run" else laws.resolve()
    try:
        there = os.path.relpath(target, folder.resolve())
    except ValueError:  # on another drive
        there = str(target)
    write_json(folder / POINTER, {"twin" if kind == "twin" else "laws": Path(there).as_posix()})


def laws_elsewhere(folder: Path) -> LawsElsewhere | None:
    """Return where the laws of a folder are; None where it has its own, or does not say.

    Raises
    ------
    ResultFileError
        Where nothing is at that place, or ``laws.json`` is damaged.
    """
    file = folder / POINTER
    if (folder / OWN).is_file() or not file.is_file():
        return None
    again = f"make the filters again: flexura focus, with the run folder of the laws and --out {quoted(folder)}"
    try:
        (key, there), *more = parse_json(read_text(file)).items()
        found = folder / there
        known = found.exists()
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise ResultFileError(f"{file}: does not say where the laws are ({error}); {again}") from error
    if more or key not in ("laws", "twin"):
        raise ResultFileError(f"{file}: key {key!r}; allowed: one of laws and twin; {again}")
    if not known:
        raise ResultFileError(
            f"{file}: {key} = {there!r}: nothing is there any more; correct the path, or {again}"
        )
    return LawsElsewhere(**{key: found})
