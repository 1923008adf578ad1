"""NPZ archives of numpy, never with pickled objects in them."""

import zipfile
from pathlib import Path

import numpy as np

from app.files.measurements.columns import MOST_BYTES, Columns, of_named_arrays


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
            return of_named_arrays({name: held[name] for name in held.files})
        except ValueError as error:
            if "allow_pickle" not in str(error):
                raise
            raise ValueError("holds Python objects, which are not read; save arrays of numbers only") from error
