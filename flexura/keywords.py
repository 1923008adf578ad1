"""Errors name what was typed: options where a verb was called, keywords where a function was.

The stages serve both and name options, ``--weather``. What a function of the library raises passes here, as what a
verb raises passes `app.commands.bad_input`.
"""

import functools
import re
from collections.abc import Callable, Collection, Mapping
from inspect import signature
from typing import ParamSpec, TypeVar

Words = ParamSpec("Words")
Result = TypeVar("Result")

OTHERWISE: Mapping[str, str] = {"from": "first", "until": "last", "set": "options"}
"""Keywords that are not called like their option: ``from`` is a word of Python's own."""
COMMAND = r"\b(?:flexura|start\.py|pip install) .*?(?=[;)\n]|[,.]\s|$)"
"""To be typed in a shell, as far as the next pause of the sentence."""
OPTION = r"(?<![\w-])--(?P<option>[a-z][a-z-]*)"


def in_keywords(message: str, keywords: Collection[str]) -> str:
    """Return a message with the keywords of a function in place of the options of the verb.

    Commands in it keep their options, and so do options that the function does not have.
    """

    def said(found: re.Match[str]) -> str:
        option = found["option"]
        if option is None:
            return found[0]
        keyword = OTHERWISE.get(option, option.replace("-", "_"))
        return keyword if keyword in keywords else found[0]

    return re.sub(f"{COMMAND}|{OPTION}", said, message)


def keyworded(function: Callable[Words, Result]) -> Callable[Words, Result]:
    """Let the errors of a function name its keywords: the same errors, with their class and what they hold."""
    keywords = signature(function).parameters

    @functools.wraps(function)
    def called(*args: Words.args, **options: Words.kwargs) -> Result:
        try:
            return function(*args, **options)
        except (ValueError, TypeError) as error:
            if error.args and isinstance(error.args[0], str):
                error.args = (in_keywords(error.args[0], keywords), *error.args[1:])
            raise

    return called
