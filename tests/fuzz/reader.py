"""How one kind of file is read."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np

from app.files.campaign_error import CampaignFileError, Problem

Damage = Callable[[bytes, np.random.Generator], bytes]


@dataclass(frozen=True)
class Reader:
    """How a kind of file is read.

    Attributes
    ----------
    name : str
    files : tuple of str
        Those that are damaged, one at a time; relative to the folder of all.
    read : callable
        Given that folder and the file, returns what was read.
    share : float
        Of all mutations.
    text : bool
    digest : bool
        Whether any change of a byte has to be noticed, or to change nothing that is read.
    damage : callable, optional
        Given the file's bytes and random numbers, returns damaged ones; else `tests.fuzz.mutations.mutated`.
    """

    name: str
    files: tuple[str, ...]
    read: Callable[[Path, str], object]
    share: float
    text: bool = False
    digest: bool = False
    damage: Damage | None = None


def refused(root: Path, problems: Sequence[Problem | None]) -> NoReturn:
    """Raise what the reader of a whole campaign raises for one file's problems."""
    raise CampaignFileError(root, [problem for problem in problems if problem is not None])
