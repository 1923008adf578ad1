"""TDMS files: what npTDMS only logs or takes from a file beside; groups, channels and lengths they must have.

npTDMS believes a ``.tdms_index`` beside a file that it opens by name, even that of an earlier recording. It logs
which scales it cannot apply and then returns the counts of the converter. Both give numbers that look like a
measurement.
"""

import logging
import math
import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, BinaryIO, Self

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from nptdms.log import log_manager

from analysis.experiment import Experiment
from app.files.campaign_error import Problem

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


DRIVE = "drive"
RATE_TOLERANCE = 1e-6
"""Largest relative difference of ``wf_increment`` from the declared rate: 1 ppm shifts no pole visibly."""


@dataclass(frozen=True)
class TdmsLayout:
    """What a file of the campaign holds.

    Attributes
    ----------
    groups : tuple of str
        One for each repeat.
    channels : tuple of str
        The drive first, then the sensors in the order declared.
    units : tuple of str
        Of each channel.
    samples : int
        In every channel.
    rate : float
        Hz.
    """

    groups: tuple[str, ...]
    channels: tuple[str, ...]
    units: tuple[str, ...]
    samples: int
    rate: float

    @classmethod
    def of(cls, experiment: Experiment, source: int = 0) -> Self:
        """Work out the layout that an experiment declares for sweeps that one of its inputs drives."""
        protocol, rate = experiment.protocol, experiment.acquisition.sample_rate
        return cls(
            groups=tuple(f"repeat {n + 1}" for n in range(protocol.repeats)),
            channels=(DRIVE, *(output.id for output in experiment.outputs)),
            units=(experiment.inputs[source].unit, *(output.unit for output in experiment.outputs)),
            samples=round(protocol.record * rate),
            rate=rate,
        )

    @property
    def largest_file(self) -> int:
        """Bytes: twice the samples as float64, and room for properties."""
        return 1_000_000 + 16 * len(self.groups) * len(self.channels) * self.samples


def layout_problems(name: str, tdms: TdmsFile, layout: TdmsLayout) -> Iterator[Problem]:
    """Yield everything in which a file differs from the layout.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    tdms : TdmsFile
        Its samples unread.
    """
    there = [group.name for group in tdms.groups()]
    yield from _names(name, "groups", there, layout.groups, "their number is protocol.repeats")
    lengths: dict[str, int] = {}
    offsets: dict[str, object] = {}
    for group in (group for group in tdms.groups() if group.name in layout.groups):
        channels = [channel.name for channel in group.channels()]
        yield from _names(name, f"channels of {group.name}", channels, layout.channels, "named by id")
        for channel in group.channels():
            if channel.name in layout.channels:
                lengths[f"{group.name}/{channel.name}"] = len(channel)
                offsets[f"{group.name}/{channel.name}"] = channel.properties.get("wf_start_offset")
                yield from _waveform(name, f"{group.name}/{channel.name}", channel, layout)
    first = next(iter(offsets.values()), None)
    for place, offset in offsets.items():
        if not isinstance(offset, float) or not math.isfinite(offset):
            yield Problem(name, f"{place} wf_start_offset", repr(offset), "a time (s)")
        elif offset != first:
            allowed = f"{first!r} s, as in the first channel: all are sampled together"
            yield Problem(name, f"{place} wf_start_offset", repr(offset), allowed)
    for group in (group for group in tdms.groups() if group.name in layout.groups):
        starts = {
            f"{group.name}/{channel.name}": start_of({**channel.properties, "wf_start_offset": 0.0})
            for channel in group.channels()
            if channel.name in layout.channels and "wf_start_time" in channel.properties
        }
        yield from start_problems(name, starts, layout.rate)
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{place} {length}" for place, length in lengths.items())
        yield Problem(name, "samples", f"unequal: {_short(listed)}", f"{layout.samples} in every channel")
    elif lengths and set(lengths.values()) != {layout.samples}:
        length = next(iter(lengths.values()))
        seen = "0: zero-length sweeps" if length == 0 else f"{length} in every channel"
        allowed = f"{layout.samples}, which is (protocol.sweep_duration + protocol.tail) x acquisition.sample_rate"
        yield Problem(name, "samples", seen, allowed)


def start_problems(name: str, starts: Mapping[str, float | None], rate: float) -> Iterator[Problem]:
    """Yield the channels of a group that did not begin with its first one: that would turn phases.

    Parameters
    ----------
    name : str
        Of the file.
    starts : mapping of str to float or None
        s, by the place of a channel; None where the file does not say.
    rate : float
        Hz.
    """
    known = {place: start for place, start in starts.items() if start is not None}
    first = next(iter(known.values()), 0.0)
    for place, start in known.items():
        if apart(start, first, rate):
            allowed = "the start of the group's first channel: all are sampled together"
            seen = f"{(start - first) * rate:.4g} samples ({start - first:.6g} s) later"
            yield Problem(
                name, f"{place} wf_start_time + wf_start_offset", seen, allowed, "align them, export again"
            )


def _names(name: str, what: str, there: Sequence[str], wanted: Sequence[str], remedy: str) -> Iterator[Problem]:
    if sorted(there) != sorted(wanted):
        listed = _short(", ".join(there)) or "none"
        lacking = [one for one in wanted if one not in there]
        extra = [one for one in there if one not in wanted]
        odd = f"missing: {_short(', '.join(lacking))}" if lacking else f"not expected: {_short(', '.join(extra))}"
        yield Problem(name, what, listed, _short(", ".join(wanted)), f"{odd}; {remedy}")


def _waveform(name: str, place: str, channel: TdmsChannel, layout: TdmsLayout) -> Iterator[Problem]:
    if channel.dtype not in (np.float32, np.float64):
        yield Problem(name, f"{place} data type", str(channel.dtype), "float32")
    properties = channel.properties
    unit = layout.units[layout.channels.index(channel.name)]
    wanted: dict[str, tuple[str, object]] = {
        "wf_increment": (f"{1.0 / layout.rate:.10g} s, one over acquisition.sample_rate", 1.0 / layout.rate),
        "wf_samples": (f"{len(channel)}, the samples in the channel", len(channel)),
        "unit_string": (repr(unit), unit),
    }
    for key, (allowed, right) in wanted.items():
        if key not in properties:
            yield Problem(name, f"{place} {key}", "nothing", allowed, "the property is missing")
        elif not _agrees(_plain(properties[key]), right):
            yield Problem(name, f"{place} {key}", repr(properties[key]), allowed)


def _plain(seen: object) -> object:
    """Return a unit as it is declared here, of the ways it is written: m/s^2 and m/s² are m/s2."""
    return seen.replace("^", "").replace("²", "2") if isinstance(seen, str) else seen


def _agrees(seen: object, right: object) -> bool:
    if isinstance(right, str):
        return seen == right
    if not isinstance(seen, int | float | np.integer | np.floating) or isinstance(seen, bool):
        return False
    return math.isclose(float(seen), float(right), rel_tol=RATE_TOLERANCE, abs_tol=0.0)  # type: ignore[arg-type]


def _short(text: str) -> str:
    return text if len(text) <= 120 else text[:117] + "..."
