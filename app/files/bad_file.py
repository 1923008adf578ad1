"""What goes wrong with a file of results, and how a message writes the command that mends it."""

import os
import re
import shlex
import subprocess
from pathlib import Path

from app.files.misplaced import Misplaced


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
