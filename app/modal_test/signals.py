"""Columns of a file, by its declaration, to signals in SI units that can be a measurement."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.channel import Quantity
from analysis.estimation.quantities import TIMES, axis_scale
from analysis.estimation.recording import SampledSignals, signal_faults
from app.files.campaign_error import Problem
from app.files.measurements.columns import Columns
from app.files.modal_test_toml import MEASURED, ModalTest

JITTER = 1e-3
"""Spread of the times' spacing, relative to it, that rounding in a file may cause."""


@dataclass(frozen=True)
class SignalsOfFile:
    """SignalsOfFile of one file.

    Attributes
    ----------
    recording : SampledSignals
    drives, responses : tuple of str
        Names of the channels.
    quantities : dict of str to str
    full_scales : tuple
        Of the drives and responses, SI; None where not declared.
    """

    recording: SampledSignals
    drives: tuple[str, ...]
    responses: tuple[str, ...]
    quantities: Mapping[str, Quantity]
    full_scales: tuple[float | None, ...]


def signals(file: str, columns: Columns, test: ModalTest) -> SignalsOfFile:
    """Turn the columns of a file into signals.

    Parameters
    ----------
    file : str
        Its name, for messages.
    columns : Columns
    test : ModalTest
        Says what each column is.

    Returns
    -------
    SignalsOfFile
        In SI units.

    Raises
    ------
    ValueError
        Whose message names all that is wrong, a line each.
    """
    names = {role: [n for n, c in test.channels.items() if c.role == role] for role in MEASURED}
    used = [*names["drive"], *names["response"]]
    problems = missing_columns(file, columns, [n for n, c in test.channels.items() if c.role != "unused"])
    scaled: dict[str, NDArray[np.float64]] = {}
    quantities: dict[str, Quantity] = {}
    scales: list[float | None] = []
    for name in used if not problems else []:
        channel = test.channels[name]
        try:
            read = channel.calibration(columns.units.get(name))
        except ValueError as error:
            problems.append(str(Problem(file, f"channels.{_quoted(name)}", str(error), "")))
            continue
        scaled[name] = np.asarray(columns.values[name].real, dtype=float) * read.scale
        quantities[name] = read.quantity
        scales.append(None if channel.full_scale is None else abs(channel.full_scale * read.scale))
    problems += [f"{file}: {fault}" for fault in signal_faults(list(scaled), list(scaled.values()))]
    lengths = {len(signal) for signal in scaled.values()}
    if len(lengths) > 1:
        problems.append(
            f"{file}: channels of {sorted(lengths)} samples; all have to be as long: export them together"
        )
    if not problems:
        try:
            rate = sample_rate(file, columns, test)
            recording = SampledSignals(rate, *(np.array([scaled[n] for n in names[role]]) for role in MEASURED))
            return SignalsOfFile(recording, (*names["drive"],), (*names["response"],), quantities, tuple(scales))
        except ValueError as error:
            problems.append(f"{file}: {error}")
    raise ValueError("\n".join(problems))


def missing_columns(file: str, columns: Columns, wanted: list[str]) -> list[str]:
    """Say which declared channels a file lacks, with those it holds.

    Parameters
    ----------
    file : str
        Its name, for messages.
    columns : Columns
    wanted : list of str
        Names of channels.

    Returns
    -------
    list of str
        A message each; empty where none is missing.
    """
    there = ", ".join(list(columns.values)[:12]) + (", ..." if len(columns.values) > 12 else "")
    return [
        f"{file}: no channel {name!r}; it holds: {there}. Correct its name in [channels]"
        for name in wanted
        if name not in columns.values
    ]


def sample_rate(file: str, columns: Columns, test: ModalTest) -> float:
    """Sample rate of signals: as declared, from their times, or from the file.

    Parameters
    ----------
    file : str
        Its name.
    columns : Columns
    test : ModalTest

    Returns
    -------
    float
        Hz.

    Raises
    ------
    ValueError
        Where none of these gives it, times are not evenly spaced, or channels have different rates.
    """
    if isinstance(test.sample_rate, float):
        return test.sample_rate
    if isinstance(test.sample_rate, str):
        if test.sample_rate not in columns.scalars:
            held = ", ".join(columns.scalars) or "none"
            raise ValueError(f"sample_rate: no single number {test.sample_rate!r} in the file; it holds: {held}")
        return columns.scalars[test.sample_rate]
    times = [name for name, channel in test.channels.items() if channel.role == "time"]
    if times:
        written = test.channels[times[0]].unit or columns.units.get(times[0], "s")
        return _rate_of(columns.values[times[0]].real * axis_scale(written, TIMES, "times"))
    rates = {columns.rates[name] for name in columns.rates if name in test.channels}
    if not rates:
        raise ValueError(
            "the files give no sample rate; give sample_rate in Hz, its name in a file, or the role time"
        )
    if max(rates) - min(rates) > 1e-6 * max(rates):
        raise ValueError(f"channels of {sorted(rates)} Hz; all of a run need one rate: resample them")
    return max(rates)


def _rate_of(time: NDArray[np.float64]) -> float:
    step = np.diff(time)
    if len(step) < 2 or not (step > 0.0).all():
        raise ValueError("times do not rise; export them with more digits, or give sample_rate in Hz")
    mean = float((time[-1] - time[0]) / (len(time) - 1))
    if np.abs(time - time[0] - mean * np.arange(len(time))).max() > max(JITTER * len(time), 1.0) * mean:
        raise ValueError(
            "times are not evenly spaced: samples are missing, or it was resampled; record without gaps"
        )
    return 1.0 / mean


def _quoted(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() else f'"{name}"'
