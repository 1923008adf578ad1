"""What a file of another program holds: columns with names, and what it says of them."""

import re
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.quantities import is_unit

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
    """

    values: dict[str, NDArray[Any]]
    units: dict[str, str] = field(default_factory=dict)
    rates: dict[str, float] = field(default_factory=dict)
    scalars: dict[str, float] = field(default_factory=dict)
    channels: dict[str, str] = field(default_factory=dict)
    places: dict[str, str] = field(default_factory=dict)

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
            held.setdefault(name.removesuffix(f"/{channel}"), set()).add(channel)
        alike = len({frozenset(channels) for channels in held.values()}) == 1
        return tuple(held) if alike and self.channels.keys() == self.values.keys() else ()

    def of_group(self, group: str) -> "Columns":
        """Columns of one of the `groups`, by their names in it; ValueError where there is no such group."""
        if group not in self.groups:
            raise ValueError(f"no group {group!r}; it holds: {', '.join(self.groups) or 'no groups'}")
        short = {f"{group}/{channel}": channel for channel in self.channels.values()}
        return Columns(
            {short[name]: values for name, values in self.values.items() if name in short},
            {short[name]: unit for name, unit in self.units.items() if name in short},
            {short[name]: rate for name, rate in self.rates.items() if name in short},
            self.scalars,
            places={short[name]: place for name, place in self.places.items() if name in short},
        )


IN_BRACKETS = re.compile(r".*\S\s*[\[(]([^\[\]()]*)[\])]\s*")
"""A name with a unit, or the number of a channel, behind it."""


def with_units_of_names(columns: Columns) -> Columns:
    """Return the columns with the units that stand behind names, ``Force (N)``, where the file gives none."""
    found = {name: match[1] for name in columns.values if (match := IN_BRACKETS.fullmatch(name))}
    named = {name: unit for name, unit in found.items() if is_unit(unit) and unit.strip("-0123456789")}
    return replace(columns, units=named | columns.units)


def of_array(name: str, array: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Columns of an array, its longest axis that of samples: ``H[1]``, ``H[2]``, ...; of FRFs ``H[2,1]``, too.

    Parameters
    ----------
    name : str
    array : (N,), (C, N) or (N, C) ndarray
        Axes of length 1 do not count. Complex ones may have three: responses before references.

    Returns
    -------
    dict of str to (N,) ndarray
        float64 or complex128.

    Raises
    ------
    ValueError
        For more axes, or more than `MOST_COLUMNS` channels.
    """
    kind = complex if np.iscomplexobj(array) else float
    squeezed = np.squeeze(array)
    if squeezed.ndim == 1:
        return {name: np.asarray(squeezed, dtype=kind)}
    if squeezed.ndim == 3 and kind is complex:
        squeezed = np.moveaxis(squeezed, int(np.argmax(squeezed.shape)), 2)
        _, references, samples = squeezed.shape
        rows = squeezed.reshape(-1, samples)
        numbers = [f"{row // references + 1},{row % references + 1}" for row in range(len(rows))]
        return {
            f"{name}[{number}]": np.asarray(row, dtype=kind) for number, row in zip(numbers, rows, strict=True)
        }
    if squeezed.ndim > 2:
        raise ValueError(f"{name} has {squeezed.ndim} axes; allowed: 1 or 2. Export it as channels by samples")
    rows = squeezed if squeezed.shape[1] >= squeezed.shape[0] else squeezed.T
    if len(rows) > MOST_COLUMNS:
        raise ValueError(f"{name} is {squeezed.shape[0]} by {squeezed.shape[1]}; at most {MOST_COLUMNS} channels")
    return {f"{name}[{number}]": np.asarray(row, dtype=kind) for number, row in enumerate(rows, start=1)}


def of_named_arrays(arrays: dict[str, NDArray[Any]]) -> Columns:
    """Columns of a container of arrays with names: single numbers apart, what is no number left out.

    Parameters
    ----------
    arrays : dict of str to ndarray

    Returns
    -------
    Columns

    Raises
    ------
    ValueError
        As `of_array`, and where no column is left.
    """
    values: dict[str, NDArray[Any]] = {}
    scalars: dict[str, float] = {}
    for name, array in arrays.items():
        if array.dtype.kind not in "biufc" or array.size == 0:
            continue
        if array.size == 1:
            scalars[name] = float(np.real(array.reshape(-1)[0]))
        else:
            values |= of_array(name, array)
    return Columns(values, scalars=scalars)


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
