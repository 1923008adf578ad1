"""A finished sweep of a campaign that may still be recorded, with the SHA-256 of exactly what was read."""

from dataclasses import dataclass
from pathlib import Path

from analysis.campaign import Sweep
from app.files.campaign_error import Problem
from app.files.provenance import sha256
from app.files.sweep_file import read_sweep_file


@dataclass(frozen=True)
class FileMark:
    """By what a file is known to be the one that was read a moment ago.

    Attributes
    ----------
    inode, size : int
    changed : int
        Time of the last change, ns.
    """

    inode: int
    size: int
    changed: int

    @classmethod
    def of(cls, path: Path) -> "FileMark | None":
        """Take it of a file; None where there is none, or none that can be read."""
        try:
            found = path.stat()
        except OSError:
            return None
        return cls(found.st_ino, found.st_size, found.st_mtime_ns)


def read_finished_sweep(path: Path, name: str) -> tuple[Sweep, str] | Problem:
    """Read a sweep and the SHA-256 of its file, which must be the same file for both.

    A finished file is never written again, but people move and replace files: a hash of another file than the one
    that was read would vouch for samples that no result was made from.

    Parameters
    ----------
    name : str
        What a problem calls the file.

    Returns
    -------
    (Sweep, str) or Problem
    """
    before = FileMark.of(path)
    sweep, wrong = read_sweep_file(path, name)
    try:
        digest = sha256(path)
    except OSError:
        return changed(name)
    if before != FileMark.of(path):
        return changed(name)
    return wrong or changed(name) if sweep is None else (sweep, digest)


def changed(name: str) -> Problem:
    """Say that a file is not the one it was when reading began."""
    return Problem(
        name, "", "changed while it was read", "files that nobody moves or replaces", "do the same again"
    )
