"""TOML files of a focusing panel and of its surroundings over time: checked strictly; errors name the keys."""

import json
from pathlib import Path

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from analysis.focusing.panel import Panel
from analysis.weather.declared_weather import Weather
from app.files.allowed_values import allowed_at, key_at, keys_at, nearest, unit_hint
from app.files.bad_file import Misplaced, ResultFileError, misplaced
from app.files.campaign_error import CampaignFileError
from app.files.drawings.drawing import DrawingError, mesh_fault, with_drawings
from app.files.settings_toml import of_another_kind, read_settings, read_table
from app.files.shipped import shipped

SECTION_2 = shipped("section2-panel.toml")
"""The paper's plate of section 2, which comes with the project."""


def read_panel(path: Path) -> Panel:
    """Read a panel; ResultFileError with every missing, unknown, mistyped or implausible key."""
    try:
        table = read_table(path)
        declared = with_drawings(path.parent, table)
    except CampaignFileError as error:
        raise ResultFileError(str(error)) from error
    except DrawingError as error:
        places = error.fault.places if error.fault else ()
        wrong = Misplaced(path, table, places, tuple(error.curves)) if error.curves else None
        raise ResultFileError(f"{path}: {error.key}: {error}", wrong) from error
    panel = _checked(json.dumps(declared, default=str), str(path), path)
    fault = None if path == SECTION_2 else mesh_fault(path, declared, panel)
    if fault is not None:
        key, seen, place = fault
        raise ResultFileError(f"{path}: {key}: {seen}", place)
    return panel


def panel_of_text(text: str, origin: str) -> Panel:
    """Read a panel kept as JSON in a result file named `origin`."""
    return _checked(text, origin)


def _checked(text: str, origin: str, source: Path | None = None) -> Panel:
    try:  # strict JSON takes lists for tuples but no "0.24" for 0.24
        return Panel.model_validate_json(text, strict=True)
    except ValidationError as error:
        details = error.errors(include_url=False)
        wrong = None if source is None else misplaced(source, json.loads(text), details)
        other = [detail for detail in details if of_another_kind(detail)]
        lines = list(dict.fromkeys(_sentence(detail) for detail in other or details))
        lines = [f"{line}; flexura new panel writes one" for line in lines] if other else lines
        message = lines[0] if len(lines) == 1 else f"{len(lines)} problems" + "".join(f"\n  {x}" for x in lines)
        raise ResultFileError(f"{origin}: {message}", wrong) from error


def _sentence(detail: ErrorDetails) -> str:
    place, seen = detail["loc"], repr(detail["input"])
    key = key_at(Panel, place) or "panel"
    allowed = allowed_at(Panel, place)
    if detail["type"] in ("union_tag_invalid", "union_tag_not_found"):
        tag = detail.get("ctx", {}).get("tag")
        message = "is missing" if tag is None else f"= {tag!r}"
        return f"{key}.kind {message}; allowed: {allowed_at(Panel, (*place, 'kind'))}"
    if detail["type"] == "missing":
        return f"{key} is missing; allowed: {allowed}"
    if detail["type"] == "extra_forbidden":
        known = keys_at(Panel, place[:-1])
        return f"{key} is not known; the keys here are {', '.join(known)}{_hinted(nearest(str(place[-1]), known))}"
    if detail["type"] == "value_error":  # a check over several keys says itself what it saw and allows
        return f"{key}: {detail['ctx']['error']}"
    hint = _hinted(unit_hint(detail["input"], detail, allowed))
    return f"{key} = {seen if len(seen) <= 60 else seen[:57] + '...'}; allowed: {allowed}{hint}"


def _hinted(hint: str) -> str:
    return f" ({hint})" if hint else ""


def read_weather(path: Path) -> Weather:
    """Read a weather; CampaignFileError with every missing, unknown, mistyped or implausible key."""
    return read_settings(path, Weather)
