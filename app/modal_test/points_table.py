"""Places of nodes from a table."""

from pathlib import Path

import numpy as np

from app.files.bad_file import ResultFileError
from app.files.measurements.guarded import read_columns


def points_of_table(path: Path) -> dict[str, list[float]]:
    """Read nodes and their places.

    Parameters
    ----------
    path : Path
        Table of four columns: number of the node, x, y, z in m.

    Raises
    ------
    ResultFileError
        Where it holds something else; the message names the row.
    """
    columns = list(read_columns(path).values.values())
    if len(columns) != 4 or len({len(column) for column in columns}) > 1:
        raise ResultFileError(f"{path}: {len(columns)} columns; node, x, y and z (m) of all nodes are needed")
    places: dict[str, list[float]] = {}
    for row, (node, x, y, z) in enumerate(np.column_stack(columns).real, start=1):
        if not np.isfinite([node, x, y, z]).all() or node < 1 or node != round(node):
            message = (
                f"node {node:g} at {x:g}, {y:g}, {z:g}; allowed: a whole number from 1, and three numbers in m"
            )
            raise ResultFileError(f"{path}: row {row}: {message}")
        if str(round(node)) in places:
            raise ResultFileError(f"{path}: row {row}: node {node:g} occurs twice; give it one place")
        places[str(round(node))] = [float(x), float(y), float(z)]
    return places
