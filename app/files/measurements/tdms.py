"""TDMS of any layout, through npTDMS: every channel of numbers, its group before its name where names repeat."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from nptdms import TdmsChannel, TdmsFile

from analysis.estimation.quantities import FREQUENCIES, TIMES, plain_unit
from analysis.estimation.sampling import is_default, of_step
from app.files.campaigns.tdms_file import counts_without_scale, is_cut_short, said_by_nptdms, start_of, unit_of
from app.files.measurements.columns import Columns, add_rate, unused_name


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
        Where there is no such channel, the file is cut short, or the library cannot apply a scale.
    """
    with path.open("rb") as handle, said_by_nptdms() as said:  # a handle: see `app.files.campaigns.tdms_file`
        file = TdmsFile.read(handle)
        if is_cut_short(file, handle):
            raise ValueError("its last segment is cut short; copy it again, or have its recorder repair it")
        channels = [channel for group in file.groups() for channel in group.channels()]
        often = Counter(channel.name for channel in channels)
        values: dict[str, np.ndarray] = {}
        kept: dict[str, TdmsChannel] = {}
        for channel in channels:
            samples = np.asarray(channel[:])
            if samples.dtype.kind not in "biufc" or samples.size < 2:
                continue
            wanted = channel.name if often[channel.name] == 1 else f"{channel.group_name}/{channel.name}"
            name = unused_name(wanted, values)
            values[name] = samples.astype(complex if samples.dtype.kind == "c" else float)
            kept[name] = channel
            if counts_without_scale(channel.properties, samples.dtype):
                raise ValueError(
                    f"channel {name!r} is not scaled yet (NI_Scaling_Status), and the file gives no scale: "
                    f"have the "
                    "recorder write values in engineering units"
                )
    notes = tuple(f"npTDMS says: {one}" for one in said if "less data than expected" not in one)
    columns = Columns(values, notes=notes)
    for name, channel in kept.items():
        if often[channel.name] > 1:
            columns.channels[name] = channel.name
        if unit := unit_of(channel.properties):
            columns.units[name] = unit
        _add_times(columns, name, channel.properties)
    return _with_lines(columns, kept)


def _with_lines(columns: Columns, kept: dict[str, TdmsChannel]) -> Columns:
    """Return the columns with the frequency lines before them that all channels have as waveform properties."""
    if not kept or len(columns.doubts) != len(kept):
        return columns
    lines = {_lines(channel.properties, len(columns.values[name])) for name, channel in kept.items()}
    if len(lines) != 1 or (found := lines.pop()) is None:
        return columns
    first, step, count = found
    name = unused_name("Frequency", columns.values)
    values = {name: first + step * np.arange(count), **columns.values}
    return replace(columns, values=values, units={name: "Hz", **columns.units}, doubts={})


def _lines(properties: dict[str, Any], count: int) -> tuple[float, float, int] | None:
    """First frequency and step, Hz, of a spectrum's waveform properties, and its number of lines."""
    hertz = FREQUENCIES.get(plain_unit(str(properties.get("wf_xunit_string") or "")))
    try:
        step, first = float(properties["wf_increment"]), float(properties.get("wf_start_offset", 0.0))
    except (KeyError, TypeError, ValueError):
        return None
    if hertz is None or not (0.0 < step < np.inf and 0.0 <= first < np.inf):
        return None
    return first * hertz, step * hertz, count


def _add_times(columns: Columns, name: str, properties: dict[str, Any]) -> None:
    """Add the rate and the start of a channel by its waveform properties."""
    along = plain_unit(str(properties.get("wf_xunit_string") or "s"))
    if along in FREQUENCIES:
        columns.doubts[name] = f"its wf_xunit_string is {along}: it holds spectra, no signals; export the signals"
        return
    if along not in TIMES:
        columns.doubts[name] = f"wf_xunit_string {along!r} is no unit of time; declare sample_rate = ... in Hz"
        return
    increment = properties.get("wf_increment")
    if isinstance(increment, int | float | np.number) and np.isfinite(increment) and increment > 0.0:
        step = float(increment) * TIMES[along]
        add_rate(
            columns,
            name,
            [] if is_default(step) else [of_step(step, "wf_increment")],
            "wf_increment" if is_default(step) else "",
        )
    start = start_of(properties, TIMES[along])
    if start is not None:
        columns.starts[name] = start
