"""Columns of a file, by its declaration, to signals in SI units that can be a measurement.

Every place that gives the sample rate has to agree.

FRFs that a file holds as such, checked.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.channel import UNITS, Quantity
from analysis.estimation.estimators import coherence_variance
from analysis.estimation.quantities import (
    FREQUENCIES,
    TIMES,
    Calibration,
    axis_scale,
    calibration,
    frf_name,
    unit_behind_name,
)
from analysis.estimation.sampling import RateSeen, of_step, of_times, settled
from analysis.estimation.spectra import SampledSignals, signal_faults
from analysis.estimation.transfer import MeasuredTransfer
from app.files.campaign_error import Problem
from app.files.declarations.modal_test import MEASURED, PARTS, ModalTest, RecordOfTest, dof
from app.files.measurements.columns import Columns
from app.files.measurements.complex_pairs import of_magnitude_and_phase

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
        hertz = FREQUENCIES[unit_behind_name(test.sample_rate, FREQUENCIES) or "Hz"]
        seen.append(RateSeen(hertz * columns.scalars[test.sample_rate], 0.0, f"its number {test.sample_rate!r}"))
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
            written = channel.unit or columns.units.get(name) or unit_behind_name(name, TIMES) or "s"
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


def given_frfs(record: RecordOfTest, columns: Columns, test: ModalTest) -> list[MeasuredTransfer]:
    """Read FRFs that a file holds as such, in SI units.

    Parameters
    ----------
    record : RecordOfTest
        Says which file, and at which places it was measured.
    columns : Columns
        Of that file.
    test : ModalTest
        Says what each column is.

    Returns
    -------
    list of MeasuredTransfer
        Without lines at 0 Hz.

    Raises
    ------
    ValueError
        For columns that are not there, lines that cannot be, and values that are no FRF.
    """
    by_role: dict[str, list[str]] = {}
    for name, channel in test.channels.items():
        by_role.setdefault(channel.role, []).append(name)
    used = [
        n for n, channel in test.channels.items() if channel.role not in ("unused", "drive", "response", "time")
    ]
    lacking = missing_columns(record.file, columns, used)
    if lacking:
        raise ValueError("\n".join(lacking))
    axis = by_role["frequency"][0]
    written = test.channels[axis].unit or columns.units.get(axis) or unit_behind_name(axis, FREQUENCIES) or "Hz"
    frequency = columns.values[axis].real * axis_scale(written, FREQUENCIES, "frequencies")
    read, drove = _calibrated("response", test.frf.response), _calibrated("reference", test.frf.reference)
    made = []
    named = _named_frfs(record, columns, test, by_role)
    coherences = _coherence_of_each(record.file, by_role.get("coherence", []), len(named))
    for (name, h, response, reference), beside in zip(named, coherences, strict=True):
        used_lines = _checked_lines(record.file, name, frequency, h)
        variance, coherence = None, None
        if beside:
            coherence, variance = _with_coherence(record.file, beside, columns.values[beside], h, used_lines)
        made.append(
            MeasuredTransfer(
                name=f"{frf_name(read.quantity, drove.quantity)} {name}",
                response=dof(response),
                reference=dof(reference),
                quantity=read.quantity,
                frequency=frequency[used_lines],
                h=np.asarray(h[used_lines] * (read.scale / drove.scale), dtype=complex),
                reference_quantity=drove.quantity,
                units=(UNITS[read.quantity], UNITS[drove.quantity]),
                variance=None if variance is None else variance * (read.scale / drove.scale) ** 2,
                coherence=coherence,
            )
        )
    return made


def _calibrated(end: str, unit: str) -> Calibration:
    """Return what the unit of one end of the FRFs means; ValueError, with the key, where that is not known."""
    try:
        return calibration(unit, None, "voltage" if unit.endswith("V") else None)
    except ValueError as error:
        raise ValueError(f"frf.{end}: {error}") from error


def _named_frfs(
    record: RecordOfTest, columns: Columns, test: ModalTest, by_role: dict[str, list[str]]
) -> list[tuple[str, NDArray[Any], str, str]]:
    """Name, values, response's place and reference's place of every FRF in the file."""
    found: list[tuple[str, NDArray[Any], str, str]] = []
    for parts in PARTS:
        if all(part in by_role for part in parts):
            one, other = (by_role[part][0] for part in parts)
            h = _joined_parts(record.file, columns, test, one, other)
            found.append((record.file, h, record.at.get("response", "1"), record.at.get("reference", "1")))
    complex_ones = by_role.get("frf", ())
    if "response" in record.at and len(complex_ones) > 1:
        raise ValueError(
            f"{record.file}: record.at gives one place for the response, and {len(complex_ones)} channels "
            f"have the role "
            f"frf; give each its own: at = {{ {_quoted_key(complex_ones[0])} = {record.at['response']!r}, ... }}"
        )
    for number, name in enumerate(complex_ones, start=1):
        channel = test.channels[name]
        place = record.at.get(name) or record.at.get("response") or channel.at or str(number)
        found.append((name, columns.values[name], place, record.at.get("reference") or channel.reference or "1"))
    return found


def _quoted_key(name: str) -> str:
    return name if name.isidentifier() else f'"{name}"'


def _joined_parts(file: str, columns: Columns, test: ModalTest, one: str, other: str) -> NDArray[np.complex128]:
    """FRF of two columns: real and imaginary part, or magnitude and phase."""
    if len(columns.values[one]) != len(columns.values[other]):
        raise ValueError(
            f"{file}: {one!r} has {len(columns.values[one])} values, {other!r} {len(columns.values[other])}; "
            f"export "
            "both alike"
        )
    if test.channels[one].role == "real":
        return np.asarray(columns.values[one].real + 1j * columns.values[other].real, dtype=complex)
    units = [test.channels[name].unit or columns.units.get(name, "") for name in (one, other)]
    return of_magnitude_and_phase(columns.values[one].real, columns.values[other].real, units[0], units[1])[0]


def _coherence_of_each(file: str, names: list[str], count: int) -> list[str | None]:
    """Return the column of coherence that belongs to each of `count` FRFs; None without any."""
    if len(names) not in (0, 1, count):
        raise ValueError(
            f"{file}: {len(names)} channels with the role coherence, {count} FRFs; declare one for "
            "all FRFs, or one for each in the same order"
        )
    return [*names] if len(names) == count else count * [names[0] if names else None]


def _with_coherence(
    file: str, name: str, values: NDArray[Any], h: NDArray[Any], used: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Coherence of the used lines, and the FRF's variance, where that follows, in the file's own unit squared."""
    if values.shape != h.shape:
        raise ValueError(f"{file}: coherence {name!r}: {len(values)} values, the FRF {len(h)}; export both alike")
    coherence = values[used].real.astype(float)
    try:
        return coherence, coherence_variance(np.asarray(h[used], dtype=complex), coherence)
    except ValueError as error:
        raise ValueError(f"{file}: coherence {name!r}: {error}; give it the role unused, or correct it") from error


def _checked_lines(file: str, name: str, frequency: NDArray[np.float64], h: NDArray[Any]) -> NDArray[np.intp]:
    """Places of the lines above 0 Hz, ascending; ValueError, with what to do, for what is no FRF."""
    place = f"{file}: FRF {name!r}"
    if h.shape != frequency.shape:
        raise ValueError(f"{place}: {len(h)} values at {len(frequency)} frequencies; export both together")
    # divided by jw, or magnitude in decibels: at 0 Hz, a line that is not used, there may be no number
    if not (np.isfinite(frequency).all() and np.isfinite(h[frequency != 0.0]).all()):
        raise ValueError(f"{place}: values that are not finite; export it again, or without these lines")
    if (frequency < 0.0).any():
        raise ValueError(f"{place}: frequencies below 0 Hz; export the one-sided FRF")
    step = np.diff(frequency)
    if (step == 0.0).any():
        twice = frequency[1:][step == 0.0][0]
        raise ValueError(f"{place}: {twice:g} Hz occurs twice; export more digits, or each line once")
    down = bool((step < 0.0).all())  # a sine that was stepped down
    if not down and (step < 0.0).any():
        raise ValueError(f"{place}: frequencies go up and down; sort the lines")
    places = np.arange(len(frequency))[:: -1 if down else 1]
    used = places[frequency[places] > 0.0]
    if len(used) < 8:
        raise ValueError(f"{place}: {len(used)} lines above 0 Hz; 8 at least: export the whole band")
    if not np.abs(h[used]).any():
        raise ValueError(f"{place}: zero on every line; check the channel, or leave it out")
    if not np.iscomplexobj(h) or not h[used].imag.any():
        raise ValueError(
            f"{place}: real values; an FRF needs its phase: export complex values, or real and imaginary part"
        )
    if np.ptp(h[used].real) == np.ptp(h[used].imag) == 0.0:
        raise ValueError(f"{place}: the same value on every line; this is no FRF of a structure, leave it out")
    return used
