"""What npTDMS only logs, or takes from a file beside the one it reads, made errors; and what its properties mean.

npTDMS believes a ``.tdms_index`` beside a file that it opens by name, even that of an earlier recording. It logs
which scales it cannot apply and then returns the counts of the converter. Both give numbers that look like a
measurement.
"""

import logging
import struct
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, BinaryIO

import numpy as np
from nptdms import TdmsFile
from nptdms.log import log_manager

UNITS = ("unit_string", "NI_UnitDescription", "Unit")
"""Properties in which programs keep a channel's unit."""
LOST = ("scale", "Cropping", "not a multiple")
"""Words of what npTDMS logs if its numbers are not those that were recorded, or not all of them."""
LEAD_IN = struct.Struct("<4sIIQQ")
"""Of a segment: tag, contents, version, bytes to the next segment, bytes to its samples."""
UNKNOWN_LENGTH = 2**64 - 1
"""Bytes to the next segment where the recorder did not know them yet."""


class LostInTdmsError(ValueError):
    """npTDMS could not give the samples as they were recorded; the message says what it logged."""


class _Said(logging.Handler):
    """Keeps what a library logs."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.messages: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message."""
        self.messages.append(record.getMessage())


@contextmanager
def said_by_nptdms() -> Iterator[list[str]]:
    """Yield what npTDMS logs meanwhile, which is not printed.

    Raises
    ------
    LostInTdmsError
        At the end, where it could not apply a scale, or left samples out.
    """
    said, loggers = _Said(), list(log_manager.loggers.values())
    levels = [one.level for one in loggers]
    printed = log_manager.console_handler.level
    log_manager.console_handler.setLevel(logging.CRITICAL)
    for one in loggers:
        one.setLevel(logging.WARNING)
        one.addHandler(said)
    try:
        yield said.messages
    finally:
        log_manager.console_handler.setLevel(printed)
        for one, level in zip(loggers, levels, strict=True):
            one.removeHandler(said)
            one.setLevel(level)
    for message in said.messages:
        ends_early = "not a multiple" in message and any("less data" in one for one in said.messages)
        if any(word in message for word in LOST) and not ends_early:  # that is told by `is_cut_short`
            raise LostInTdmsError(
                f"npTDMS says: {message}. Its numbers would be counts of the converter, or not all samples; "
                f"have the "
                "recorder write scaled values in engineering units, or export the file as LVM, CSV or MAT"
            )


def is_cut_short(tdms: TdmsFile, file: BinaryIO) -> bool:
    """Whether samples of the last segment are missing; whole chunks up to the end may have an unknown length.

    Parameters
    ----------
    file : binary file
        That it was opened from.
    """
    status = tdms.file_status
    if not status.incomplete_final_segment:
        return False
    whole = all(one.read_length == one.expected_length for one in (status.channel_statuses or {}).values())
    return not (whole and status.channel_statuses and _length_unknown(file))


def _length_unknown(file: BinaryIO) -> bool:
    """Whether the last segment says that its length is not known, as recorders write before they end."""
    place = 0
    while True:
        file.seek(place)
        head = file.read(LEAD_IN.size)
        if len(head) < LEAD_IN.size or head[:4] != b"TDSm":
            return False
        length = LEAD_IN.unpack(head)[3]
        if length == UNKNOWN_LENGTH:
            return True
        place += LEAD_IN.size + length


def unit_of(properties: Mapping[str, Any]) -> str | None:
    """Return a channel's unit as the file writes it."""
    return next((str(properties[key]) for key in UNITS if properties.get(key)), None)


def counts_without_scale(properties: Mapping[str, Any], dtype: np.dtype[Any]) -> bool:
    """Whether whole numbers are said to be not scaled yet, and no scale is given."""
    said = str(properties.get("NI_Scaling_Status", "")) == "unscaled"
    scales = any(key.startswith("NI_Scale[") for key in properties) or properties.get("NI_Number_Of_Scales")
    return said and not scales and dtype.kind in "iu"


def start_of(properties: Mapping[str, Any], scale: float = 1.0) -> float | None:
    """Return the time of a channel's first sample, s, of which only differences count; None where it is not given.

    Parameters
    ----------
    properties : mapping
        ``wf_start_time`` (of day) plus ``wf_start_offset``.
    scale : float
        Seconds of the offset's unit.
    """
    begun, offset = properties.get("wf_start_time"), properties.get("wf_start_offset")
    known = isinstance(offset, int | float | np.number) and np.isfinite(offset)
    start = float(offset) * scale if known else 0.0  # type: ignore[arg-type]
    if isinstance(begun, np.datetime64) and not np.isnat(begun):
        day = begun.astype("datetime64[D]")  # of the day, so that microseconds are not lost in a double
        return start + float((begun - day) / np.timedelta64(1, "us")) * 1e-6 + 86400.0 * float(day.astype(int))
    return start if known else None


def apart(start: float, other: float, rate: float) -> bool:
    """Whether two channels did not begin together: by more than a fiftieth of a sample, and a microsecond.

    Parameters
    ----------
    start, other : float
        s; npTDMS keeps microseconds of times of day.
    rate : float
        Hz.
    """
    return abs(start - other) > max(0.02 / rate, 1.5e-6)
