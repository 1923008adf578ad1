"""FRFs in universal files (data set 58), the exchange format of modal software, through pyuff.

Text is written with all the digits that its columns hold. The format has 13 columns for a frequency and 20 for a
value. Writers that fill the 13 with an exponent keep six digits, and lines 0.01953125 Hz apart come back 3 ppm
off; a plain decimal in the same columns keeps ten or more.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Real
from analysis.estimation.estimators import coherence_variance
from analysis.estimation.transfer import MeasuredTransfer
from app.files.atomic import write_text
from app.files.bad_file import ResultFileError, quoted
from app.files.measurements.columns import unused_name
from app.files.measurements.formats import FORMATS
from app.files.uff.geometry import geometry_text
from app.files.uff.opening import FileUnits, file_units, in_hertz, opened_uff, unit_of

COHERENCE_FUNCTIONS = (6, 26)
"""Coherence, and multiple coherence."""
FUNCTION_TYPES = range(28)
FUNCTIONS = {0: "general", 1: "time response", 2: "auto spectrum", 3: "cross spectrum", 6: "coherence", 9: "PSD"}
NAMELESS = "NONE"
"""What the format has for a name that there is not."""


TIME_FUNCTION, FRF_FUNCTION = 1, 4
TIME_TYPE, FREQUENCY_TYPE = 17, 18
QUANTITIES = {3: "strain", 8: "displacement", 11: "velocity", 12: "acceleration", 13: "force", 15: "pressure"}
GENERAL = 1
"""Of what the format has no number for: voltage, charge."""
DOUBLE_REAL, DOUBLE_COMPLEX = 4, 6
FREQUENCY_COLUMNS = 12
"""Of 13 for a frequency; one stays blank, so that numbers stand apart."""


def frf_text(frf: MeasuredTransfer) -> str:
    """Return a data set 58, delimiters included.

    Returns
    -------
    str
        Evenly spaced lines by their first and their distance, others each with its own.
    """
    numbers = {name: number for number, name in QUANTITIES.items()}
    (node, direction), (from_node, from_direction) = (
        (int(part) for part in end.split(":")) for end in (frf.response, frf.reference)
    )
    even = _even(frf)
    first, last = float(frf.frequency[0]), float(frf.frequency[-1])
    first, step = (first, (last - first) / (len(frf.frequency) - 1)) if even else (0.0, 0.0)
    ordinate = numbers.get(frf.quantity, 0 if frf.quantity == "unknown" else GENERAL)
    lines = [
        f"{-1:6d}",
        f"{58:6d}{'':74}",
        *(f"{text[:80]:80}" for text in (frf.name, "NONE", "NONE", "NONE", "NONE")),
        f"{FRF_FUNCTION:5d}{0:10d}{0:5d}{0:10d} {'NONE':10}{node:10d}{direction:4d} {'NONE':10}{from_node:10d}"
        f"{from_direction:4d}",
        f"{DOUBLE_COMPLEX:10d}{len(frf.h):10d}{int(even):10d}{_narrow(first)}{_narrow(step)}{_narrow(0.0)}",
        _axis(FREQUENCY_TYPE, "NONE"),
        _axis(ordinate, frf.units[0] or "NONE"),
        _axis(numbers.get(frf.reference_quantity, GENERAL), frf.units[1] or "NONE"),
        _axis(0, "NONE"),
        *_values(frf, even),
        f"{-1:6d}",
    ]
    return "\n".join(lines) + "\n"


def time_text(name: str, place: str, quantity: str, unit: str, samples: Real, step: float) -> str:
    """Return a data set 58 of a signal, delimiters included.

    Parameters
    ----------
    name : str
        Of the channel, in the first line of its head.
    place : str
        Node and direction, ``5:+3``.
    quantity, unit : str
        What it measures.
    samples : (N,) ndarray
    step : float
        Between samples, s.

    Returns
    -------
    str
    """
    numbers = {name: number for number, name in QUANTITIES.items()}
    node, direction = (int(part) for part in place.split(":"))
    values = [f"{value:20.12e}" for value in samples]
    lines = [
        f"{-1:6d}",
        f"{58:6d}{'':74}",
        *(f"{text[:80]:80}" for text in (name, "NONE", "NONE", "NONE", "NONE")),
        f"{TIME_FUNCTION:5d}{0:10d}{0:5d}{0:10d} {name[:10]:10}{node:10d}{direction:4d} {'NONE':10}{0:10d}{0:4d}",
        f"{DOUBLE_REAL:10d}{len(values):10d}{1:10d}{_narrow(0.0)}{_narrow(step)}{_narrow(0.0)}",
        _axis(TIME_TYPE, "s"),
        _axis(numbers.get(quantity, GENERAL), unit),
        _axis(0, "NONE"),
        _axis(0, "NONE"),
        *("".join(values[n : n + 4]) for n in range(0, len(values), 4)),
        f"{-1:6d}",
    ]
    return "\n".join(lines) + "\n"


def _axis(kind: int, unit: str) -> str:
    return f"{kind:10d}{0:5d}{0:5d}{0:5d} {'NONE':20} {unit[:20]:20}"


def _values(frf: MeasuredTransfer, even: bool) -> list[str]:
    """Two complex values in a line, or one behind its frequency."""
    pairs = [f"{value.real:20.12e}{value.imag:20.12e}" for value in frf.h]
    if even:
        return ["".join(pairs[n : n + 2]) for n in range(0, len(pairs), 2)]
    return [_narrow(float(f)) + pair for f, pair in zip(frf.frequency, pairs, strict=True)]


def _even(frf: MeasuredTransfer) -> bool:
    """Whether the lines are those that a start and an increment give."""
    even = np.linspace(frf.frequency[0], frf.frequency[-1], len(frf.frequency))
    return bool(np.allclose(frf.frequency, even, rtol=1e-9))


def _narrow(value: float) -> str:
    """Return a number in 13 columns with as many digits as they hold."""
    exact = repr(value)
    if len(exact) <= FREQUENCY_COLUMNS:
        return f"{exact:>13}"
    for digits in range(FREQUENCY_COLUMNS - 1, 0, -1):
        text = f"{value:.{digits}g}"
        if len(text) <= FREQUENCY_COLUMNS:
            return f"{text:>13}"
    return f"{value:13.5e}"


def read_frfs(path: Path) -> list[MeasuredTransfer]:
    """Read every FRF of a universal file.

    Raises
    ------
    ResultFileError
        Where the file cannot be read, holds no FRF, or one of its FRFs is cut short, not finite or has
        lines out of order; data sets that are no FRF are named.
    """
    if not path.is_file():
        raise ResultFileError(f"{path}: no such file")
    try:
        kinds, sets, units = _read_sets(path)
        frfs = [d for n, d in enumerate(sets, start=1) if _function(n, d) == FRF_FUNCTION]
        beside = _coherences(frfs, sets)
        read = [_with_coherence(path, _frf(path, n, d, units), beside[n - 1]) for n, d in enumerate(frfs, start=1)]
    except ResultFileError:
        raise
    except Exception as error:  # pyuff says what is wrong with a file by bare Exception, and by accident
        if any(path.suffix.lower() in one.endings for one in FORMATS if one.name != "uff"):
            raise ResultFileError(
                f"{path}: no universal file; its signals or FRFs are declared first: "
                f"flexura new test {quoted(path)}"
            ) from error
        raise ResultFileError(f"{path}: not a readable universal file, or cut short ({error})") from error
    if not frfs:
        held = sorted({FUNCTIONS.get(int(d.get("func_type", -1)), str(d.get("func_type"))) for d in sets})
        other = sorted({str(kind) for kind in kinds if kind != 58})
        listed = ", ".join([*(f"58 ({h})" for h in held), *other]) or "none"
        onward = f"; of its signals make FRFs: flexura new test {quoted(path)}" if "time response" in held else ""
        raise ResultFileError(
            f"{path}: holds no frequency response function (data set 58, function type 4); found: {listed}{onward}"
        )
    return _told_apart(read)


def _told_apart(frfs: list[MeasuredTransfer]) -> list[MeasuredTransfer]:
    """Add their ends to names that several FRFs have: programs name all FRFs of a test after the test."""
    often, taken, named = Counter(frf.name for frf in frfs), dict[str, MeasuredTransfer](), []
    for frf in frfs:
        ends = f"{frf.response} / {frf.reference}"
        wanted = frf.name if often[frf.name] == 1 else ends if frf.name == NAMELESS else f"{frf.name} {ends}"
        name = unused_name(wanted, taken)
        taken[name] = frf
        named.append(replace(frf, name=name))
    return named


def functions(path: Path) -> list[dict[str, Any]]:
    """Read every data set 58 of a universal file as pyuff's dictionary; ValueError for one that is damaged."""
    sets = _read_sets(path)[1]
    for number, data in enumerate(sets, start=1):
        _function(number, data)
    return sets


def _read_sets(path: Path) -> tuple[list[int], list[dict[str, Any]], FileUnits]:
    """Types of all data sets, those of type 58, and the units of the file."""
    with opened_uff(path) as (file, kinds), np.errstate(all="ignore"):  # on damaged bytes
        sets = [_as_dict(file.read_sets(n)) for n, kind in enumerate(kinds) if kind == 58]
        return kinds, sets, file_units(file, kinds)


def _coherences(frfs: Sequence[dict[str, Any]], sets: Sequence[dict[str, Any]]) -> list[dict[str, Any] | None]:
    """Coherence of every FRF, None without: of several between the same ends by their order."""
    held: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for data in sets:
        if int(data["func_type"]) in COHERENCE_FUNCTIONS:
            held.setdefault(_ends(data), []).append(data)
    often = Counter(_ends(data) for data in frfs)
    turn: Counter[tuple[str, str]] = Counter()
    found: list[dict[str, Any] | None] = []
    for data in frfs:
        ends = _ends(data)
        own = held.get(ends, [])
        found.append(None if not own else own[turn[ends]] if len(own) == often[ends] else own[-1])
        turn[ends] += 1
    return found


def _ends(data: dict[str, Any]) -> tuple[str, str]:
    return dof(data, "rsp"), dof(data, "ref")


def _with_coherence(path: Path, frf: MeasuredTransfer, data: dict[str, Any] | None) -> MeasuredTransfer:
    """Give an FRF the coherence that the file holds for it, and the variance that follows."""
    if data is None:
        return frf
    lines, values = np.asarray(data["x"], dtype=float), np.asarray(data["data"]).real.astype(float)
    lines = lines * in_hertz(data)
    used = lines > 0.0
    if lines.shape != values.shape or not np.array_equal(lines[used], frf.frequency):
        raise ResultFileError(
            f"{path}: the coherence of {frf.name!r} has {len(values)} lines, the FRF {len(frf.frequency)}: export "
            "both with the same lines, or the FRF alone"
        )
    coherence = values[used]
    try:
        return replace(frf, coherence=coherence, variance=coherence_variance(frf.h, coherence))
    except ValueError as error:
        raise ResultFileError(f"{path}: {frf.name!r}: {error}; export the FRF alone, or correct it") from error


def write_frfs(
    path: Path, frfs: Sequence[MeasuredTransfer], points: Mapping[int, tuple[float, float, float]] | None = None
) -> None:
    """Write FRFs as ASCII data sets 58, double precision, whole or not at all.

    Parameters
    ----------
    points : mapping of int to (float, float, float), optional
        m; nodes that are known.
    """
    write_text(path, geometry_text(path.stem, points) + "".join(frf_text(frf) for frf in frfs))


def _as_dict(data: Any) -> dict[str, Any]:
    """Return the one set pyuff read, which it may wrap in a list."""
    first: dict[str, Any] = data[0] if isinstance(data, list) else data
    return first


def _function(number: int, data: dict[str, Any]) -> int:
    """Return what a data set says it holds; ValueError where the format does not have it."""
    function = int(data.get("func_type", -1))
    if function not in FUNCTION_TYPES:
        raise ValueError(f"data set 58, number {number}: function type {function}; allowed 0 to 27")
    return function


def _frf(path: Path, number: int, data: dict[str, Any], file_units: FileUnits) -> MeasuredTransfer:
    """Check one data set and make it an FRF without its line at 0 Hz, which need not be finite."""
    name = str(data.get("id1", "")).strip() or f"FRF {number}"
    frequency = np.atleast_1d(np.asarray(data.get("x", ()), dtype=float))
    h = np.atleast_1d(np.asarray(data.get("data", ()), dtype=complex))
    declared = int(data.get("num_pts", len(h)))
    place = f"{path}: FRF {number} ({name})"
    if int(data.get("ord_data_type", 6)) not in (5, 6):
        raise ResultFileError(
            f"{place}: real values; an FRF needs complex ones (ordinate data type 5 or 6): export real and "
            "imaginary parts"
        )
    if len(frequency) != len(h) or len(h) != declared:
        raise ResultFileError(
            f"{place}: {len(h)} values and {len(frequency)} lines; {declared} are declared: cut short?"
        )
    try:
        frequency = frequency * in_hertz(data)
    except ValueError as error:
        raise ResultFileError(f"{place}: {error}") from error
    if not (np.isfinite(frequency).all() and np.isfinite(h[frequency != 0.0]).all()):
        raise ResultFileError(f"{place}: values that are not finite; export it again, or without these lines")
    if (np.diff(frequency) <= 0.0).any() or (frequency < 0.0).any():
        raise ResultFileError(f"{place}: frequencies must ascend from 0 Hz or above")
    used = frequency > 0.0
    if used.sum() < 8:
        raise ResultFileError(f"{place}: {int(used.sum())} lines above 0 Hz; at least 8 are needed to identify")
    quantity = QUANTITIES.get(int(data.get("ordinate_spec_data_type", 0)), "unknown")
    reference = QUANTITIES.get(int(data.get("orddenom_spec_data_type", 13)), "unknown")
    known = (
        unit_of(data, "ordinate") or file_units.names(quantity),
        unit_of(data, "orddenom") or file_units.names(reference),
    )
    return MeasuredTransfer(
        name, dof(data, "rsp"), dof(data, "ref"), quantity, frequency[used], h[used], reference, known
    )


def dof(data: dict[str, Any], end: str) -> str:
    """Node and direction of one end, ``rsp`` or ``ref``: ``5:+3``."""
    return f"{int(data.get(f'{end}_node', 0))}:{int(data.get(f'{end}_dir', 0)):+d}"
