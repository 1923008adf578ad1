"""What a settings model allows at one of its keys, in words a person can act on."""

import difflib
import types
from collections.abc import Iterable, Sequence
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

ZERO_CELSIUS = 273.15
"""0 °C in K."""


def allowed_at(model: type[BaseModel], place: Sequence[int | str]) -> str:
    """Kind, range and unit of the key at `place`: "a number from 0.0001 to 0.05 (m)".

    Parameters
    ----------
    model : type of BaseModel
        The whole file.
    place : sequence of int or str
        Keys and list positions from the top, as pydantic's errors give them.
    """
    kind = _type_at(model, place)
    bare = _bare(kind)
    if get_origin(bare) is Literal:
        return _noun(bare)
    keys = keys_at(model, place)
    if keys:
        return "a table with the keys " + ", ".join(keys)
    fields = _fields(kind)
    unit = next((f" ({field.description})" for field in fields if field.description), "")
    return f"{_noun(bare)}{_range(fields)}{unit}"


def keys_at(model: type[BaseModel], place: Sequence[int | str]) -> tuple[str, ...]:
    """Return the keys of the table at `place`; none if it is no table."""
    table = _bare(_type_at(model, place))
    return tuple(field.alias or name for name, field in table.model_fields.items()) if _is_model(table) else ()


def key_at(model: type[BaseModel], place: Sequence[int | str]) -> str:
    """Return the key at `place` as it stands in a file: "patch[0].size".

    Where there are several kinds of a table or value, pydantic's places name the kind it tried, which is no key.
    """
    parts = [
        part
        for n, part in enumerate(place)
        if isinstance(part, int) or part == "kind" or not _is_union(_bare(_type_at(model, place[:n])))
    ]
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).lstrip(".")


def _type_at(model: type[BaseModel], place: Iterable[int | str]) -> Any:
    here: Any = model
    for part in place:
        bare = _bare(here)
        if _is_union(bare) and isinstance(part, str):
            here = _member(here, bare, part)
            continue
        if isinstance(part, int):
            inside = [kind for kind in get_args(bare) if kind is not Ellipsis]
            here = inside[min(part, len(inside) - 1)] if inside else None
        elif _is_model(bare) and part in (named := _by_key(bare)):
            field = named[part]
            here = Annotated[field.annotation, field]  # pydantic takes them apart; the limits are in the field
        elif get_origin(bare) is dict:
            here = get_args(bare)[1]
        else:
            here = None
    return here


def _bare(kind: Any) -> Any:
    """Return a kind without its annotation, and without None: a TOML file leaves the key out instead."""
    bare = get_args(kind)[0] if get_origin(kind) is Annotated else kind
    if get_origin(bare) in (Union, types.UnionType):
        choices = [choice for choice in get_args(bare) if choice is not types.NoneType]
        return _bare(choices[0]) if len(choices) == 1 else bare
    return bare


def _by_key(model: type[BaseModel]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for name, field in model.model_fields.items()}


def _is_union(bare: Any) -> bool:
    return get_origin(bare) in (Union, types.UnionType)


def _member(here: Any, union: Any, part: str) -> Any:
    """Return the kind of table that `part` names; all kinds where it is "kind"; else what the union itself is."""
    kinds = {
        tag: choice
        for choice in get_args(union)
        if _is_model(choice) and "kind" in choice.model_fields
        for tag in get_args(choice.model_fields["kind"].annotation)
    }
    return Literal[tuple(kinds)] if kinds and part == "kind" else kinds.get(part, here)


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _noun(bare: Any) -> str:
    if get_origin(bare) in (Union, types.UnionType):
        choices = [choice for choice in get_args(bare) if choice is not types.NoneType]
        return " or ".join(dict.fromkeys(_noun(_bare(choice)) + _range(_fields(choice)) for choice in choices))
    if get_origin(bare) is Literal:
        return " or ".join(repr(choice) for choice in get_args(bare))
    if _is_model(bare):
        return "a table"
    if get_origin(bare) is tuple:
        inside = get_args(bare)
        count = "" if Ellipsis in inside else f"{len(inside)} "
        one = _noun(_bare(inside[0]))
        if get_origin(_bare(inside[0])) is Literal:
            return f"a list of {count}{one}"
        several = one.replace("a list", "lists", 1) if one.startswith("a list") else f"{one.split()[-1]}s"
        return f"a list of {count}{several}"
    return {float: "a number", int: "an integer", str: "a text", bool: "a boolean"}.get(bare, "a value")


def _fields(kind: Any) -> list[FieldInfo]:
    """Return the annotations of a kind that hold its limits and its unit."""
    annotated = get_origin(kind) is Annotated
    return [extra for extra in get_args(kind)[1:] if isinstance(extra, FieldInfo)] if annotated else []


def _range(fields: Sequence[FieldInfo]) -> str:
    words = ""
    for limit in (limit for field in fields for limit in field.metadata):
        match limit:
            case annotated_types.Ge(ge=low):
                words += f" from {low:g}"
            case annotated_types.Gt(gt=low):
                words += f" above {low:g}"
            case annotated_types.Le(le=high):
                words += f" to {high:g}"
            case annotated_types.Lt(lt=high):
                words += f" below {high:g}"
            case annotated_types.MinLen(min_length=few):
                words += f", at least {few}"
            case annotated_types.MaxLen(max_length=many):
                words += f", at most {many}"
    return words


def nearest(name: str, known: Iterable[str]) -> str:
    """Return "did you mean X?" for a name that is unknown, empty where none of the known ones is like it."""
    close = difflib.get_close_matches(name, list(known), 1)
    return f"did you mean {close[0]}?" if close else ""


def unit_hint(seen: object, detail: ErrorDetails, allowed: str) -> str:
    """Suggest the unit where a value would fit as thousandths (of mm, g, mV), as GPa or MPa, or as kelvins.

    Parameters
    ----------
    seen : object
        The value.
    detail : ErrorDetails
        What pydantic says of it.
    allowed : str
        Of `allowed_at`.
    """
    limits = detail.get("ctx", {})
    lowest, highest = (limits.get(one, limits.get(other)) for one, other in (("ge", "gt"), ("le", "lt")))
    if not isinstance(seen, int | float) or not allowed.endswith(")"):
        return ""
    if lowest is not None and allowed.endswith("(Pa)") and seen > 0.0:
        prefix, factor = ("GPa", 1e9) if seen < 1000.0 else ("MPa", 1e6)
        return f"values are SI: {seen:g} {prefix} are {factor * seen:g}"
    if highest is None:
        return ""
    if allowed.endswith("(degrees Celsius)"):
        return f"{seen:g} K are {seen - ZERO_CELSIUS:.5g} °C" if highest < seen <= highest + ZERO_CELSIUS else ""
    return (
        f"values are SI: {seen:g} thousandths are {seen / 1000.0:g}" if highest < seen <= 1000.0 * highest else ""
    )
