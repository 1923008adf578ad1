"""Room on the disk: asked for before hours of work; and what is said of a file that could not be written.

That is which file, why, how much room is missing, and what to do. A full disk shows itself at any call: when the
file is opened, at a write, when it is forced to the disk, on a network share only when it is closed. All of them
come here.
"""

import errno
import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from app.files.bad_file import ResultFileError

FULL = frozenset({errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)})
"""The disk, the user's share of it, or the file system's largest file is used up."""
FORBIDDEN = frozenset({errno.EACCES, errno.EPERM, errno.EROFS})
SHORTER = "name a shorter one, and run it again"
OTHERS = ("EIO", "ENXIO", "ENODEV", "ESTALE", "ENAMETOOLONG", "ENOTDIR", "EISDIR", "EBUSY", "EMFILE", "ENFILE")
REFUSALS = FULL | FORBIDDEN | {getattr(errno, name) for name in OTHERS if hasattr(errno, name)}
"""What a disk, or a name on it, answers; all others are no fault of the disk's."""


class UnwrittenFileError(OSError):
    """A file could not be written; nothing of it is left, and an older file of its name stands as it was.

    An OSError with errno, strerror and filename, so that it passes from one process to another.
    """

    def __str__(self) -> str:
        """Return the sentence for people."""
        return f"{self.filename}: {self.strerror}"


@contextmanager
def unwritten(target: Path, size: int | None = None) -> Iterator[None]:
    """Turn an OSError, or too little memory, of the block that writes `target` into an UnwrittenFileError.

    Parameters
    ----------
    target : Path
        The finished file.
    size : int, optional
        Of what is written, bytes; unless given, what is missing is not known.

    Raises
    ------
    UnwrittenFileError
    """
    try:
        yield
    except UnwrittenFileError:
        raise
    except MemoryError as error:
        said = (
            "cannot be written (not enough memory to put it together); close other programs, then run this again"
        )
        raise UnwrittenFileError(errno.ENOMEM, said, str(target)) from error
    except OSError as error:
        if not _of(error, target) or (isinstance(error, FileNotFoundError) and target.parent.is_dir()):
            raise  # about another file, no answer of the system's, or a block that has written nothing
        raise UnwrittenFileError(error.errno, reason(error, target, size), str(target)) from error


def told(error: OSError) -> str | None:
    """Return the sentence about an OSError that is the disk's refusal; None for any other, which is a defect.

    Of a file that was not written by `app.files.atomic`: a folder, a log, an input that may not be read.
    """
    if isinstance(error, UnwrittenFileError):
        return str(error)
    if error.errno not in REFUSALS:
        return None
    name = "a file" if error.filename is None else os.fsdecode(error.filename)
    if error.errno in FULL:
        return f"{name}: {reason(error, Path(name))}"
    why = error.strerror or str(error)
    do = "see to its permissions and the disk, or name another, and run it again"
    return f"{name}: cannot be used ({why}); {SHORTER if error.errno == errno.ENAMETOOLONG else do}"


def reason(error: OSError, target: Path, size: int | None = None) -> str:
    """Say why a file could not be written, and what to do.

    Parameters
    ----------
    size : int, optional
        Bytes.
    """
    why = error.strerror or str(error)
    if error.errno in FULL:
        room = _room(target, size)
        return f"cannot be written ({why}{room}); make room there, or name another folder, and run it again"
    if error.errno == errno.ENAMETOOLONG:
        return f"cannot be written ({why}); {SHORTER}"
    if error.errno in FORBIDDEN:
        return f"cannot be written ({why}); name a folder that may be written, or change its permissions"
    return (
        f"cannot be written ({why}); look to the disk or the network, or name another folder, then run this again"
    )


def _of(error: OSError, target: Path) -> bool:
    """Whether an error is the system's answer about a file, its unfinished one, or a folder that holds it."""
    if error.errno is None or error.filename is None:
        return error.errno is not None
    named = Path(os.fsdecode(error.filename))
    return named in target.parents or (named.parent == target.parent and named.name.startswith(target.name))


def _room(target: Path, size: int | None) -> str:
    with suppress(OSError):
        free = shutil.disk_usage(target.parent).free
        if size is None:
            return f": {megabytes(free)} are free"
        if size > free:
            return (
                f": it needs {megabytes(size)}, {megabytes(free)} are free, {megabytes(size - free)} are missing"
            )
        return f": it needs {megabytes(size)}"
    return ""


def megabytes(count: float) -> str:
    """Return bytes as MB, with three digits that count."""
    return f"{count / 1e6:.3g} MB" if count < 1e9 else f"{count / 1e6:.0f} MB"


def write_whole(path: Path, parts: tuple[bytes, ...]) -> None:
    """Write bytes into a new file and return when they are on the disk.

    The system's own calls, each of which lets Python's other threads run while it waits: a disk that hangs does
    not stop the supervision of an oven.

    Parameters
    ----------
    parts : tuple of bytes
        One after another.

    Raises
    ------
    OSError
        At whichever call the disk refuses.
    """
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
    try:
        for part in parts:
            left = memoryview(part)
            while left:  # a disk that is nearly full takes a part, and refuses at the next call
                left = left[os.write(handle, left) :]
        os.fsync(handle)
    except BaseException:
        with suppress(OSError):
            os.close(handle)
        raise
    os.close(handle)  # a network share may say only here that it is full


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
