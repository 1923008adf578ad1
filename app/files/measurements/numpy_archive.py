"""NPZ archives of numpy, never with pickled objects in them; FRFs and signals as SDynPy saves them, too."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.sampling import of_times
from app.files.measurements.columns import (
    FREQUENCY,
    MOST_BYTES,
    MOST_COLUMNS,
    Columns,
    add_rate,
    of_named_arrays,
    unused_name,
)

SDYNPY = frozenset({"abscissa", "ordinate", "coordinate"})
"""Fields of SDynPy's arrays: each entry is a function with its axis and the places of its ends."""
TIME_RESPONSE, FRF = 1, 4
"""Function types, as in universal files."""
AXES = {1: "x", 2: "y", 3: "z"}


def read(path: Path) -> Columns:
    """Read every array of numbers.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        For objects, for archives that unpack into too much, and where there is no column.
    """
    with zipfile.ZipFile(path) as archive:
        unpacked = sum(member.file_size for member in archive.infolist())
    if unpacked > MOST_BYTES:
        raise ValueError(f"unpacks into {unpacked} bytes; at most {MOST_BYTES} allowed")
    with np.load(path, allow_pickle=False) as held:
        try:
            arrays = {name: held[name] for name in held.files}
        except ValueError as error:
            if "allow_pickle" not in str(error):
                raise
            raise ValueError("holds Python objects, which are not read; save arrays of numbers only") from error
    structured = {name: one for name, one in arrays.items() if one.dtype.names}
    for one in structured.values():
        if SDYNPY.issubset(one.dtype.names or ()):
            kind = arrays.get("function_type", np.array([FRF]))
            return _of_sdynpy(one.reshape(-1), int(kind.reshape(-1)[0]))
    try:
        return of_named_arrays(arrays)
    except ValueError as error:
        if not structured:
            raise
        name, one = next(iter(structured.items()))
        raise ValueError(
            f"{name} is a structured array with the fields {', '.join(one.dtype.names or ())}; save each field of "
            "numbers as an array of its own"
        ) from error


def _of_sdynpy(functions: NDArray[Any], kind: int) -> Columns:
    """Columns of SDynPy's functions, by the places of their ends."""
    if kind not in (TIME_RESPONSE, FRF):
        raise ValueError(
            f"functions of SDynPy of type {kind}; allowed: 1 (time response) and 4 (FRF). Compute FRFs, or export "
            "them as a universal file"
        )
    if not 0 < len(functions) <= MOST_COLUMNS:
        raise ValueError(f"{len(functions)} functions of SDynPy; 1 to {MOST_COLUMNS} allowed")
    abscissa = np.asarray(functions["abscissa"], dtype=float).reshape(len(functions), -1)
    ordinate = functions["ordinate"].reshape(len(functions), -1)
    ends = functions["coordinate"].reshape(len(functions), -1)
    if abscissa.shape != ordinate.shape or not (abscissa == abscissa[0]).all():
        raise ValueError("functions of SDynPy with different axes; save those of one axis in a file")
    values: dict[str, NDArray[Any]] = {FREQUENCY: abscissa[0]} if kind == FRF else {}
    columns = Columns(values | {"": abscissa[0]})
    columns.values.pop("")
    for row, places in zip(ordinate, ends, strict=True):
        named = [_place(int(one["node"]), int(one["direction"])) for one in places]
        name = unused_name(" / ".join(named), columns.values)
        columns.values[name] = np.asarray(row, dtype=complex if kind == FRF else float)
        if named and ":" in named[0]:
            columns.places[name] = named[0]
        if kind == FRF and len(named) > 1 and ":" in named[1]:
            columns.references[name] = named[1]
        if kind == TIME_RESPONSE:
            add_rate(columns, name, [of_times(abscissa[0], "its abscissa")])
    return columns


def _place(node: int, direction: int) -> str:
    """Node and direction as in declarations, ``5:+z``; of rotations the numbers only, which no declaration has."""
    axis = AXES.get(abs(direction))
    return f"{node}:{'+' if direction > 0 else '-'}{axis}" if axis and node > 0 else f"{node} {direction:+d}"
