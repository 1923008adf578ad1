"""HDF5 and netCDF of any program, by structure: arrays, dimension scales, units and rates in attributes.

netCDF of version 4, as xarray writes it, is HDF5 whose coordinates are dimension scales; version 3 is read by
scipy. Rattlesnake's files hold a table of channels beside the signals.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from h5py import h5d
from numpy.typing import NDArray

from analysis.estimation.quantities import FREQUENCIES, TIMES, is_unit, plain_unit
from analysis.estimation.sampling import RateSeen, is_default, of_step
from app.files.measurements.columns import AXIS, MOST_COLUMNS, Columns, add_rate, of_named_arrays, unused_name

DEEPEST = 8
"""Groups in groups."""
OBJECTS = 10_000
UNITS = ("units", "unit", "unit_string", "physical_unit", "y_unit")
"""Attributes that hold a unit, in small letters."""
RATES = re.compile(r"fs|f_?s(ample)?|(sampl\w*|scan)[ _]*(rate|freq\w*)|rate", re.IGNORECASE)
STEPS = re.compile(
    r"dt|delta_?[tx]|ts|(sampl\w*)[ _]*(interval|period|time)|(wf_)?increment|time_?step", re.IGNORECASE
)
NO_VARIABLE = b"This is a netCDF dimension but not a netCDF variable"
TABLE = ("node_number", "node_direction")
"""Columns of Rattlesnake's table of channels that tell it apart."""
SIGNALS = re.compile(r"time_data\w*")


@dataclass
class _Held:
    """What a file holds, gathered."""

    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    texts: dict[str, list[str]] = field(default_factory=dict)
    attributes: dict[str, dict[str, Any]] = field(default_factory=dict)
    scales: dict[str, list[str]] = field(default_factory=dict)
    """Names of the dimension scale of each axis, by array."""


def read(path: Path) -> Columns:
    """Read every array of numbers, in groups too: ``test/force``.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Columns
        With the units and rates of attributes.

    Raises
    ------
    ValueError
        For data kept in other files, and where there is no column.
    """
    with path.open("rb") as file:
        begins = file.read(3)
    held = _netcdf3(path) if begins == b"CDF" else _hdf5(path)
    table = next((name for name in _tables(held) if all(f"{name}{key}" in held.texts for key in TABLE)), None)
    return _of_rattlesnake(held, table) if table is not None else _columns(held)


def _hdf5(path: Path) -> _Held:
    held = _Held()
    with h5py.File(path) as file:
        held.attributes[""] = _attributes(file)
        waiting: list[tuple[h5py.Group, str, int]] = [(file, "", 0)]
        while waiting:
            group, before, depth = waiting.pop()
            for key in group:
                if not isinstance(group.get(key, getlink=True), h5py.HardLink):
                    continue  # links to other files
                name, one = f"{before}{key}", group[key]
                if len(held.arrays) + len(held.texts) > OBJECTS:
                    raise ValueError(f"more than {OBJECTS} arrays; export a part of it")
                if isinstance(one, h5py.Group) and depth < DEEPEST:
                    held.attributes[name] = _attributes(one)
                    waiting.append((one, f"{name}/", depth + 1))
                elif isinstance(one, h5py.Dataset):
                    _take(held, name, one)
    return held


def _take(held: _Held, name: str, one: h5py.Dataset) -> None:
    made = one.id.get_create_plist()
    if made.get_layout() == h5d.VIRTUAL or made.get_external_count():
        raise ValueError(f"{name} lies in other files; save it again with its data")
    if one.shape is None or NO_VARIABLE in bytes(one.attrs.get("NAME", b"")):
        return
    held.attributes[name] = _attributes(one)
    if h5py.check_string_dtype(one.dtype) is not None:
        held.texts[name] = [_text(part) for part in np.asarray(one[()]).reshape(-1)[:MOST_COLUMNS]]
    elif one.dtype.names is not None:
        real = next((key for key in ("real", "re", "r") if key in one.dtype.names), None)
        imag = next((key for key in ("imag", "im", "i") if key in one.dtype.names), None)
        if real and imag:
            parts = one[()]
            held.arrays[name] = parts[real] + 1j * parts[imag]
    elif one.dtype.kind in "biufc":
        held.arrays[name] = np.asarray(one[()])
        held.scales[name] = [_scale_of(axis) for axis in one.dims]


def _scale_of(axis: Any) -> str:
    """Path of the dimension scale of an axis; empty where it has none."""
    try:
        return str(axis[0].name).lstrip("/") if len(axis) else ""
    except (RuntimeError, KeyError, ValueError):  # a scale that was deleted
        return ""


def _attributes(one: h5py.HLObject) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key in one.attrs:
        try:
            value = one.attrs[key]
        except (OSError, TypeError, KeyError):  # of a type that h5py does not know
            continue
        if isinstance(value, bytes | str):
            found[key] = _text(value)
        elif np.size(value) == 1 and np.asarray(value).dtype.kind in "iuf":
            found[key] = float(np.asarray(value).reshape(-1)[0])
        elif np.size(value) == 1 and np.asarray(value).dtype.kind in "OSU":
            found[key] = _text(np.asarray(value).reshape(-1)[0])
        elif np.asarray(value).dtype.kind in "OSU" and np.size(value) <= MOST_COLUMNS:
            found[key] = [_text(part) for part in np.asarray(value).reshape(-1)]
    return found


def _text(value: Any) -> str:
    return (value.decode("utf-8", errors="replace") if isinstance(value, bytes) else str(value)).strip("\0 ")


def _netcdf3(path: Path) -> _Held:
    """Gather a netCDF file of version 3."""
    from scipy.io import netcdf_file

    held = _Held()
    with netcdf_file(path, "r", mmap=False) as file:
        held.attributes[""] = {key: _plain_attribute(value) for key, value in file._attributes.items()}  # type: ignore[attr-defined]
        for name, one in file.variables.items():
            data: NDArray[Any] = np.array(one[()])
            given = one._attributes.items()  # type: ignore[attr-defined]
            held.attributes[name] = {key: _plain_attribute(value) for key, value in given}
            if data.dtype.kind == "S" and data.ndim:
                rows = data.reshape(-1, data.shape[-1])
                held.texts[name] = [_text(b"".join(row.tolist())) for row in rows[:MOST_COLUMNS]]
            elif data.dtype.kind in "biuf":
                held.arrays[name] = data.astype(data.dtype.newbyteorder("="))
                held.scales[name] = [str(dimension) for dimension in one.dimensions]
    return held


def _plain_attribute(value: Any) -> Any:
    if isinstance(value, bytes | str):
        return _text(value)
    return float(np.asarray(value).reshape(-1)[0]) if np.size(value) == 1 else None


def _columns(held: _Held) -> Columns:
    """Columns by the structure of the file."""
    axes = {name: axis for name in held.arrays if (axis := _sample_axis(held, name)) is not None}
    labels = {name: texts for name in held.arrays if (texts := _labels(held, name, axes.get(name)))}
    columns = of_named_arrays(held.arrays, axes, labels)
    for name in columns.values:
        source = _source(name, held, labels)
        attributes = held.attributes.get(source, {})
        if unit := _unit(attributes, name, source):
            columns.units[name] = unit
        _add_rate(columns, name, attributes)
    for place, attributes in held.attributes.items():
        for key, value in attributes.items():
            if isinstance(value, float) and np.isfinite(value) and place not in held.arrays:
                columns.scalars.setdefault(f"{place}/{key}".lstrip("/"), value)
    return columns


def _source(name: str, held: _Held, labels: Mapping[str, list[str]]) -> str:
    """Array that a column comes from."""
    if name in held.arrays:
        return name
    for array, texts in labels.items():
        if name in texts:
            return array
    return re.sub(r"\[[\d,]+\]$", "", name)


def _unit(attributes: Mapping[str, Any], name: str, source: str) -> str:
    for key, value in attributes.items():
        if key.lower() not in UNITS:
            continue
        if isinstance(value, str):
            return value.partition(" since ")[0]
        number = re.fullmatch(r".*\[(\d+)\]", name)
        if isinstance(value, list) and number and name.startswith(source) and int(number[1]) <= len(value):
            return str(value[int(number[1]) - 1])
    return ""


def _add_rate(columns: Columns, name: str, attributes: Mapping[str, Any]) -> None:
    """Add the rate that the attributes of an array give."""
    seen: list[RateSeen] = []
    default = ""
    for key, value in attributes.items():
        if not isinstance(value, float) or not np.isfinite(value) or value <= 0.0:
            continue
        if RATES.fullmatch(key):
            seen.append(RateSeen(value, 0.0, f"its attribute {key}"))
        elif STEPS.fullmatch(key):
            default = key if is_default(value) else default
            seen += [] if is_default(value) else [of_step(value, f"its attribute {key}")]
    add_rate(columns, name, seen, default)


def _sample_axis(held: _Held, name: str) -> int | None:
    """Axis whose scale holds times or frequencies, in the squeezed array; None where no scale tells."""
    shape, scales = held.arrays[name].shape, held.scales.get(name, [])
    long = [axis for axis, length in enumerate(shape) if length > 1]
    found = [place for place, axis in enumerate(long) if axis < len(scales) and _along(held, scales[axis])]
    return found[0] if len(found) == 1 and len(long) > 1 else None


def _along(held: _Held, scale: str) -> bool:
    """Whether a dimension scale is one of times or frequencies, by its unit or its name."""
    unit = plain_unit(_unit(held.attributes.get(scale, {}), scale, scale))
    return bool(scale) and (unit in TIMES or unit in FREQUENCIES or bool(AXIS.search(scale.rpartition("/")[2])))


def _labels(held: _Held, name: str, axis: int | None) -> list[str]:
    """Names of the channels of an array with two axes, from the scale of texts along the other one."""
    scales = held.scales.get(name, [])
    if axis is None or len(scales) != 2 or held.arrays[name].ndim != 2:
        return []
    texts = held.texts.get(scales[1 - axis], [])
    return texts if len(texts) == held.arrays[name].shape[1 - axis] and len(set(texts)) == len(texts) else []


def _tables(held: _Held) -> list[str]:
    """Places of groups that hold texts, with the sign that ends them."""
    return list(dict.fromkeys(name.rpartition("/")[0] + "/" for name in held.texts if "/" in name))


def _of_rattlesnake(held: _Held, table: str) -> Columns:
    """Columns of Rattlesnake: signals in the units of its table of channels, by node, direction and comment."""
    nodes, directions = (held.texts[f"{table}{key}"] for key in TABLE)
    units = held.texts.get(f"{table}unit", [""] * len(nodes))
    comments = held.texts.get(f"{table}comment", [""] * len(nodes))
    streams = {name: one for name, one in held.arrays.items() if SIGNALS.fullmatch(name) and one.ndim == 2}
    fitting = {
        name: one for name, one in streams.items() if one.shape[0] == len(nodes) == len(units) == len(comments)
    }
    rate = held.attributes.get("", {}).get("sample_rate")
    if not fitting or len(nodes) != len(directions):
        raise ValueError(
            f"a table of {len(nodes)} channels, and no time_data of as many; record or export it again"
        )
    named: dict[str, int] = {}
    for number, (node, direction, comment) in enumerate(zip(nodes, directions, comments, strict=True)):
        once = comment and comments.count(comment) == 1
        named[unused_name(comment if once else f"{node}{direction}" or str(number + 1), named)] = number
    values: dict[str, NDArray[Any]] = {}
    channels: dict[str, str] = {}
    described: list[tuple[str, int]] = []
    for stream, one in fitting.items():
        for own, number in named.items():
            name = own if len(fitting) == 1 else f"{stream}/{own}"
            if len(fitting) > 1:
                channels[name] = own
            values[name] = np.asarray(one[number], dtype=float)
            described.append((name, number))
    columns = Columns(values, channels=channels)
    for name, number in described:
        if is_unit(units[number]):
            columns.units[name] = units[number]
        if place := _place(nodes[number], directions[number]):
            columns.places[name] = place
        if isinstance(rate, float) and np.isfinite(rate) and rate > 0.0:
            columns.rates[name] = rate
    return columns


def _place(node: str, direction: str) -> str:
    """Node and direction as in declarations: ``101`` and ``Z-`` are ``101:-z``; empty for rotations."""
    number = "".join(sign for sign in node if sign.isdigit())
    found = re.fullmatch(r"([+-]?)([XYZxyz])([+-]?)", direction.strip())
    if not found or not number or not 0 < int(number) < 10_000_000:
        return ""
    return f"{int(number)}:{'-' if '-' in (found[1], found[3]) else '+'}{found[2].lower()}"
