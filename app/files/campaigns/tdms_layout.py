"""Groups, channels, lengths and waveform properties that a sweep's TDMS file must have."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from nptdms import TdmsChannel, TdmsFile

from analysis.experiment import Experiment
from app.files.campaign_error import Problem
from app.files.campaigns.tdms_file import apart, start_of

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
