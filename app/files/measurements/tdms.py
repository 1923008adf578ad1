"""TDMS of any layout, through npTDMS: channels by name, with their group before it where names repeat."""

from collections import Counter
from pathlib import Path

import numpy as np
from nptdms import TdmsFile

from app.files.measurements.columns import Columns, unused_name

UNITS = ("unit_string", "NI_UnitDescription", "Unit")
"""Properties in which programs keep a channel's unit."""


def read(path: Path) -> Columns:
    """Read every channel of numbers, scaled as the file says.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        Where there is no such channel.
    """
    file = TdmsFile.read(path)
    if file.file_status.incomplete_final_segment:
        raise ValueError("its last segment is cut short; copy it again, or have its recorder repair it")
    channels = [channel for group in file.groups() for channel in group.channels()]
    often = Counter(channel.name for channel in channels)
    values: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    rates: dict[str, float] = {}
    short: dict[str, str] = {}
    for channel in channels:
        samples = np.asarray(channel[:])
        if samples.dtype.kind not in "biufc" or samples.size < 2:
            continue
        wanted = channel.name if often[channel.name] == 1 else f"{channel.group_name}/{channel.name}"
        name = unused_name(wanted, values)
        if often[channel.name] > 1:
            short[name] = channel.name
        values[name] = samples.astype(complex if samples.dtype.kind == "c" else float)
        given = [str(channel.properties[key]) for key in UNITS if channel.properties.get(key)]
        if given:
            units[name] = given[0]
        increment = channel.properties.get("wf_increment")
        if isinstance(increment, float) and increment > 0.0:
            rates[name] = 1.0 / increment
    return Columns(values, units, rates, channels=short)
