"""Columns of a file, by its declaration, to signals in SI units that can be a measurement.

Every place that gives the sample rate has to agree.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.channel import Quantity
from analysis.estimation.quantities import TIMES, axis_scale
from analysis.estimation.recording import SampledSignals, signal_faults
from analysis.estimation.sampling import RateSeen, of_step, of_times, settled
from app.files.campaign_error import Problem
from app.files.declarations.modal_test import MEASURED, ModalTest
from app.files.measurements.columns import Columns

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


SAMPLED_RATE = r"(?<![a-z])fs(?![a-z])|sampl\w*[ _]*(rate|freq)|abtast"
"""What a single number of a file is called that can only be the sample rate of its signals."""


def sample_rate(file: str, columns: Columns, test: ModalTest) -> tuple[float, list[str]]:
    """Sample rate of signals: as declared, from their times, or from the file; all that give it have to agree.

    Parameters
    ----------
    file : str
        Its name.

    Returns
    -------
    rate : float
        Hz.
    notes : list of str
        Where the file contradicts the rate that is declared as a number, which is then used.

    Raises
    ------
    ValueError
        Where nothing gives it, times are not evenly spaced, it has too few digits, or two places contradict each
        other; channels that are not used do not count.
    """
    if isinstance(test.sample_rate, float):
        try:
            seen = _rates_of_file(columns, test)
        except ValueError:  # a number that is declared needs no other
            return test.sample_rate, []
        given = RateSeen(test.sample_rate, 0.0, "sample_rate")
        notes = [
            f"{file}: sample_rate = {given.rate:g} Hz is used as declared; {one.place} says {one.rate:.9g} Hz"
            for one in seen
            if not one.agrees(given)
        ]
        return test.sample_rate, notes[:1]
    seen = _rates_of_file(columns, test)
    if isinstance(test.sample_rate, str):
        if test.sample_rate not in columns.scalars:
            held = ", ".join(columns.scalars) or "none"
            raise ValueError(f"sample_rate: no single number {test.sample_rate!r} in the file; it holds: {held}")
        seen.append(RateSeen(columns.scalars[test.sample_rate], 0.0, f"its number {test.sample_rate!r}"))
    if not seen:
        raise ValueError(
            "the files give no sample rate; give sample_rate in Hz, its name in a file, or the role time"
        )
    return settled(seen), []


def _rates_of_file(columns: Columns, test: ModalTest) -> list[RateSeen]:
    """Every rate that a file gives for the channels used; ValueError for a doubtful one."""
    used = [name for name, channel in test.channels.items() if channel.role in MEASURED]
    seen: list[RateSeen] = []
    for name, channel in test.channels.items():
        if channel.role == "time" and name in columns.values:
            written = channel.unit or columns.units.get(name, "s")
            seen.append(
                of_times(columns.values[name].real * axis_scale(written, TIMES, "times"), f"its times {name!r}")
            )
    rates = {name: columns.rates[name] for name in used if name in columns.rates}
    if rates and max(rates.values()) - min(rates.values()) > 1e-6 * max(rates.values()):
        told = ", ".join(f"{name} {rate:.9g} Hz" for name, rate in rates.items())
        raise ValueError(
            f"channels of several rates ({told}); all of a run need one rate: resample them, or give those of "
            "another rate the role unused"
        )
    doubtful = [columns.doubts[name] for name in used if name in columns.doubts]
    if doubtful and not seen:
        raise ValueError(doubtful[0])
    if rates:
        name, rate = next(iter(rates.items()))
        seen.append(
            replace(of_step(1.0 / rate, f"the rate of {name!r}"), place=f"the rate of {name!r} in the file")
        )
    named = [name for name in columns.scalars if re.search(SAMPLED_RATE, name, re.IGNORECASE)]
    if seen and len(named) == 1 and named[0] != test.sample_rate and columns.scalars[named[0]] > 0.0:
        held = RateSeen(columns.scalars[named[0]], 0.0, f"its number {named[0]!r}")
        in_kilohertz = replace(held, rate=1e3 * held.rate)
        seen.append(in_kilohertz if in_kilohertz.agrees(seen[0]) else held)
    return seen


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
