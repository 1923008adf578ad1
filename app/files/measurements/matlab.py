"""MAT files: versions 5 to 7 through scipy, 7.3, which is HDF5, through h5py.

A list of structures, ``run(1:3).force``, is a group for each: hits and runs are kept so. Version 7.3 keeps it as
one list of references for each field, without a class.
"""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d
from numpy.typing import NDArray

from app.files.measurements.columns import MOST_COLUMNS, Columns, of_named_arrays

DEEPEST = 4
"""Structures in structures."""


def read(path: Path) -> Columns:
    """Read every array of numbers, in structures and cells too: ``test.force``, ``H{2}``, ``run(2).force``.

    Parameters
    ----------
    path : Path
        Of MATLAB's older formats, or HDF5 (version 7.3).

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        For data kept in other files, and where there is no column.
    """
    arrays: dict[str, NDArray[Any]] = {}
    if h5py.is_hdf5(path):
        with h5py.File(path) as file:
            for name in file:
                _from_hdf5(file, name, name, arrays, 0)
    else:
        from scipy.io import loadmat

        for name, value in loadmat(path, struct_as_record=True).items():
            if not name.startswith("__"):
                _from_value(value, name, arrays, 0)
    return _grouped(of_named_arrays(arrays))


IN_LIST = re.compile(r"(.*(?:\(\d+\)|\{\d+\}))\.(.+)")
"""A field of one structure of a list: ``run(2).force``, ``test.run{2}.acc[1]``."""


def _grouped(columns: Columns) -> Columns:
    """Return the columns with each structure of a list as a group, if all hold the same signals."""
    found = {name: match for name in columns.values if (match := IN_LIST.fullmatch(name))}
    channels = {name: match[2] for name, match in found.items()}
    if len({match[1] for match in found.values()}) < 2 or any(
        np.iscomplexobj(columns.values[n]) for n in channels
    ):
        return columns  # FRFs in a list are those of several points, not several hits
    grouped = replace(columns, channels=channels, shared=tuple(n for n in columns.values if n not in channels))
    return grouped if grouped.groups else columns


def _from_value(value: Any, name: str, arrays: dict[str, NDArray[Any]], depth: int) -> None:
    array = np.asarray(value)
    parts = list(array.T.reshape(-1)) if array.dtype == object or array.dtype.names else []
    if array.dtype.kind in "biufc":
        arrays[name] = array
    elif depth >= DEEPEST or len(parts) > MOST_COLUMNS:
        return
    for number, part in enumerate(parts, start=1):
        if array.dtype.names:
            place = name if len(parts) == 1 else f"{name}({number})"
            for key in array.dtype.names:
                _from_value(part[key], f"{place}.{key}", arrays, depth + 1)
        else:
            _from_value(part, name if len(parts) == 1 else f"{name}{{{number}}}", arrays, depth + 1)


def _from_hdf5(group: h5py.Group, key: str, place: str, arrays: dict[str, NDArray[Any]], depth: int) -> None:
    """Add what a group has under a key."""
    if key.startswith("#") or not isinstance(group.get(key, getlink=True), h5py.HardLink):
        return  # where MATLAB keeps what cells refer to, and links to other files
    _from_object(group[key], place, arrays, depth)


def _from_object(held: Any, place: str, arrays: dict[str, NDArray[Any]], depth: int) -> None:
    if isinstance(held, h5py.Group):
        for key in held if depth < DEEPEST else ():
            if _is_field_of_list(held, key):
                for number, reference in enumerate(held[key][()].reshape(-1), start=1):
                    part = held.file[reference] if reference else None
                    _from_object(part, f"{place}({number}).{key}", arrays, depth + 1)
            else:
                _from_hdf5(held, key, f"{place}.{key}", arrays, depth + 1)
    elif isinstance(held, h5py.Dataset):
        made = held.id.get_create_plist()
        if made.get_layout() == h5d.VIRTUAL or made.get_external_count() or held.shape is None:
            raise ValueError(f"{place} lies in other files; save it again with its data")
        kind = held.attrs.get("MATLAB_class", "double")
        kind = kind.decode() if isinstance(kind, bytes) else kind
        if kind == "cell" and held.dtype == h5py.ref_dtype and held.size <= MOST_COLUMNS and depth < DEEPEST:
            for number, reference in enumerate(held[()].reshape(-1), start=1):
                name = place if held.size == 1 else f"{place}{{{number}}}"
                _from_object(held.file[reference] if reference else None, name, arrays, depth + 1)
        elif "MATLAB_empty" in held.attrs or kind == "char":
            return  # texts and the sizes of empty arrays are kept as numbers, too
        elif held.dtype.names == ("real", "imag"):
            parts = held[()].T  # MATLAB's first axis is HDF5's last
            arrays[place] = parts["real"] + 1j * parts["imag"]
        elif held.dtype.kind in "biuf":
            arrays[place] = held[()].T


def _is_field_of_list(group: h5py.Group, key: str) -> bool:
    """Whether a group's field is kept as references to the values of a list of structures."""
    if not isinstance(group.get(key, getlink=True), h5py.HardLink) or not isinstance(group[key], h5py.Dataset):
        return False
    held = group[key]
    made = held.id.get_create_plist()
    elsewhere = made.get_layout() == h5d.VIRTUAL or made.get_external_count() or held.shape is None
    if elsewhere or held.dtype != h5py.ref_dtype or "MATLAB_class" in held.attrs:
        return False
    return bool(1 < held.size <= MOST_COLUMNS)
