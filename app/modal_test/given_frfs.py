"""FRFs that a file holds as such, checked."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.channel import UNITS
from analysis.estimation.estimators import coherence_variance
from analysis.estimation.quantities import FREQUENCIES, Calibration, axis_scale, calibration, frf_name
from analysis.estimation.transfer import MeasuredTransfer
from app.files.declarations.modal_test import PARTS, ModalTest, RecordOfTest, dof
from app.files.measurements.columns import Columns
from app.files.measurements.complex_pairs import of_magnitude_and_phase
from app.modal_test.signals import missing_columns


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
    written = test.channels[axis].unit or columns.units.get(axis, "Hz")
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
