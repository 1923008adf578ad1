"""Tables of settings written as TOML that people read: short tables on one line, lists of tables as such."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

LINE_WIDTH = 110
"""Characters up to which a list or a table stays on one line."""


def toml_text(table: Mapping[str, Any], comment: str = "") -> str:
    """Write `table` as TOML, keys whose value is None left out; each line of `comment` stands before it.

    ValueError for numbers that are not finite and for what TOML cannot hold.
    """
    head = [f"# {line}".rstrip() for line in comment.splitlines()]
    return "\n".join([*head, *([""] if head else []), *_table(table, ())]).rstrip() + "\n"


def _table(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    given = {key: value for key, value in table.items() if value is not None}
    plain = {key: value for key, value in given.items() if not _has_heading(value, top=not path)}
    lines = [f"{_key(key)} = {_value(value)}" for key, value in plain.items()]
    for key, value in given.items():
        if key in plain:
            continue
        here = (*path, key)
        name = ".".join(_key(part) for part in here)
        for entry in [value] if isinstance(value, Mapping) else value:
            heading = f"[{name}]" if isinstance(value, Mapping) else f"[[{name}]]"
            lines += ["", heading, *_table(entry, here)]
    return lines


def _has_heading(value: Any, top: bool) -> bool:
    """Whether a value is a table (or a list of tables) with a heading of its own instead of standing in a line."""
    if isinstance(value, Mapping):
        if top:
            return True
        nested = any(isinstance(item, Mapping | list | tuple) for item in value.values())
        return nested or len(_value(value)) > LINE_WIDTH or not value
    return isinstance(value, list | tuple) and any(isinstance(item, Mapping) for item in value)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} cannot be written: numbers must be finite")
        return repr(value)
    if isinstance(value, Mapping):
        inside = ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items() if v is not None)
        return f"{{ {inside} }}"
    if isinstance(value, Sequence):
        return _list([_value(item) for item in value])
    raise ValueError(f"a {type(value).__name__} cannot be written as TOML")


def _list(items: Sequence[str]) -> str:
    """Items in brackets, several to a line where they do not fit into one."""
    whole = ", ".join(items)
    if len(whole) <= LINE_WIDTH:
        return f"[{whole}]"
    lines, line = [], ""
    for item in items:
        if line and len(line) + len(item) > LINE_WIDTH - 6:
            lines.append(line.rstrip())
            line = ""
        line += f"{item}, "
    inside = "".join(f"    {line}\n" for line in [*lines, line.rstrip()])
    return f"[\n{inside}]"


def _key(key: str) -> str:
    bare = key.isascii() and key.replace("-", "").replace("_", "").isalnum()
    return key if bare else _value(key)
