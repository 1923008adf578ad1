"""Measured transfers of a panel: universal files (data sets 58, nodes from 15 or 2411) and HDF5."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.transfer import INTEGRATED, MeasuredTransfer, direction_sign
from analysis.focusing.measured import MeasuredTransfers
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.hdf5_file import Hdf5FileError, opened_hdf5
from app.files.isolation import require_readable
from app.files.uff.frfs import read_frfs
from app.files.uff.geometry import read_nodes

NAMED = re.compile(r"(?:.*[_ ])?([-+]?\d+(?:\.\d+)?) ?°?C")
"""Name, without its ending, of a universal file measured at one of several temperatures: scan_21.5C."""
NAMES = ("temperature", "points", "frequency", "transfer", "variance")
UNITS = {"displacement": ("m",), "velocity": ("m/s",), "acceleration": ("m/s^2", "m/s2", "m/s²")}


def read_transfers(path: Path, band: tuple[float, float], temperature: float) -> MeasuredTransfers:
    """Read measured transfers that cover a band.

    Parameters
    ----------
    path : Path
        HDF5, by its ending, a universal file, or a folder of universal files, one a temperature.
    band : (float, float)
        Which they have to cover to within a line, Hz.
    temperature : float
        At which a universal file was measured, degrees Celsius; files of a folder say it in their names.

    Raises
    ------
    ResultFileError
        Naming the file and what is missing: transfers, positions of nodes, lines of the band.
    """
    try:
        if path.is_dir():
            found = _folder(path)
        else:
            found = _hdf5(path) if path.suffix.lower() in (".h5", ".hdf5") else _uff(path, temperature)[0]
    except ResultFileError:
        raise
    except ValueError as error:
        raise ResultFileError(f"{path}: {error}") from error
    low, high = found.frequency[0], found.frequency[-1]
    spacing = float(np.median(np.diff(found.frequency)))
    if low > band[0] + spacing or high < band[1] - spacing:
        raise ResultFileError(
            f"{path}: transfers from {low:g} to {high:g} Hz; filters.edges ask for {band[0]:g} to {band[1]:g} Hz: "
            "measure wider, or narrow band and edges"
        )
    return found


def transfer_files(path: Path) -> tuple[Path, ...]:
    """Return the files that transfers are read from: `path`, or the universal files of this folder."""
    if not path.is_dir():
        return (path,)
    # Names that begin with a point are notes of the system's own, as macOS leaves beside every file.
    seen = (one for one in path.iterdir() if not one.name.startswith("."))
    return tuple(sorted(one for one in seen if one.suffix.lower() in (".uff", ".unv")))


def write_transfers(path: Path, transfers: MeasuredTransfers) -> None:
    """Write transfers as HDF5: ``temperature``, ``points``, ``frequency``, ``transfer`` and ``variance``."""
    with atomic_hdf5(path) as file:
        file.attrs["format"] = "flexura-transfers/1"
        for name in ("temperature", "points", "frequency", "transfer", "variance"):
            file.create_dataset(name, data=getattr(transfers, name))


def _hdf5(path: Path) -> MeasuredTransfers:
    """Read an HDF5 file of any program with the datasets; variance and the axis of one temperature may lack."""
    if not path.is_file():
        raise ValueError("no such file")
    try:
        with opened_hdf5(path, unsealed=require_readable) as file:
            held: dict[str, Any] = {name: np.asarray(file[name][()]) for name in file if name in NAMES}
    except Hdf5FileError as error:
        raise ValueError(f"not a readable HDF5 file ({error.__cause__ or error})") from error
    for name in ("temperature", "points", "frequency", "transfer"):
        if name not in held:
            raise ValueError(f"lacks the dataset {name!r}; needed: {', '.join(NAMES[:4])}, and variance if known")
    for name, values in held.items():
        if values.dtype.kind not in "iufc":
            raise ValueError(f"the dataset {name!r} is of type {values.dtype}; allowed: numbers")
    transfer = np.asarray(held["transfer"], dtype=complex)
    transfer = transfer[None] if transfer.ndim == 3 else transfer
    variance = np.asarray(held.get("variance", np.zeros(transfer.shape)), dtype=float).reshape(transfer.shape)
    temperature = np.atleast_1d(np.asarray(held["temperature"], dtype=float))
    points, frequency = np.asarray(held["points"], dtype=float), np.asarray(held["frequency"], dtype=float)
    return MeasuredTransfers(temperature, points, frequency, transfer, variance)


def _uff(path: Path, temperature: float) -> tuple[MeasuredTransfers, list[int]]:
    """Transfers of a universal file, and the nodes of the actuators."""
    frfs = read_frfs(path)
    places = read_nodes(path)
    frequency = frfs[0].frequency
    for frf in frfs:
        if len(frf.frequency) != len(frequency) or not np.allclose(frf.frequency, frequency, rtol=1e-6):
            raise ValueError(f"{frf.name}: lines other than those of {frfs[0].name}; all transfers need the same")
    responses = sorted({int(frf.response.split(":")[0]) for frf in frfs})
    references = sorted({int(frf.reference.split(":")[0]) for frf in frfs})
    unknown = [node for node in responses if node not in places]
    if unknown:
        raise ValueError(f"node {unknown[0]} has no coordinates; needed: a data set 15 or 2411 with all nodes, m")
    transfer = np.full((1, len(references), len(frequency), len(responses)), np.nan, dtype=complex)
    variance = np.zeros(transfer.shape)
    taken: dict[tuple[int, int], str] = {}
    for frf in frfs:
        node, source = (int(end.split(":")[0]) for end in (frf.response, frf.reference))
        if taken.get((node, source)) == frf.response:
            raise ValueError(
                f"node {node} answers node {source} more than once as {frf.response}; are these several "
                "temperatures? Write one file for each, named by it (scan_21.5C.uff), and name their folder"
            )
        if (node, source) in taken:
            raise ValueError(
                f"node {node} answers node {source} twice, as {taken[node, source]} and {frf.response}; "
                "keep one FRF of each pair, that across the plate"
            )
        taken[node, source] = frf.response
        place = (0, references.index(source), slice(None), responses.index(node))
        transfer[place], variance[place] = _displacement(frf)
    points = np.array([places[node][:2] for node in responses])
    return MeasuredTransfers(np.array([temperature]), points, frequency, transfer, variance), references


def _folder(path: Path) -> MeasuredTransfers:
    """Read one universal file per temperature and join them; all have the same nodes, actuators and lines."""
    files = transfer_files(path)
    if not files:
        raise ValueError("a folder without universal files (.uff, .unv); one for each temperature is needed")
    read: dict[float, tuple[Path, MeasuredTransfers, list[int]]] = {}
    for one in files:
        named = NAMED.fullmatch(one.stem)
        if named is None:
            raise ValueError(f"{one.name} has no temperature in its name; name it as scan_21.5C{one.suffix}")
        temperature = float(named[1])
        if temperature in read:
            raise ValueError(
                f"{read[temperature][0].name} and {one.name} are both of {temperature:g} °C; keep one of them"
            )
        try:
            read[temperature] = one, *_uff(one, temperature)
        except ResultFileError:
            raise
        except ValueError as error:
            raise ValueError(f"{one.name}: {error}") from error
    (first, like, driven), *others = (read[temperature] for temperature in sorted(read))
    for one, found, actuators in others:
        same = {"actuators": actuators == driven}
        for name in ("points", "frequency"):
            mine, theirs = getattr(like, name), getattr(found, name)
            same[name] = mine.shape == theirs.shape and np.allclose(mine, theirs, rtol=1e-6)
        for name, alike in same.items():
            if not alike:
                raise ValueError(
                    f"{one.name} and {first.name} differ in their {name}; "
                    "export all temperatures with the same nodes, actuators and lines"
                )
    every = [like, *(found for _, found, _ in others)]
    transfer, variance = (np.concatenate([getattr(one, name) for one in every]) for name in NAMES[3:])
    return MeasuredTransfers(np.array(sorted(read)), like.points, like.frequency, transfer, variance)


def _displacement(frf: MeasuredTransfer) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Displacement along the node's axis per unit of the drive, and its variance: 0 without a coherence."""
    times = INTEGRATED.get(frf.quantity)
    if times is None:
        raise ValueError(f"{frf.name}: {frf.quantity}; allowed: {', '.join(INTEGRATED)}")
    unit = frf.units[0]
    if unit and unit not in UNITS[frf.quantity]:
        raise ValueError(f"{frf.name}: {frf.quantity} in {unit}; allowed: {UNITS[frf.quantity][0]}")
    sign = direction_sign(frf.response)
    omega = 2.0 * np.pi * frf.frequency
    variance = np.zeros(frf.h.shape) if frf.variance is None else np.asarray(frf.variance / omega ** (2 * times))
    return np.asarray(sign * frf.h / (1j * omega) ** times), variance
