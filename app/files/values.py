"""Frozen values as groups of an HDF5 file: one rule for every dataclass of arrays.

Arrays and tuples of numbers become datasets, numbers and strings attributes, tuples of strings a JSON
attribute, dataclasses sub-groups, tuples of dataclasses numbered sub-groups. Reading goes by the type hints and
makes the value anew, so that its own checks run; nothing in the file decides what is built.
"""

import json
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from app.files.parsed_text import parse_json

Value = TypeVar("Value")


def _row_of(hint: Any) -> Any:
    """Return the dataclass of which a type hint is a tuple; None for other hints."""
    args = get_args(hint)
    return args[0] if get_origin(hint) is tuple and args and is_dataclass(args[0]) else None


def write_value(group: h5py.Group, value: Any) -> None:
    """Write a dataclass into an empty group."""
    for field in fields(value):
        item = getattr(value, field.name)
        if item is None:
            continue  # what may be lacking has None for its default
        if is_dataclass(item):
            write_value(group.create_group(field.name), item)
        elif isinstance(item, tuple) and any(is_dataclass(part) for part in item):
            rows = group.create_group(field.name)
            for place, part in enumerate(item):
                write_value(rows.create_group(f"{place:04d}"), part)
        elif isinstance(item, np.ndarray):
            # Measured numbers lose a fifth of their size to gzip, in ten times the time; counts lose nearly all.
            packed = item.size > 4096 and item.dtype.kind not in "fc"
            group.create_dataset(
                field.name, data=item, compression="gzip" if packed else None, shuffle=packed or None
            )
        elif isinstance(item, tuple) and not all(isinstance(part, str) for part in item):
            group.create_dataset(field.name, data=np.array(item))
        elif isinstance(item, tuple):
            group.attrs[field.name] = json.dumps(item)
        else:
            group.attrs[field.name] = item


def read_value(group: h5py.Group, kind: type[Value]) -> Value:
    """Read a dataclass of type `kind`; ValueError where the group holds something else."""
    hints = get_type_hints(kind)
    parts: dict[str, Any] = {}
    for field in fields(kind):  # type: ignore[arg-type]
        optional = () if _row_of(hints[field.name]) else get_args(hints[field.name])
        wanted = next((one for one in optional if is_dataclass(one)), hints[field.name])
        if field.default is not MISSING and field.name not in group and field.name not in group.attrs:
            continue  # the file was written before there was such a field
        try:
            if is_dataclass(wanted):
                parts[field.name] = read_value(group[field.name], wanted)  # type: ignore[arg-type]
            elif (row := _row_of(hints[field.name])) is not None:
                rows = group.get(field.name, {})  # empty ones are stored as text
                parts[field.name] = tuple(read_value(rows[place], row) for place in sorted(rows))
            elif get_origin(wanted) is tuple and str in get_args(wanted):
                parts[field.name] = tuple(str(part) for part in parse_json(group.attrs[field.name]))
            elif get_origin(wanted) is tuple:
                parts[field.name] = tuple(group[field.name][()].tolist())
            elif wanted in (int, float, str, bool):
                parts[field.name] = wanted(group.attrs[field.name])
            else:
                parts[field.name] = held = group[field.name][()]
                if np.asarray(held).dtype.kind not in "biufc":
                    raise ValueError(
                        f"{group.name}: {field.name!r} is of type {np.asarray(held).dtype}; allowed: numbers"
                    )
        except (KeyError, TypeError) as error:
            raise ValueError(f"{group.name} lacks a readable {field.name!r}") from error
    try:
        return kind(**parts)
    except ValueError as error:
        raise ValueError(f"{group.name}: {error}") from error
