"""One TDMS file of a recorded campaign: read, and checked against what the experiment declares."""

import math
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from numpy.typing import NDArray

from analysis.experiment import Experiment
from analysis.recordings.campaign import Sweep
from app.files.campaign_error import Problem, SignalProblem
from app.files.campaigns.channels import RecordedChannel, RecorderLayout, source_of
from app.files.campaigns.tdms_file import (
    DRIVE,
    RATE_TOLERANCE,
    LostInTdmsError,
    TdmsLayout,
    counts_without_scale,
    is_cut_short,
    layout_problems,
    said_by_nptdms,
    start_of,
    start_problems,
    unit_of,
)
from drivers.ni.modules import InputModule, find_module

Samples = dict[str, NDArray[np.float32]]


def recorder_samples(
    name: str, tdms: TdmsFile, layout: TdmsLayout, recorder: RecorderLayout, experiment: Experiment, source: int
) -> tuple[Samples, list[Problem]]:
    """Read the declared channels in SI units.

    A group for each repeat, in the order of the file, or one group with all repeats one after the other.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    layout : TdmsLayout
        Repeats, samples and rate that the experiment declares.
    recorder : RecorderLayout
        Fits the experiment.
    source : int
        Which of its inputs drove.

    Returns
    -------
    samples : dict
        (repeats, samples) by the names of `layout`; empty where anything is wrong.
    problems : list of Problem
    """
    wired = recorder.wired(experiment, source)
    measured = [experiment.inputs[source], *experiment.outputs]
    there = {group.name: {channel.name: channel for channel in group.channels()} for group in tdms.groups()}
    groups = [group for group, held in there.items() if any(theirs in held for theirs, _ in wired.values())]
    if len(groups) not in (1, len(layout.groups)):
        seen = f"{len(groups)} with a declared channel"
        allowed = (
            f"{len(layout.groups)}, one for each of protocol.repeats, or one with all repeats one after the other"
        )
        return {}, [Problem(name, "groups", seen, allowed, f"the file holds {_listed(there)}")]
    length = layout.samples * len(layout.groups) // len(groups)
    problems: list[Problem] = []
    samples: Samples = {}
    begun: dict[str, dict[str, float | None]] = {}
    for ours, one in zip(layout.channels, measured, strict=True):
        theirs, declared = wired[one.id]
        parts = []
        for group in groups:
            if theirs not in there[group]:
                allowed = f"a channel {theirs!r}, {'drive' if ours == DRIVE else one.id} by [channels]"
                problems.append(
                    Problem(name, group, f"holds {_listed(there[group])}", allowed, "correct its name")
                )
                continue
            channel, place = there[group][theirs], f"{group}/{theirs}"
            problems += _channel_problems(name, place, channel, length, layout.rate)
            begun.setdefault(group, {})[place] = start_of(channel.properties)
            try:
                scale = declared.calibration(unit_of(channel.properties), one).scale
            except ValueError as error:
                problems.append(Problem(name, place, str(error), "", f'correct channels."{theirs}"'))
                continue
            if not problems:
                parts.append(np.asarray(channel[:], dtype=float).reshape(-1, layout.samples) * scale)
        if parts:
            with np.errstate(over="ignore"):  # infinite samples are refused with all that are not finite
                samples[ours] = np.concatenate(parts).astype(np.float32)
    problems += [problem for starts in begun.values() for problem in start_problems(name, starts, layout.rate)]
    return ({}, problems) if problems else (samples, [])


def _channel_problems(name: str, place: str, channel: TdmsChannel, length: int, rate: float) -> Iterator[Problem]:
    if channel.dtype.kind not in "iuf":
        yield Problem(name, f"{place} data type", str(channel.dtype), "numbers")
    if counts_without_scale(channel.properties, channel.dtype):
        yield Problem(name, f"{place} NI_Scaling_Status", "unscaled, and no scale", "values in engineering units")
    if len(channel) != length:
        allowed = (
            f"{length}, of (protocol.sweep_duration + protocol.tail) x acquisition.sample_rate and the repeats"
        )
        yield Problem(name, f"{place} samples", str(len(channel)), allowed)
    step = channel.properties.get("wf_increment", 1.0 / rate)
    if not isinstance(step, float) or not math.isclose(step * rate, 1.0, rel_tol=RATE_TOLERANCE):
        allowed = f"{1.0 / rate:.10g} s, one over acquisition.sample_rate"
        yield Problem(name, f"{place} wf_increment", repr(step), allowed)


def _listed(names: dict[str, TdmsChannel] | dict[str, dict[str, TdmsChannel]]) -> str:
    shown = ", ".join(names)
    return (shown if len(shown) <= 120 else shown[:117] + "...") or "nothing"


def at_the_card(channel: str, recorder: RecorderLayout, experiment: Experiment, source: int) -> bool:
    """Whether a channel's numbers are the volts that the input module converted, before any sensitivity.

    Parameters
    ----------
    channel : str
        The drive, or the identifier of a sensor.
    source : int
        Which of its inputs drove.
    """
    if not recorder.channels:
        return True
    measured = experiment.inputs[source].id if channel == DRIVE else channel
    declared: RecordedChannel = recorder.wired(experiment, source)[measured][1]
    return declared.sensitivity is None


DRIVE_TOLERANCE = 0.1
"""Largest difference between the peak of a drive in volts and the level the file states, relative."""
FORCE_FACTOR = 5.0
"""How far the peak of a force may be from the level: a hammer hits as it happens to, a wrong unit is far off."""
WHOLE = "a whole TDMS file"
COPY_AGAIN = "copy it again from the recorder"
UNUSED_CHANNELS_FACTOR = 64
"""Times as large a recorder's file may be, which may hold many channels besides those declared."""
LEAVE_OUT = "record it again, or flexura import with --allow-missing to leave the sweep out"


def read_sweep(
    path: Path, name: str, experiment: Experiment, recorder: RecorderLayout | None = None
) -> tuple[Sweep | None, list[Problem]]:
    """Read one file.

    Parameters
    ----------
    name : str
        What the problems call the file.
    recorder : RecorderLayout, optional
        What is declared of a file that has a layout of its own.

    Returns
    -------
    sweep : Sweep or None
        None where anything is wrong.
    problems : list of Problem
    """
    recorder = recorder or RecorderLayout(channels={}, sweeps={})
    largest = TdmsLayout.of(experiment).largest_file * (UNUSED_CHANNELS_FACTOR if recorder.channels else 1)
    try:
        size = path.stat().st_size
        if size > largest:
            return None, [Problem(name, "", f"{size} bytes", f"at most {largest} by the protocol")]
        with path.open("rb") as file:  # a handle: npTDMS would otherwise believe a .tdms_index beside it
            return _read(file, size, name, experiment, recorder)
    except OSError as error:
        return None, [Problem(name, "", f"cannot be read: {error.strerror}", "a readable file")]


def _read(
    file: BinaryIO, size: int, name: str, experiment: Experiment, recorder: RecorderLayout
) -> tuple[Sweep | None, list[Problem]]:
    if file.read(4) != b"TDSm":
        seen = "an empty file" if size == 0 else "not a TDMS file"
        return None, [Problem(name, "", seen, "NI TDMS, beginning with TDSm", COPY_AGAIN)]
    file.seek(0)
    try:
        with said_by_nptdms():
            tdms = TdmsFile.open(file)
            headless = not tdms.properties and not tdms.groups()  # npTDMS passes over a header cut short
            if headless or is_cut_short(tdms, file):
                return None, [_truncated(name, size)]
            properties = recorder.properties(Path(name).name, tdms.properties)
            source, problems = source_of(name, properties, experiment)
            if source is None:  # the unit of its drive and its channel hang on that
                return None, problems
            samples, problems = _samples(name, tdms, experiment, recorder, source)
        problems = [*_property_problems(name, properties, recorder), *problems]
        if problems:
            return None, problems
    except EOFError:
        return None, [_truncated(name, size)]
    except LostInTdmsError as error:
        return None, [Problem(name, "", str(error), "samples in engineering units, scaled by the recorder")]
    except Exception as error:  # noqa: BLE001 (on damaged bytes npTDMS raises what it runs into, bare Exception too)
        seen = f"damaged ({type(error).__name__}: {error})"
        return None, [Problem(name, "", seen, WHOLE, COPY_AGAIN)]
    problems = list(_sample_problems(name, samples, properties, experiment, recorder, source))
    return (None, problems) if problems else (_sweep(samples, properties, experiment, source), [])


def _samples(
    name: str, tdms: TdmsFile, experiment: Experiment, recorder: RecorderLayout, source: int
) -> tuple[dict[str, NDArray[Any]], list[Problem]]:
    """Read the samples in SI units; only where their number is known to be sane."""
    layout = TdmsLayout.of(experiment, source)
    if recorder.channels:
        return recorder_samples(name, tdms, layout, recorder, experiment, source)
    problems = list(layout_problems(name, tdms, layout))
    if problems:
        return {}, problems
    return {
        channel: np.stack([tdms[group][channel][:] for group in layout.groups]) for channel in layout.channels
    }, []


def _truncated(name: str, size: int) -> Problem:
    return Problem(name, "", f"truncated after {size} bytes", WHOLE, COPY_AGAIN)


def _property_problems(name: str, properties: dict[str, Any], recorder: RecorderLayout) -> Iterator[Problem]:
    file, remedy = Path(name).name, "the root property is missing"
    if file in recorder.sweeps:
        remedy = f'give start_time in sweeps."{file}"'  # everything else is declared there
    elif recorder.channels:
        remedy = f'name "{file}" in [sweeps] of campaign.toml, with its temperature, direction and level'
    for key, (allowed, good) in PROPERTIES.items():
        if key not in properties:
            yield Problem(name, key, "nothing", allowed, remedy)
        elif not good(properties[key]):
            yield Problem(name, key, repr(properties[key]), allowed)
    there = [key for key in PLATE if key in properties]
    allowed, good = PROPERTIES["oven_temperature_start"]
    for key in PLATE if there else ():
        if key not in properties:
            yield Problem(name, key, "nothing", f"{allowed}, as {there[0]} is there")
        elif not good(properties[key]):
            yield Problem(name, key, repr(properties[key]), allowed)


def _is_integer(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and 0 <= int(value) < 10_000


def _is_between(low: float, high: float) -> Callable[[object], bool]:
    def within(value: Any) -> bool:
        number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
        return number and low <= float(value) <= high

    return within


def _is_time(value: object) -> bool:
    if isinstance(value, np.datetime64):
        return not np.isnat(value)
    try:
        datetime.fromisoformat(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return False
    return True


PLATE = ("plate_temperature_start", "plate_temperature_end")
"""Properties of the root, both or none: where a sensor was on the plate, its temperature counts."""
PROPERTIES: dict[str, tuple[str, Callable[[object], bool]]] = {
    "oven_temperature_start": ("-80 to 200 (degrees Celsius)", _is_between(-80.0, 200.0)),
    "oven_temperature_end": ("-80 to 200 (degrees Celsius)", _is_between(-80.0, 200.0)),
    "direction": ("'up' or 'down'", lambda value: value in ("up", "down")),
    "level": ("a number above 0 to 1000 (V or N)", _is_between(1e-9, 1e3)),
    "step": ("an integer from 0 to 9999", _is_integer),
    "start_time": ("an ISO 8601 time", _is_time),
}


NEAR_FULL_SCALE = 1.0 - 1e-4
LEAST_CODES = 16.0
"""Codes, peak to peak: an open input shows its own noise, which is above this."""
SMOOTH_TOP = 9.0
"""Quanta: how far a smooth peak that rounds to one code for two samples can fall at the next one."""


def faults(
    samples: NDArray[np.floating], module: InputModule | None, unit: str = "V"
) -> Iterator[tuple[str, str]]:
    """Yield what is wrong with a channel, as (seen, allowed).

    Parameters
    ----------
    samples : (M,) ndarray
    module : InputModule or None
        Gives range and resolution; None where the module is unknown, or the samples are no volts.
    unit : str
        Of the samples.

    Yields
    ------
    seen, allowed : str
        One pair at most: further checks mean nothing after a fault.
    """
    finite = np.isfinite(samples)
    if not finite.all():
        where = int(np.argmin(finite))
        yield (
            f"{samples[where]} at sample {where} ({np.count_nonzero(~finite)} of {samples.size})",
            "finite volts" if unit == "V" else "finite numbers",
        )
        return
    low, high = float(samples.min()) + 0.0, float(samples.max()) + 0.0  # no "-0 V"
    alive = LEAST_CODES * module.quantum if module else 0.0
    if high - low <= alive:
        yield f"{low:g} to {high:g} {unit} throughout", "a signal (is the channel connected and switched on?)"
        return
    if module and max(-low, high) >= NEAR_FULL_SCALE * module.full_scale:
        count = int(np.count_nonzero(np.abs(samples) >= NEAR_FULL_SCALE * module.full_scale))
        yield (
            f"{count} clipped samples, up to {max(-low, high):g} V",
            f"below the {module.full_scale:g} V that the {module.name} converts (lower the drive or the gain)",
        )
        return
    held = flat_topped(samples)
    if held:
        yield (
            f"{held} clipped samples, flat at {low:g} or {high:g} {unit}",
            "peaks that are not cut off (lower the drive or the gain, or widen the range)",
        )


def flat_topped(samples: NDArray[np.floating]) -> int:
    """Count the samples of cut-off peaks: held at the channel's extreme, with steps into and out of it.

    A smooth peak that a converter of step q rounds to one code for r samples falls by less than
    q (r+1)^2/(r-1)^2, so at most 9 q, at the sample after: a longer step out of a flat top means that
    something cut it. One flat top of two samples may be chance, and is let through.

    Parameters
    ----------
    samples : (M,) ndarray

    Returns
    -------
    int
        Samples on cut-off peaks; 0 if there is none.
    """
    total = 0
    for upright in (samples, -samples):
        top = upright == upright.max()
        edges = np.flatnonzero(np.diff(top.astype(np.int8), prepend=0, append=0))
        starts, ends = edges[::2], edges[1::2]  # samples starts[i] .. ends[i]-1 are held at the top
        inner = (starts > 0) & (ends < samples.size) & (ends - starts >= 2)
        starts, ends = starts[inner], ends[inner]
        if not starts.size:
            continue
        steps = np.abs(np.diff(upright))
        quantum = steps[steps > 0.0].min()
        drop = np.minimum(upright[starts] - upright[starts - 1], upright[starts] - upright[ends])
        cut = drop > SMOOTH_TOP * quantum
        held = int(np.sum((ends - starts)[cut]))
        if held > 2:
            total += held
    return total


def _sample_problems(
    name: str,
    volts: dict[str, NDArray[Any]],
    properties: dict[str, Any],
    experiment: Experiment,
    recorder: RecorderLayout,
    source: int,
) -> Iterator[Problem]:
    module, layout = find_module(experiment.acquisition.module), TdmsLayout.of(experiment, source)
    for (channel, repeats), unit in zip(volts.items(), layout.units, strict=True):
        # only volts can be held against the converter's range: what a unit is in volts is not declared
        converted = unit == "V" and at_the_card(channel, recorder, experiment, source)
        for group, samples in zip(layout.groups, repeats, strict=True):
            for seen, allowed in faults(samples, module if converted else None, unit):
                yield SignalProblem(name, f"{group}/{channel}", seen, allowed, LEAVE_OUT)
    unit = layout.units[0]
    level, peak = float(properties["level"]), float(np.abs(volts[DRIVE]).max())
    if not math.isfinite(peak) or peak <= 0.0:
        return
    if unit == "V" and abs(peak - level) > DRIVE_TOLERANCE * level:
        allowed = f"{level:g} V within {DRIVE_TOLERANCE:.0%}, the file's level"
        yield Problem(name, "peak of drive", f"{peak:.4g} V", allowed, "are samples and level in V?")
    elif unit != "V" and not 1.0 / FORCE_FACTOR <= peak / level <= FORCE_FACTOR:
        allowed = f"{level:g} {unit}, the file's level, within a factor of {FORCE_FACTOR:g}"
        yield Problem(name, "peak of drive", f"{peak:.4g} {unit}", allowed, f"are samples and level in {unit}?")


def _sweep(
    volts: dict[str, NDArray[Any]], properties: dict[str, Any], experiment: Experiment, source: int
) -> Sweep:
    return Sweep(
        step=int(properties["step"]),
        direction=properties["direction"],
        level=float(properties["level"]),
        oven_temperature_start=float(properties["oven_temperature_start"]),
        oven_temperature_end=float(properties["oven_temperature_end"]),
        start_time=str(properties["start_time"]),
        drive=volts[DRIVE].astype(np.float32),
        responses=np.stack([volts[output.id].astype(np.float32) for output in experiment.outputs]),
        source=source,
        plate_temperature_start=_of_plate(properties, PLATE[0]),
        plate_temperature_end=_of_plate(properties, PLATE[1]),
    )


def _of_plate(properties: dict[str, Any], key: str) -> float | None:
    return float(properties[key]) if key in properties else None
