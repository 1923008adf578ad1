"""Settings in a TOML file, checked strictly against their model; errors name the keys of the file."""

import json
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
from app.files.drawings.drawing import DrawingError, with_drawings
from app.files.drawings.mesh_check import mesh_fault
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
        problems = dict.fromkeys(_problem(path.name, model, detail) for detail in wrong)
        raise CampaignFileError(path.parent, [*problems], misplaced(path, table, details)) from error
    fault = mesh_fault(path, table, made)
    if fault is not None:
        key, seen, place = fault
        raise CampaignFileError(path.parent, [Problem(path.name, key, seen, "")], place)
    return made


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
