"""Time responses in universal files (data set 58, function type 1), through pyuff, by node and direction."""

from pathlib import Path
from typing import Any

import numpy as np

from app.files.measurements.columns import Columns, unused_name
from app.files.uff58 import dof, functions

TIME = 1
UNEVEN = 1e-3
"""Spread of the samples' spacing, relative to it, that rounding in the file may cause."""


def read(path: Path) -> Columns:
    """Read every time response; where the same ones follow again and again, each time as a group, ``run 2``.

    Parameters
    ----------
    path : Path
        Universal file with data sets 58.

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        Where there is none, with what there is; where one is cut short or not evenly spaced.
    """
    held = [data for data in functions(path) if int(data["func_type"]) == TIME]
    run = _run_length([(dof(data, "rsp"), data.get("ordinate_spec_data_type"), _unit(data)) for data in held])
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    rates: dict[str, float] = {}
    places: dict[str, str] = {}
    channels: dict[str, str] = {}
    for number, data in enumerate(held):
        before = f"run {number // run + 1}/" if run < len(held) else ""
        name = unused_name(before + dof(data, "rsp"), columns)
        if before:
            channels[name] = name.removeprefix(before)
        time, values = np.asarray(data["x"], dtype=float), np.asarray(data["data"])
        if len(time) != len(values) or len(time) < 2:
            raise ValueError(f"time response {name}: {len(values)} values at {len(time)} times; cut short?")
        step = np.diff(time)
        if not (step > 0.0).all() or np.ptp(step) > UNEVEN * np.median(step):
            raise ValueError(
                f"time response {name}: its samples are not evenly spaced; resample it where it came from"
            )
        columns[name] = np.asarray(values.real, dtype=float)
        rates[name] = float((len(time) - 1) / (time[-1] - time[0]))
        if place := _place(data):
            places[name] = place
        if unit := _unit(data):
            units[name] = unit
    if not columns:
        raise ValueError(
            "no time response (data set 58, function type 1); for FRFs type: flexura identify FILE.uff"
        )
    return Columns(columns, units, rates, channels=channels, places=places)


def _run_length(kinds: list[tuple[Any, ...]]) -> int:
    """Return after how many responses the same ones begin again, two at least; all where they do not."""
    lengths = (n for n in range(2, len(kinds)) if len(kinds) % n == 0)
    return next((n for n in lengths if kinds == kinds[:n] * (len(kinds) // n)), len(kinds))


def _unit(data: dict[str, Any]) -> str:
    unit = str(data.get("ordinate_axis_units_lab", "")).strip()
    return "" if unit == "NONE" else unit


def _place(data: dict[str, Any]) -> str:
    """Node and direction of a response as in declarations, ``5:+z``; empty where it is not along an axis."""
    node, direction = int(data.get("rsp_node", 0)), int(data.get("rsp_dir", 0))
    if node < 1 or not 1 <= abs(direction) <= 3:
        return ""
    return f"{node}:{'+' if direction > 0 else '-'}{'xyz'[abs(direction) - 1]}"
