"""Coordinates of nodes in universal files, data sets 15 and 2411."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from app.files.uff_file import opened_uff
from app.files.uff_units import file_units

NODE_SETS = (15, 2411)
"""Nodes in single and in double precision."""

Position = tuple[float, float, float]


def read_nodes(path: Path) -> dict[int, Position]:
    """Read where the nodes of a universal file are, m: its data set 164 says in which unit they are written.

    Returns
    -------
    dict of int to (float, float, float)
        Empty where the file has no coordinates.

    Raises
    ------
    ValueError
        For a data set of nodes, or of units, that is damaged.
    """
    found: dict[int, Position] = {}
    with opened_uff(path) as (file, kinds):
        units = file_units(file, kinds)
        for number, kind in enumerate(kinds):
            if kind not in NODE_SETS:
                continue
            try:
                read: Any = file.read_sets(number)
            except Exception as error:  # damage leads the library into whatever there is
                raise ValueError(f"its data set of points ({kind}) cannot be read; damaged?") from error
            held: dict[str, Sequence[float]] = read[0] if isinstance(read, list) else read
            nodes = zip(*(held[name] for name in ("node_nums", "x", "y", "z")), strict=True)
            try:
                found |= {int(n): tuple(float(c) * units.metre for c in place) for n, *place in nodes}  # type: ignore[misc]
            except OverflowError as error:
                raise ValueError(f"a node's number is no whole number ({error}); damaged?") from error
    for node, place in found.items():
        if not np.isfinite(place).all():
            raise ValueError(f"node {node} is at {place}; coordinates must be finite numbers, m")
    return found
