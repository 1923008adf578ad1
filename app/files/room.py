"""Whether the disk has room for what is going to be written, and memory for work, asked before hours of it."""

import shutil
from collections.abc import Iterable
from pathlib import Path

from app.files.bad_file import ResultFileError
from app.files.unwritten import megabytes

RESULTS = 5e6
"""Bytes of a verb's results, roughly: of the example of 12 sweeps ``frf.h5`` is 1.8 MB, ``report.html`` 1.9 MB."""


def require_room(folder: Path, needed: float, option: str) -> None:
    """Look whether the disk of a folder, there or not, has as much room as is needed.

    Parameters
    ----------
    needed : float
        Bytes.
    option : str
        That names another folder.

    Raises
    ------
    ResultFileError
        Where it has less.
    """
    there = next(parent for parent in (folder, *folder.resolve().parents) if parent.exists())
    free = shutil.disk_usage(there).free
    if free < needed:
        raise ResultFileError(
            f"{folder}: {megabytes(free)} are free on its disk, about {megabytes(needed)} are needed; make room "
            f"there, or name another folder with {option}"
        )


def room_of(campaign: Path) -> float:
    """Return roughly how many bytes the FRFs, modes and laws of a campaign take: a third of its samples."""
    return RESULTS + bytes_of((campaign,)) / 2.0


def bytes_of(paths: Iterable[Path]) -> int:
    """Return how much files, and folders with all that is in them, take together, bytes."""
    found = 0
    for path in paths:
        inside = path.rglob("*") if path.is_dir() else (path,)
        found += sum(one.stat().st_size for one in inside if one.is_file())
    return found


def memory_left() -> float:
    """Bytes of memory that can be used without swapping; infinity where the system does not say."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024.0 * float(next(line.split()[1] for line in lines if line.startswith("MemAvailable:")))
    except (OSError, StopIteration, ValueError):
        return float("inf")
