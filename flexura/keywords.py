"""What the library says names what was typed: keywords of a function, where a verb names its options.

What a function raises and the notes of what it returns pass here, as what a verb raises passes
`app.commands.bad_input`.
"""

import functools
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from inspect import signature
from typing import Any, ParamSpec, TypeVar, cast

from app.summaries.keywords import in_keywords
from flexura.argument_kinds import checked_arguments

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
