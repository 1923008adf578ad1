"""What goes wrong with a file of results, or with a declaration whose geometry cannot be, and where.

A picture of it is drawn from the places. How a message writes the command that mends it is here, too.
"""

import os
import re
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from analysis.geometry.loop import Curve, Point


@dataclass(frozen=True)
class Misplaced:
    """What was declared, and where it is wrong.

    Attributes
    ----------
    source : Path
        The file.
    declared : mapping
        What stands in it, unchecked.
    places : tuple of (float, float)
        Where it is wrong, m.
    loose : tuple of Curve
        Curves of a drawing that close to no outline.
    """

    source: Path
    declared: Mapping[str, Any]
    places: "tuple[Point, ...]"
    loose: "tuple[Curve, ...]" = ()


def misplaced(source: Path, declared: Mapping[str, Any], details: "Sequence[ErrorDetails]") -> Misplaced | None:
    """Gather the places that pydantic's errors name.

    Parameters
    ----------
    source : Path
        File of the declaration.
    declared : mapping
        Its keys and values.

    Returns
    -------
    Misplaced or None
        None where no geometry is wrong.
    """
    from analysis.geometry.loop import GeometryError  # --help waits for no library

    errors = [detail.get("ctx", {}).get("error") for detail in details]
    places = [place for error in errors if isinstance(error, GeometryError) for place in error.places]
    return Misplaced(source, declared, tuple(places)) if places else None


class ResultFileError(ValueError):
    """A result file is missing, of another kind, or damaged; the message says which and what to do.

    Attributes
    ----------
    misplaced : Misplaced, optional
        The geometry declared, where that is wrong.
    """

    def __init__(self, message: str, misplaced: Misplaced | None = None) -> None:
        super().__init__(message)
        self.misplaced = misplaced


class UnsuitedOptionError(ResultFileError):
    """An option does not suit the files that are there: what was typed is wrong, not a file."""


def quoted(path: Path | str) -> str:
    """Write a path as it is typed in a shell: in quotation marks where it holds spaces and the like.

    Every command in a message writes its paths with it, so that the command can be copied
    (``tests/app/test_commands_in_messages.py``).
    """
    text = str(path)
    if re.fullmatch(r"[\w@%+=:,./~-][\w@%+=:,./\\~-]*", text) and (os.name == "nt" or "\\" not in text):
        return text  # letters of any language: no shell takes them apart
    return subprocess.list2cmdline([text]) if os.name == "nt" else shlex.quote(text)
