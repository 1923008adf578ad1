"""LabVIEW measurement files (LVM, versions 1 and 2): a head of the file, one of the segment, a table."""

from pathlib import Path

import numpy as np

from app.files.measurements.columns import Columns, unused_name
from app.files.parsed_text import read_bytes

LARGEST = 500_000_000
END = "***End_of_Header***"
DELIMITERS = {"Tab": "\t", "Comma": ","}


def read(path: Path) -> Columns:
    """Read the file's one segment.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        Where it has several segments, is damaged, or is none of LabVIEW's.
    """
    lines = read_bytes(path, LARGEST).decode("utf-8", errors="replace").splitlines()
    if not lines or not lines[0].startswith("LabVIEW Measurement"):
        raise ValueError('does not begin with "LabVIEW Measurement"; give the file the ending of its format')
    ends = [number for number, line in enumerate(lines) if line.startswith(END)]
    if len(ends) != 2:
        raise ValueError(
            f"{max(len(ends) - 1, 0)} segments; one is read. In Write To Measurement File choose one header only, "
            "or a file for each"
        )
    delimiter = _delimiter(lines[: ends[0]])
    head = {parts[0]: parts[1:] for parts in (line.split(delimiter) for line in lines[: ends[1]])}
    names = [part.strip() for part in lines[ends[1] + 1].split(delimiter)]
    if "".join(head.get("X_Columns", ["One"])).strip() == "Multi":
        raise ValueError("a column of times for each channel (X_Columns Multi); write one, or none")
    channels = int(float(head["Channels"][0]))
    comma = "".join(head.get("Decimal_Separator", ["."])).strip() == ","
    values = _samples(lines, ends[1] + 2, delimiter, channels, comma)
    columns: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    rates: dict[str, float] = {}
    unit_row, steps = head.get("Y_Unit_Label", []), head.get("Delta_X", [])
    for channel in range(channels):
        name = unused_name(names[channel + 1] if channel + 1 < len(names) else str(channel + 1), columns)
        columns[name] = values[:, channel].copy()
        if channel < len(unit_row) and unit_row[channel].strip():
            units[name] = {"Volts": "V"}.get(unit_row[channel].strip(), unit_row[channel].strip())
        if channel < len(steps) and steps[channel].strip():
            rates[name] = 1.0 / float(steps[channel].replace(",", "."))
    return Columns(columns, units, rates)


def _delimiter(head: list[str]) -> str:
    separator = next((line[len("Separator") :].strip() for line in head if line.startswith("Separator")), "")
    return DELIMITERS.get(separator, "\t")


def _samples(lines: list[str], first: int, delimiter: str, channels: int, comma: bool) -> np.ndarray:
    """Return the samples (M, channels) in the lines from `first` on; the column of times is left out."""
    rows = []
    for number, line in enumerate(lines[first:], start=first + 1):
        if not line.strip():
            continue
        parts = line.split(delimiter)[1 : channels + 1]
        try:
            rows.append([float(part.replace(",", ".") if comma else part) for part in parts])
        except ValueError as error:
            raise ValueError(f"line {number}: {line[:60]!r}; {channels} numbers wanted") from error
        if len(rows[-1]) != channels:
            raise ValueError(f"line {number}: {len(rows[-1])} numbers; {channels} wanted: cut short?")
    values = np.array(rows)
    if values.ndim != 2:
        raise ValueError("no sample follows its head; cut short?")
    return values
