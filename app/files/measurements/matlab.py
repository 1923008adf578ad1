"""MAT files: versions 5 to 7 through scipy, 7.3, which is HDF5, through h5py."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d
from numpy.typing import NDArray

from app.files.measurements.columns import Columns, of_named_arrays

DEEPEST = 4
"""Structures in structures."""


def read(path: Path) -> Columns:
    """Read every array of numbers, in structures too: ``test.force``.

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
            _from_group(file, "", arrays, 0)
    else:
        from scipy.io import loadmat

        for name, value in loadmat(path, squeeze_me=True, struct_as_record=True).items():
            if not name.startswith("__"):
                _from_value(value, name, arrays, 0)
    return of_named_arrays(arrays)


def _is_array(held: h5py.Dataset) -> bool:
    """Whether numbers are numbers: MATLAB keeps texts and the sizes of empty arrays as such, too."""
    kind = held.attrs.get("MATLAB_class", "double")
    return "MATLAB_empty" not in held.attrs and (kind.decode() if isinstance(kind, bytes) else kind) != "char"


def _from_value(value: Any, name: str, arrays: dict[str, NDArray[Any]], depth: int) -> None:
    array = np.asarray(value)
    if array.dtype.names and array.size == 1 and depth < DEEPEST:
        for part in array.dtype.names:
            _from_value(array.reshape(-1)[0][part], f"{name}.{part}", arrays, depth + 1)
    elif array.dtype == object and array.size == 1 and depth < DEEPEST:
        _from_value(array.reshape(-1)[0], name, arrays, depth + 1)
    elif array.dtype.kind in "biufc":
        arrays[name] = array


def _from_group(group: h5py.Group, path: str, arrays: dict[str, NDArray[Any]], depth: int) -> None:
    for name in group:
        if name.startswith("#") or not isinstance(group.get(name, getlink=True), h5py.HardLink):
            continue  # cells and texts of MATLAB's, and links to other files
        held, place = group[name], f"{path}{name}"
        if isinstance(held, h5py.Group) and depth < DEEPEST:
            _from_group(held, f"{place}.", arrays, depth + 1)
        elif isinstance(held, h5py.Dataset):
            made = held.id.get_create_plist()
            if made.get_layout() == h5d.VIRTUAL or made.get_external_count() or held.shape is None:
                raise ValueError(f"{place} lies in other files; save it again with its data")
            if held.dtype.names == ("real", "imag"):
                parts = held[()]
                arrays[place] = parts["real"] + 1j * parts["imag"]
            elif held.dtype.kind in "biuf" and _is_array(held):
                arrays[place] = held[()]
