"""MDF 3 and 4 of vehicle recorders (ASAM), through asammdf: every channel of numbers over its group's times."""

import logging
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimation.sampling import of_times
from app.files.measurements.columns import Columns, add_rate, unused_name

NEEDS = "MDF files need the extra mdf: pip install 'flexura[mdf]'; or export CSV, TDMS or MAT"
TIME = 1
"""Kind of a group's axis that is time; others are angles, distances and indices."""


def read(path: Path) -> Columns:
    """Read every channel of numbers, in physical units; a group's name before those that several groups have.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns
        Samples that the file marks as invalid are left out, so that the channel's times have gaps.

    Raises
    ------
    ValueError
        Where there is no such channel, or asammdf is not installed.
    """
    if find_spec("asammdf") is None:
        raise ValueError(NEEDS)
    with _said_by_asammdf() as said, import_module("asammdf").MDF(path) as file:
        signals = list(_signals(file))
    often = Counter(signal.name for _, signal in signals)
    columns = Columns(_named(signals, often), notes=tuple(f"asammdf says: {one}" for one in dict.fromkeys(said)))
    for name, (_, signal) in zip(columns.values, signals, strict=True):
        if often[signal.name] > 1:
            columns.channels[name] = signal.name
        if signal.unit:
            columns.units[name] = str(signal.unit)
        _add_times(columns, name, signal)
    return columns


def _signals(file: Any) -> Iterator[tuple[str, Any]]:
    """Yield the name of the group and the signal of every channel of numbers, axes of groups left out."""
    for number, group in enumerate(file.groups):
        called = str(getattr(group.channel_group, "acq_name", "") or f"group {number + 1}")
        for index, channel in enumerate(group.channels):
            if index == file.masters_db.get(number):
                continue
            signal = file.get(channel.name, group=number, index=index)
            if signal.samples.ndim == 1 and signal.samples.dtype.kind in "biuf" and signal.samples.size > 1:
                yield called, signal


def _named(signals: list[tuple[str, Any]], often: Counter[str]) -> dict[str, np.ndarray]:
    values: dict[str, np.ndarray] = {}
    for group, signal in signals:
        wanted = signal.name if often[signal.name] == 1 else f"{group}/{signal.name}"
        values[unused_name(wanted, values)] = np.asarray(signal.samples, dtype=float)
    return values


def _add_times(columns: Columns, name: str, signal: Any) -> None:
    axis = signal.master_metadata
    if axis is not None and axis[1] != TIME:
        columns.doubts[name] = f"its axis {axis[0]!r} is no time: it cannot be a signal; export it over time"
        return
    times = np.asarray(signal.timestamps, dtype=float)
    try:
        add_rate(columns, name, [of_times(times, f"times of {name}")])
        columns.starts[name] = float(times[0])
    except ValueError as error:
        columns.doubts[name] = str(error)


@contextmanager
def _said_by_asammdf() -> Iterator[list[str]]:
    """Collect what asammdf logs as a warning: samples that it could not convert, and the like."""
    said: list[str] = []

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            said.append(" ".join(record.getMessage().split())[:300])

    listener, logger = Listener(logging.WARNING), logging.getLogger("asammdf")
    logger.addHandler(listener)
    try:
        yield said
    finally:
        logger.removeHandler(listener)
