"""Samples of one sweep from a TDMS file of the recorder's own layout, by the campaign's ``[channels]``."""

import math
from collections.abc import Iterator

import numpy as np
from nptdms import TdmsChannel, TdmsFile
from numpy.typing import NDArray

from analysis.experiment import Experiment
from app.files.campaign_channels import RecordedChannel, RecorderLayout
from app.files.campaign_error import Problem
from app.files.tdms_file import counts_without_scale, start_of, unit_of
from app.files.tdms_layout import DRIVE, RATE_TOLERANCE, TdmsLayout, start_problems

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
    tdms : TdmsFile
    layout : TdmsLayout
        Repeats, samples and rate that the experiment declares.
    recorder : RecorderLayout
        Fits the experiment.
    experiment : Experiment
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
    recorder : RecorderLayout
    experiment : Experiment
    source : int
        Which of its inputs drove.

    Returns
    -------
    bool
    """
    if not recorder.channels:
        return True
    measured = experiment.inputs[source].id if channel == DRIVE else channel
    declared: RecordedChannel = recorder.wired(experiment, source)[measured][1]
    return declared.sensitivity is None
