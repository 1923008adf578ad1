"""Settings in a TOML file, checked strictly against their model; errors name the keys of the file.

Tables of settings written as TOML that people read: short tables on one line, lists of tables as such.
"""

import json
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from analysis.declaration.tolerances import without_tolerances
from app.files.allowed_values import allowed_at, key_at, keys_at, nearest, unit_hint
from app.files.bad_file import Misplaced, misplaced
from app.files.campaign_error import CampaignFileError, Problem
from app.files.drawings.drawing import DrawingError, mesh_fault, with_drawings
from app.files.parsed_text import parse_toml, read_text

Model = TypeVar("Model", bound=BaseModel)


def read_settings(path: Path, model: type[Model]) -> Model:
    """Read the settings in a file.

    Raises
    ------
    CampaignFileError
        With every missing, unknown, mistyped or implausible key.
    """
    return checked(path, read_table(path), model)


def read_table(path: Path) -> dict[str, Any]:
    """Read a file's keys and values unchecked; CampaignFileError where it is no TOML."""
    text = _text(path)
    try:
        return parse_toml(text)
    except tomllib.TOMLDecodeError as error:
        raise CampaignFileError(path.parent, [_syntax(path.name, text, error)]) from error
    except ValueError as error:  # integers of thousands of digits, brackets in brackets
        problem = Problem(path.name, "", f"cannot be parsed ({error})", "TOML of plain tables")
        raise CampaignFileError(path.parent, [problem]) from error


def checked(path: Path, table: Mapping[str, Any], model: type[Model]) -> Model:
    """Hold what `read_table` read against a model, drawings turned into curves.

    Parameters
    ----------
    path : Path
        The file; drawings are named relative to its folder.
    table : mapping
        Its keys and values, unchecked.
    model : type of pydantic.BaseModel

    Raises
    ------
    CampaignFileError
        As `read_settings`, and for drawings and meshes that cannot be used.
    """
    try:
        table = with_drawings(path.parent, table)
    except DrawingError as error:
        places = error.fault.places if error.fault else ()
        wrong_drawing = Misplaced(path, table, places, tuple(error.curves)) if error.curves else None
        problem = Problem(path.name, error.key, str(error), "")
        raise CampaignFileError(path.parent, [problem], wrong_drawing) from error
    if "tolerances" in model.model_fields:
        try:
            table = without_tolerances(table)
        except ValueError as error:
            raise CampaignFileError(path.parent, [Problem(path.name, "tolerance", str(error), "")]) from error
    try:  # through JSON, where pydantic's strict reading takes lists for tuples but no "0.24" for 0.24
        made = model.model_validate_json(json.dumps(table, default=str), strict=True)
    except ValidationError as error:
        details = error.errors(include_url=False)
        wrong = [detail for detail in details if not _follows_from_another(detail, details)]
        wrong = [detail for detail in wrong if of_another_kind(detail)] or wrong
        problems = dict.fromkeys(_problem(path.name, model, detail) for detail in wrong)
        raise CampaignFileError(path.parent, [*problems], misplaced(path, table, details)) from error
    fault = mesh_fault(path, table, made)
    if fault is not None:
        key, seen, place = fault
        raise CampaignFileError(path.parent, [Problem(path.name, key, seen, "")], place)
    return made


def of_another_kind(detail: Any) -> bool:
    """Whether a file says that it declares something else, a campaign for a panel: other keys differ by that."""
    said, wanted = detail["input"], str(detail.get("ctx", {}).get("expected", "")).strip("'")
    named = detail["loc"] == ("format",) and isinstance(said, str) and "/" in wanted
    return named and said.partition("/")[0] != wanted.partition("/")[0]


def _text(path: Path) -> str:
    folder, name = path.parent, path.name
    try:
        return read_text(path)
    except UnicodeDecodeError as error:
        seen = f"byte {error.start} is not {error.encoding.upper()}"
        remedy = "save it as UTF-8 in the editor"
        raise CampaignFileError(folder, [Problem(name, "", seen, "TOML, which is UTF-8", remedy)]) from error
    except ValueError as error:
        raise CampaignFileError(folder, [Problem(name, "", str(error), "")]) from error
    except OSError as error:
        seen = f"cannot be read: {error.strerror}"
        raise CampaignFileError(folder, [Problem(name, "", seen, "a readable file")]) from error


def _syntax(name: str, text: str, error: tomllib.TOMLDecodeError) -> Problem:
    place = re.search(r"at line (\d+)", str(error))
    lines = text.splitlines()
    number = int(place[1]) if place else max(len(lines), 1)
    line = lines[number - 1].strip() if number <= len(lines) else ""
    comma = re.match(r"[\w.\"'-]+\s*=\s*([+-]?\d+),(\d+)\s*(?:#|$)", line)
    empty = re.search(r"immutable namespace \('([\w-]+)',\)", str(error))
    hint = f"write {comma[1]}.{comma[2]}, with a decimal point" if comma else str(error)
    if empty:  # as a written twin file has it where there is nothing of a kind
        hint = f"{empty[1]} = ... stands above: remove that line"
    return Problem(name, f"line {number}", _shown(line), "TOML", hint)


def _follows_from_another(detail: ErrorDetails, details: Sequence[ErrorDetails]) -> bool:
    """Whether a list is called too short only because one of its items was refused."""
    place = detail["loc"]
    return detail["type"] == "too_short" and any(
        len(other["loc"]) > len(place) and other["loc"][: len(place)] == place for other in details
    )


def _problem(name: str, model: type[BaseModel], detail: ErrorDetails) -> Problem:
    place, kind, seen = detail["loc"], detail["type"], detail["input"]
    key = key_at(model, place)
    allowed = allowed_at(model, place)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        tag = detail.get("ctx", {}).get("tag")
        choices = allowed_at(model, (*place, "kind"))
        seen, why = ("nothing", "the key is missing; ") if tag is None else (_shown(tag), "")
        return Problem(name, f"{key}.kind", str(seen), choices, f"{why}a file is kind 'drawing'")
    if kind == "missing":
        return Problem(name, key, "nothing", allowed, "the key is missing")
    if kind == "extra_forbidden":
        known = keys_at(model, place[:-1])
        remedy = nearest(str(place[-1]), known) or "remove it"
        return Problem(name, key, "unknown key", "the keys " + ", ".join(known), remedy)
    if kind == "value_error":  # a check over several keys: it says itself what it saw and allows
        return Problem(name, key, str(detail["ctx"]["error"]), "")
    if kind == "literal_error" and isinstance(seen, str):
        words = re.findall(r"'([^']+)'", allowed)
        return Problem(name, key, _shown(seen), allowed, nearest(seen.lower(), words) if len(words) > 1 else "")
    return Problem(name, key, _shown(seen), allowed, unit_hint(seen, detail, allowed))


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


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
