"""A universal file opened by pyuff, after what that library cannot read is written in the way it can."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyuff

from app.files.parsed_text import read_bytes
from app.files.uff_sets import data_sets, plain_exponents

LARGEST = 2_000_000_000
"""Bytes above which a file is refused rather than read into memory."""


@contextmanager
def opened_uff(path: Path) -> Iterator[tuple[pyuff.UFF, list[int]]]:
    """Yield the file to read sets from, and the types of all its data sets in order.

    Parameters
    ----------
    path : Path

    Yields
    ------
    file : pyuff.UFF
    kinds : list of int

    Raises
    ------
    ValueError
        Where it is damaged or too large.
    """
    content = read_bytes(path, LARGEST)
    kinds = data_sets(content)
    plain = plain_exponents(content)
    with tempfile.TemporaryDirectory(prefix="flexura-") as folder:
        source = path
        if plain != content:
            source = Path(folder) / "plain.uff"
            source.write_bytes(plain)
        file = pyuff.UFF(str(source))
        if kinds != [int(kind) for kind in np.atleast_1d(file.get_set_types())]:
            raise ValueError("a line within a data set ends as if the set did; damaged?")
        yield file, kinds
