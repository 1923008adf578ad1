"""What a file of another program holds: columns with names, and what it says of them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import is_unit
from analysis.estimation.sampling import RateSeen, settled

MOST_COLUMNS = 5000
MOST_BYTES = 2_000_000_000
"""Of all columns together."""


@dataclass(frozen=True)
class Columns:
    """Columns of one file.

    Attributes
    ----------
    values : dict of str to (N,) ndarray
        float64 or complex128, by name; they may differ in length.
    units : dict of str to str
        As the file writes them, of those columns for which it does.
    rates : dict of str to float
        Samples per second, Hz, of those columns for which the file gives it.
    scalars : dict of str to float
        Single numbers of the file, among them perhaps a sample rate.
    channels : dict of str to str
        Names without the group before them, of those columns that have it there because groups share names.
    places : dict of str to str
        Node and direction, ``5:+z``, of those columns for which the file gives them.
    references : dict of str to str
        The same of the drive, of FRFs.
    starts : dict of str to float
        Time of the first sample, s, of those columns for which the file gives it; only differences count.
    doubts : dict of str to str
        Why the rate of a column is not to be trusted, and what to do; it matters only where the column is used.
    aliases : dict of str to str
        Columns by other names that a user may know them by.
    shared : tuple of str
        Columns outside the groups that belong to each of them, such as the times of all hits.
    notes : tuple of str
        What the user should know of the file, such as warnings of the library that read it.
    """

    values: dict[str, NDArray[Any]]
    units: dict[str, str] = field(default_factory=dict)
    rates: dict[str, float] = field(default_factory=dict)
    scalars: dict[str, float] = field(default_factory=dict)
    channels: dict[str, str] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)
    references: dict[str, str] = field(default_factory=dict)
    starts: dict[str, float] = field(default_factory=dict)
    doubts: dict[str, str] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)
    shared: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.values:
            raise ValueError("holds no column of numbers")
        if len(self.values) > MOST_COLUMNS:
            raise ValueError(f"{len(self.values)} columns; at most {MOST_COLUMNS} allowed")
        size = sum(column.nbytes for column in self.values.values())
        if size > MOST_BYTES:
            raise ValueError(f"{size} bytes of numbers; at most {MOST_BYTES} allowed: export a part of it")

    @property
    def groups(self) -> tuple[str, ...]:
        """Groups into which the file divides its columns, all with the same channels; none where it does not."""
        held: dict[str, set[str]] = {}
        for name, channel in self.channels.items():
            held.setdefault(_group(name, channel), set()).add(channel)
        alike = len({frozenset(channels) for channels in held.values()}) == 1
        return tuple(held) if alike and {*self.channels, *self.shared} == set(self.values) else ()

    def of_group(self, group: str) -> "Columns":
        """Columns of one of the `groups`, by their names in it; ValueError where there is no such group."""
        if group not in self.groups:
            raise ValueError(f"no group {group!r}; it holds: {', '.join(self.groups) or 'no groups'}")
        short = {name: channel for name, channel in self.channels.items() if _group(name, channel) == group}
        short |= {name: name for name in self.shared}
        own: dict[str, Any] = {
            key: {short[n]: v for n, v in getattr(self, key).items() if n in short} for key in PER_COLUMN
        }
        return replace(self, **own, channels={}, shared=(), aliases={})


PER_COLUMN = ("values", "units", "rates", "places", "references", "starts", "doubts")
"""Attributes of `Columns` by the name of a column."""


def _group(name: str, channel: str) -> str:
    """Group of a column: ``Hit 1`` of ``Hit 1/Force``, ``run(2)`` of ``run(2).force``."""
    return name.removesuffix(channel)[:-1]


IN_BRACKETS = re.compile(r".*\S\s*[\[(]([^\[\]()]*)[\])]\s*")
"""A name with a unit, or the number of a channel, behind it."""


def with_units_of_names(columns: Columns) -> Columns:
    """Return the columns with the units that stand behind names, ``Force (N)``, where the file gives none."""
    found = {name: match[1] for name in columns.values if (match := IN_BRACKETS.fullmatch(name))}
    named = {name: unit for name, unit in found.items() if is_unit(unit) and unit.strip("-0123456789")}
    return replace(columns, units=named | columns.units)


AXIS = re.compile(r"freq|hz|omega|(?<![a-z])[fwt](?![a-z])|time|zeit|temps", re.IGNORECASE)
"""What an array of times or frequencies is called."""
FEWEST_ON_AXIS = 8
"""Values from which an array that rises throughout may be an axis; a list of nodes is often shorter."""


def of_array(
    name: str, array: NDArray[Any], axis: int | None = None, labels: Sequence[str] = ()
) -> dict[str, NDArray[Any]]:
    """Columns of an array: ``H[1]``, ``H[2]``, ...; of FRFs ``H[2,1]``, too.

    Parameters
    ----------
    name : str
    array : (N,), (C, N) or (N, C) ndarray
        Axes of length 1 do not count, but for one of a single response before several references. Complex ones,
        and those whose `axis` is known, may have three: responses before references, or sweeps before sensors.
    axis : int, optional
        That of samples or lines in the squeezed array; the longest unless given.
    labels : sequence of str
        Names of the channels, where they are known; they replace the numbers.

    Returns
    -------
    dict of str to (N,) ndarray
        float64 or complex128. A first column of a complex array that is real and rises is the frequency of the
        others, and called ``frequency``: ``[f, H]``, as analysers save FRFs.

    Raises
    ------
    ValueError
        For more axes, or more than `MOST_COLUMNS` channels.
    """
    kind = complex if np.iscomplexobj(array) else float
    squeezed = np.squeeze(array)
    if squeezed.ndim == 1:
        return {name: np.asarray(squeezed, dtype=kind)}
    if squeezed.ndim not in ((2, 3) if kind is complex or axis is not None else (2,)):
        raise ValueError(
            f"{name} has {squeezed.ndim} axes; allowed: 1 or 2, and 3 of FRFs. Export it as channels by samples"
        )
    if axis is None:
        # of as many channels as samples the rows are channels
        axis = (
            int(np.argmax(squeezed.shape)) if squeezed.ndim == 3 else int(squeezed.shape[1] >= squeezed.shape[0])
        )
    rows = np.moveaxis(squeezed, axis, -1)
    if squeezed.ndim == 3:
        _, references, samples = rows.shape
        rows = rows.reshape(-1, samples)
        numbers = [f"[{row // references + 1},{row % references + 1}]" for row in range(len(rows))]
    elif kind is complex and _of_one_response(array.shape, axis):
        numbers = [f"[1,{row}]" for row in range(1, len(rows) + 1)]
    else:
        numbers = [f"[{row}]" for row in range(1, len(rows) + 1)]
    if len(rows) > MOST_COLUMNS:
        raise ValueError(f"{name} is {' by '.join(map(str, squeezed.shape))}; at most {MOST_COLUMNS} channels")
    if kind is complex and squeezed.ndim == 2 and _leads_with_frequency(rows):
        single = len(rows) == 2
        named = {name if single else f"{name}[{n}]": np.asarray(h, kind) for n, h in enumerate(rows[1:], start=1)}
        return {FREQUENCY: np.asarray(rows[0].real, dtype=float)} | named
    if len(labels) == len(rows) and len(set(labels)) == len(rows):
        return {label: np.asarray(row, dtype=kind) for label, row in zip(labels, rows, strict=True)}
    return {f"{name}{number}": np.asarray(row, dtype=kind) for number, row in zip(numbers, rows, strict=True)}


def _of_one_response(shape: tuple[int, ...], axis: int) -> bool:
    """Whether an array of FRFs has one response before its references; `axis` of the lines when squeezed."""
    long = [place for place, length in enumerate(shape) if length > 1]
    others = [length for place, length in enumerate(shape) if place != long[axis]]
    return len(others) == 2 and others[0] == 1


FREQUENCY = "frequency"
"""Name of the lines that stand in the first column of a complex array."""


def _leads_with_frequency(rows: NDArray[Any]) -> bool:
    """Whether the first row is real and rises, and the second is not real."""
    first = rows[0]
    return len(rows) > 1 and bool(
        not first.imag.any() and (np.diff(first.real) > 0.0).all() and rows[1].imag.any()
    )


def _axis_lengths(arrays: Mapping[str, NDArray[Any]]) -> set[int]:
    """Lengths of the arrays that are axes: called like times or frequencies, or else any that rise throughout."""
    rising = {
        name: len(one)
        for name, one in ((name, np.squeeze(array)) for name, array in arrays.items() if array.dtype.kind in "iuf")
        if one.ndim == 1 and len(one) >= FEWEST_ON_AXIS and bool((np.diff(one.astype(float)) > 0.0).all())
    }
    named = {length for name, length in rising.items() if AXIS.search(name)}
    return named or set(rising.values())


def of_named_arrays(
    arrays: Mapping[str, NDArray[Any]],
    axes: Mapping[str, int] | None = None,
    labels: Mapping[str, Sequence[str]] | None = None,
) -> Columns:
    """Columns of a container of arrays with names: single numbers apart, what is no number left out.

    Parameters
    ----------
    arrays : mapping of str to ndarray
    axes : mapping of str to int, optional
        Axis of the samples or lines in squeezed arrays, where the container says it. Otherwise that is the axis as
        long as the times or frequencies beside it, and the longest one where there are none.
    labels : mapping of str to sequence of str, optional
        Names of the channels of an array.

    Returns
    -------
    Columns
        With a note for each array that cannot be divided into columns: it does not matter unless it is used.

    Raises
    ------
    ValueError
        Where no column is left.
    """
    values: dict[str, NDArray[Any]] = {}
    scalars: dict[str, float] = {}
    notes: list[str] = []
    lengths = _axis_lengths(arrays)
    for name, array in arrays.items():
        if array.dtype.kind not in "biufc" or array.size == 0:
            continue
        if array.size == 1:
            scalars[name] = float(np.real(array.reshape(-1)[0]))
            continue
        try:
            axis = (axes or {}).get(name)
            if axis is None:
                axis = _sample_axis(name, np.squeeze(array).shape, lengths)
            found = of_array(name, array, axis, (labels or {}).get(name, ()))
        except ValueError as error:
            notes.append(str(error))
            continue
        if FREQUENCY in found and FREQUENCY in values and not np.array_equal(found[FREQUENCY], values[FREQUENCY]):
            found = {f"{name} {FREQUENCY}" if one == FREQUENCY else one: column for one, column in found.items()}
        values |= {
            unused_name(one, values) if one in values and one != FREQUENCY else one: c for one, c in found.items()
        }
    if not values and notes:
        raise ValueError("; ".join(notes[:3]))
    return Columns(values, scalars=scalars, notes=tuple(notes))


def _sample_axis(name: str, shape: tuple[int, ...], lengths: set[int]) -> int | None:
    """Return the axis as long as times or frequencies; None where that tells nothing."""
    if len(shape) < 2 or not lengths:
        return None
    fitting = [axis for axis, length in enumerate(shape) if length in lengths]
    if len(fitting) > 1:
        raise ValueError(
            f"{name} is {' by '.join(map(str, shape))}, and several axes are as long as times or frequencies "
            f"beside it: "
            "which one is theirs is not known; save each channel or FRF as an array of its own"
        )
    return fitting[0] if fitting else None


def unused_name(name: str, taken: dict[str, Any]) -> str:
    """Return `name`, or ``name (2)`` and so on where that is taken.

    Parameters
    ----------
    name : str
    taken : dict
        By the names that are taken.

    Returns
    -------
    str
    """
    if name not in taken:
        return name
    number = 2
    while f"{name} ({number})" in taken:
        number += 1
    return f"{name} ({number})"


def add_rate(columns: Columns, name: str, seen: Sequence[RateSeen], default: str = "") -> None:
    """Add a column's sample rate, and what is doubtful in it.

    Parameters
    ----------
    columns : Columns
    name : str
    seen : sequence of RateSeen
        All places in the file that give it.
    default : str
        Where the file has the 1 s of programs that know no rate: what it calls it.
    """
    if seen:
        try:
            columns.rates[name] = settled(seen)
        except ValueError as error:
            columns.rates[name] = min(seen, key=lambda one: one.error).rate
            columns.doubts[name] = str(error)
    elif default:
        columns.doubts[name] = (
            f"{default} = 1 s is what programs write that were not told the sample rate; declare sample_rate "
            f"= ... "
            "in Hz (flexura new test: --rate)"
        )
