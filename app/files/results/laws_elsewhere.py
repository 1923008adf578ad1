"""Filters in a folder of their own, named with ``--out``, know where the laws are that they were made from.

``laws.json`` holds one path, relative to its folder: ``laws``, a run folder or a file of laws, or ``twin``, a twin
file. Whether these are still the laws that the filters were made from, their SHA-256 in ``filters.h5`` says.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from app.files.atomic import write_json
from app.files.bad_file import ResultFileError, quoted
from app.files.parsed_text import parse_json, read_text

POINTER, OWN = "laws.json", "laws.h5"


@dataclass(frozen=True)
class LawsElsewhere:
    """Where laws are: one of both.

    Attributes
    ----------
    laws : Path or None
        Run folder, or file of laws.
    twin : Path or None
        Twin file.
    """

    laws: Path | None = None
    twin: Path | None = None


def remember_laws(folder: Path, laws: Path, *, kind: Literal["run", "file", "twin"]) -> None:
    """Write where the laws are that results in a folder were made from, unless it is the run folder itself.

    Parameters
    ----------
    folder : Path
        Of the results.
    laws : Path
        File that they were read from.
    kind : str
        ``run``: the folder of that file, with its best twin; ``file``: that file alone; ``twin``: a twin file.
    """
    if (folder / OWN).is_file() or folder.resolve() == laws.resolve().parent:
        return
    target = laws.resolve().parent if kind == "run" else laws.resolve()
    try:
        there = os.path.relpath(target, folder.resolve())
    except ValueError:  # on another drive
        there = str(target)
    write_json(folder / POINTER, {"twin" if kind == "twin" else "laws": Path(there).as_posix()})


def laws_elsewhere(folder: Path) -> LawsElsewhere | None:
    """Return where the laws of a folder are; None where it has its own, or does not say.

    Raises
    ------
    ResultFileError
        Where nothing is at that place, or ``laws.json`` is damaged.
    """
    file = folder / POINTER
    if (folder / OWN).is_file() or not file.is_file():
        return None
    again = f"make the filters again: flexura focus, with the run folder of the laws and --out {quoted(folder)}"
    try:
        (key, there), *more = parse_json(read_text(file)).items()
        found = folder / there
        known = found.exists()
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise ResultFileError(f"{file}: does not say where the laws are ({error}); {again}") from error
    if more or key not in ("laws", "twin"):
        raise ResultFileError(f"{file}: key {key!r}; allowed: one of laws and twin; {again}")
    if not known:
        raise ResultFileError(
            f"{file}: {key} = {there!r}: nothing is there any more; correct the path, or {again}"
        )
    return LawsElsewhere(**{key: found})
