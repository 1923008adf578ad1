"""Columns of a file, by its declaration, to signals in SI units that can be a measurement."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.channel import Quantity
from analysis.estimation.recording import SampledSignals, signal_faults
from app.files.campaign_error import Problem
from app.files.measurements.columns import Columns
from app.files.modal_test_toml import MEASURED, ModalTest
from app.modal_test.sample_rates import sample_rate

SHARE_OF_SAMPLE = 0.02
"""By which starts of channels may differ: it turns the phase by 4 degrees at half the sample rate."""
CLOCK_STEP = 1.5e-6
"""s; programs keep times of day to a microsecond."""


@dataclass(frozen=True)
class SignalsOfFile:
    """Signals of one file.

    Attributes
    ----------
    recording : SampledSignals
    drives, responses : tuple of str
        Names of the channels.
    quantities : dict of str to str
    full_scales : tuple
        Of the drives and responses, SI; None where not declared.
    notes : tuple of str
        What the user should know of them.
    """

    recording: SampledSignals
    drives: tuple[str, ...]
    responses: tuple[str, ...]
    quantities: Mapping[str, Quantity]
    full_scales: tuple[float | None, ...]
    notes: tuple[str, ...] = ()


def signals(file: str, columns: Columns, test: ModalTest) -> SignalsOfFile:
    """Turn the columns of a file into signals.

    Parameters
    ----------
    file : str
        Its name, for messages.
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
    notes: list[str] = []
    if not problems:
        try:
            rate, said = sample_rate(file, columns, test)
            notes += said
            scaled, said = _begun_together(scaled, columns, test, rate)
            notes += said
            _require_one_length(scaled)
            recording = SampledSignals(rate, *(np.array([scaled[n] for n in names[role]]) for role in MEASURED))
            return SignalsOfFile(
                recording, (*names["drive"],), (*names["response"],), quantities, tuple(scales), tuple(notes)
            )
        except ValueError as error:
            problems.append(f"{file}: {error}")
    raise ValueError("\n".join(problems))


def _require_one_length(signals_of: Mapping[str, NDArray[np.float64]]) -> None:
    lengths = {len(signal) for signal in signals_of.values()}
    if len(lengths) > 1:
        raise ValueError(f"channels of {sorted(lengths)} samples; all have to be as long: export them together")


def _begun_together(
    scaled: dict[str, NDArray[np.float64]], columns: Columns, test: ModalTest, rate: float
) -> tuple[dict[str, NDArray[np.float64]], list[str]]:
    """Cut signals to the time in which all were recorded, by whole samples; ValueError for parts of samples."""
    declared = {name: test.channels[name].start for name in scaled}
    starts = {name: columns.starts.get(name) if one is None else one for name, one in declared.items()}
    known = {name: start for name, start in starts.items() if start is not None}
    last = max(known.values(), default=0.0)
    late = {name: (last - start) * rate for name, start in known.items()}
    if max(late.values(), default=0.0) <= max(SHARE_OF_SAMPLE, CLOCK_STEP * rate):
        return scaled, []
    told = ", ".join(f"{name} {start - min(known.values()):.6g} s" for name, start in known.items())
    remedy = (
        "export channels that were sampled together, or declare start = 0 of each channel if these times are wrong"
    )
    if len(known) < len(scaled):
        raise ValueError(f"channels begin at different times ({told}), others at unknown ones; {remedy}")
    shifts = {name: round(samples) for name, samples in late.items()}
    uneven = [name for name, n in shifts.items() if abs(late[name] - n) > max(SHARE_OF_SAMPLE, CLOCK_STEP * rate)]
    if uneven:
        raise ValueError(
            f"channels begin at different times ({told}), and {uneven[0]!r} by a part of a sample of "
            f"{1.0 / rate:.6g} s; {remedy}"
        )
    shortest = min(len(scaled[name]) - n for name, n in shifts.items())
    if shortest < 1:
        raise ValueError(f"channels begin at different times ({told}) and have no time in common; {remedy}")
    return (
        {name: scaled[name][n : n + shortest] for name, n in shifts.items()},
        [f"channels begin at different times ({told}): cut to the {shortest} samples that all have"],
    )


def missing_columns(file: str, columns: Columns, wanted: list[str]) -> list[str]:
    """Say which declared channels a file lacks, with those it holds.

    Parameters
    ----------
    file : str
        Its name, for messages.
    wanted : list of str
        Names of channels.

    Returns
    -------
    list of str
        A message each; empty where none is missing.
    """
    there = ", ".join(list(columns.values)[:12]) + (", ..." if len(columns.values) > 12 else "")
    left_out = f" ({'; '.join(columns.notes[:2])})" if columns.notes else ""
    return [
        f"{file}: no channel {name!r}; it holds: {there}. Correct its name in [channels]{left_out}"
        for name in wanted
        if name not in columns.values
    ]


def _quoted(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() else f'"{name}"'
