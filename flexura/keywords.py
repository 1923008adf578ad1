"""What the library says names what was typed: keywords of a function, where a verb names its options.

Arguments are of the kind that their annotation says, before anything is computed: ``mains="50"`` would otherwise
end in the middle of a computation, in an error that names no keyword. What a function raises and the notes of what
it returns pass here, as what a verb raises passes `app.commands.bad_input`.
"""

import functools
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from difflib import get_close_matches
from functools import cache, partial
from inspect import BoundArguments, signature
from os import PathLike
from typing import Any, Literal, ParamSpec, TypeVar, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from app.files.bad_file import UnsuitedOptionError
from app.summaries.keywords import in_keywords

SHOWN = 60
"""Letters of a value that a message shows."""
WORDS: Mapping[str, str] = {
    "float": "a number",
    "int": "an integer",
    "bool": "True or False",
    "str": "a text",
    "NoneType": "None",
    "Campaign": "a campaign, as flexura.load(folder) gives it",
    "FrfCampaign": "a campaign, as flexura.load(folder) gives it",
    "Updating": "what flexura.update or flexura.gap returned",
    "GapComparison": "what flexura.update or flexura.gap returned",
    "FrfSet": "what flexura.frfs_of_test returned",
    "ForwardTwin": "what flexura.twin returned",
}
"""What a class is called in messages; others by their own name."""
HINTS: Mapping[str, str] = {
    "Frf": "an Frf does not know its plate: give frf.on(experiment), where flexura.load(folder).experiment "
    "declares the plate and its transducers",
}
"""What to do with a value of a class that is often given where it is not taken."""
NUMBERS: Mapping[type, tuple[type, ...]] = {
    int: (int, np.integer),
    float: (int, float, np.integer, np.floating),
    bool: (bool, np.bool_),
}
"""What is taken for a number of a kind; True is none, though Python counts with it."""


class ArgumentKindError(UnsuitedOptionError, TypeError):
    """An argument is of a kind that the function does not take: keyword, value and what is allowed."""


class _UnfitError(Exception):
    """A value is not of a kind."""


def checked_arguments(
    function: Callable[..., Any], args: Sequence[Any], options: Mapping[str, Any]
) -> BoundArguments:
    """Return the arguments of a call, numpy's scalars as Python's own.

    Raises
    ------
    ArgumentKindError
        For one of another kind than its annotation, one that is missing, and a keyword that does not exist.
    """
    known = signature(function)
    unknown = [name for name in options if name not in known.parameters]
    if unknown:
        close = get_close_matches(unknown[0], known.parameters, 1)
        meant = f"did you mean {close[0]}? " if close else ""
        raise ArgumentKindError(
            f"{function.__name__} has no keyword {unknown[0]!r}; {meant}allowed: {', '.join(known.parameters)}"
        )
    try:
        bound = known.bind(*args, **options)
    except TypeError as error:
        raise ArgumentKindError(f"{function.__name__}: {error}; it takes {', '.join(known.parameters)}") from error
    kinds = _kinds(function)
    for name, value in bound.arguments.items():
        try:
            bound.arguments[name] = _taken(kinds.get(name, Any), value)
        except _UnfitError as error:
            allowed = " or ".join(dict.fromkeys(wanted(kinds[name])))
            raise ArgumentKindError(_refusal(name, value, allowed)) from error
    return bound


def _refusal(keyword: str, value: object, allowed: str) -> str:
    """Say keyword, value seen and what is allowed, and what to write instead where it can be known."""
    kind, shown = type(value), repr(value)
    if len(shown) > SHOWN or "\n" in shown:
        shown = f"of type {kind.__name__}"
    hint = HINTS.get(kind.__name__, "")
    if isinstance(value, str) and allowed.startswith("a number"):
        with suppress(ValueError):
            hint = f"write {float(value.replace(',', '.')):g}, without quotation marks"
    elif isinstance(value, float) and not np.isfinite(value):
        hint = "it must be finite"
    elif kind.__module__.startswith("app.stages") and "a path" in allowed:
        hint = "write it with out=FOLDER, and name that folder"
    return f"{keyword} {shown}: allowed is {allowed}" + (f"; {hint}" if hint else "")


@cache
def _kinds(function: Callable[..., Any]) -> Mapping[str, Any]:
    return {name: kind for name, kind in get_type_hints(function).items() if name != "return"}


def wanted(kind: Any) -> list[str]:
    """Say in words what a kind takes, each possibility one."""
    origin, inside = get_origin(kind), get_args(kind)
    if kind == ArrayLike:
        return ["finite numbers"]
    if kind == Mapping[str, Mapping[str, float]]:
        return ['values by effect and parameter, {"point_mass": {"mass": 1e-3}}']
    if origin in (Union, types.UnionType):
        paths = any(_is_path(one) for one in inside)
        return [word for one in inside if not (paths and one is str) for word in wanted(one)]
    if origin is Literal:
        return [repr(one) for one in inside]
    if _is_path(kind):
        return ["a path (str or pathlib.Path)"]
    parts = [" or ".join(dict.fromkeys(wanted(one))) for one in inside]
    if origin is tuple:
        return [f"({', '.join(parts)})"]
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return [f"a dict of {parts[0]} to {parts[1]}"]
    if isinstance(origin, type):
        return [f"a list: each {parts[0]}"]
    name = getattr(kind, "__name__", "anything")
    return ["anything" if kind is Any else WORDS.get(name, name)]


def _is_path(kind: Any) -> bool:
    return kind is PathLike or get_origin(kind) is PathLike


def _taken(kind: Any, value: Any) -> Any:
    """Return a value as a kind takes it; `_UnfitError` for one of another kind."""
    origin, inside = get_origin(kind), get_args(kind)
    if isinstance(value, np.ndarray) and not value.ndim:
        value = value[()]
    if kind is Any:
        return value
    if kind == ArrayLike:
        return _array(value)
    if origin in (Union, types.UnionType):
        return _first_taken(inside, value)
    if _is_path(kind):
        return _path(value)
    if origin is Literal:
        return _single(str, value)  # which words there are is said where they are used
    if origin is tuple:
        return _record(inside, _several(value))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise _UnfitError
        within = _number if inside[1] is float else partial(_taken, inside[1])  # its ranges tell NaN by its key
        return {_taken(inside[0], key): within(one) for key, one in value.items()}
    if isinstance(origin, type):
        return tuple(_taken(inside[0], one) for one in _several(value))
    return _single(kind, value)


def _first_taken(kinds: Sequence[Any], value: Any) -> Any:
    if isinstance(value, str) and any(_is_path(one) for one in kinds):
        return _path(value)
    for one in kinds:
        with suppress(_UnfitError):
            return _taken(one, value)
    raise _UnfitError


def _path(value: Any) -> Any:
    """Return a path; an empty one would be the current folder, and none holds a NUL."""
    if not isinstance(value, str | PathLike) or (isinstance(value, str) and (not value or "\0" in value)):
        raise _UnfitError
    return value


def _record(kinds: Sequence[Any], values: Sequence[Any]) -> tuple[Any, ...]:
    """Return a value for each kind; of numbers any count passes: what they are is said where they are used."""
    if len(kinds) != len(values):
        if set(kinds) != {float}:
            raise _UnfitError
        kinds = (float,) * len(values)
    return tuple(_taken(kind, one) for kind, one in zip(kinds, values, strict=True))


def _several(value: Any) -> list[Any]:
    if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
        raise _UnfitError
    return list(value)


def _array(value: Any) -> Any:
    try:
        found = np.asarray(value)
    except ValueError as error:
        raise _UnfitError from error
    if found.dtype.kind not in "iuf" or not np.isfinite(found).all():
        raise _UnfitError
    return value


def _number(value: Any, kind: type = float) -> Any:
    if (isinstance(value, bool | np.bool_) and kind is not bool) or not isinstance(value, NUMBERS[kind]):
        raise _UnfitError
    return kind(value)


def _single(kind: type, value: Any) -> Any:
    if kind in NUMBERS:
        found = _number(value, kind)
        if not np.isfinite(found):
            raise _UnfitError
        return found
    if not isinstance(value, kind):
        raise _UnfitError
    return value


Words = ParamSpec("Words")
Result = TypeVar("Result")

NOTED = ("frf", "frfs", "tracked", "report")
"""Fields of results that hold notes of their own."""


def keyworded(function: Callable[Words, Result]) -> Callable[Words, Result]:
    """Let a function refuse arguments of another kind, and its errors and notes name its keywords.

    Errors stay the same ones, with their class and what they hold.
    """
    keywords = tuple(signature(function).parameters)

    @functools.wraps(function)
    def called(*args: Words.args, **options: Words.kwargs) -> Result:
        try:
            given = checked_arguments(function, args, options)
            return cast("Result", _noted(function(*given.args, **given.kwargs)))
        except (ValueError, TypeError) as error:
            if error.args and isinstance(error.args[0], str):
                error.args = (in_keywords(error.args[0], keywords), *error.args[1:])
            raise

    return called


def _noted(found: Any, deeper: tuple[str, ...] = NOTED) -> Any:
    """Return a result whose notes name keywords; the same one where they do already."""
    if not is_dataclass(found) or isinstance(found, type):
        return found
    held = {field.name: getattr(found, field.name) for field in fields(found) if field.init}
    said = {name: _noted(held[name], ()) for name in deeper if name in held}
    if isinstance(held.get("notes"), tuple):
        said["notes"] = tuple(in_keywords(note) for note in held["notes"])
    changed = {name: value for name, value in said.items() if value is not held[name] and name != "notes"}
    if said.get("notes", ()) != held.get("notes", ()):
        changed["notes"] = said["notes"]
    return replace(found, **changed) if changed else found
