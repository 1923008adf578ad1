"""One writer at a time: an operating-system lock, which a killed process cannot leave behind.

What a kill leaves is the lock's file. On Linux it says which process held it, so that those who only look need not
take the lock, and a campaign that was killed is told from one that is busy.
"""

import errno
import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from app.files.campaign_error import CampaignFileError, Problem
from app.files.disk_room import UnwrittenFileError
from drivers.exclusive import take

if sys.platform == "win32":
    look = take
    """Windows has no lock that several who only look can hold at a time."""
else:
    import fcntl

    def look(file: BinaryIO) -> None:
        """Take a shared lock until the file is closed; OSError at once if a writer has locked it."""
        fcntl.flock(file.fileno(), fcntl.LOCK_SH | fcntl.LOCK_NB)


class FolderInUseError(CampaignFileError):
    """Another process writes the folder."""


@contextmanager
def writable(folder: Path) -> Iterator[None]:
    """Turn the refusal of a disk that may not be written into a CampaignFileError about `folder`."""
    try:
        yield
    except OSError as error:
        if error.errno not in (errno.EACCES, errno.EPERM, errno.EROFS, errno.EISDIR):
            raise
        seen = "" if isinstance(error, UnwrittenFileError) else "cannot be written: "
        seen += error.strerror or str(error)
        raise CampaignFileError(
            folder, [Problem("", "", seen, "a folder on a writable disk", "use --out")]
        ) from error


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold ``FOLDER.lock`` beside a folder that is about to be made.

    Raises
    ------
    FolderInUseError
        If another process holds it.
    CampaignFileError
        If it cannot be written.
    """
    path = folder.with_name(folder.name + ".lock")
    with writable(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        opened = path.open("ab")
    with opened as file:
        try:
            take(file)
            if os.fstat(file.fileno()).st_ino != path.stat().st_ino:
                raise BlockingIOError(f"{path} was renewed by another process while this one opened it")
        except OSError as error:
            seen = f"another process is writing it (it holds {path.name})"
            raise FolderInUseError(folder, [Problem("", "", seen, "one writer", "wait for it to end")]) from error
        with suppress(OSError):  # on a full disk nobody learns of a kill at once: no reason to refuse the folder
            file.truncate(0)
            file.write(json.dumps(_this_process()).encode())
            file.flush()
        try:
            yield
        finally:
            with suppress(PermissionError):  # Windows removes no open file: an empty one stays, without harm
                path.unlink()


def is_being_written(folder: Path) -> bool:
    """Whether another process holds the lock of a folder; a lock file that a kill left behind is held by none."""
    try:
        with _beside(folder).open("rb") as file:
            look(file)
    except FileNotFoundError:
        return False
    except OSError as error:
        return error.errno in (errno.EACCES, errno.EAGAIN, errno.EDEADLK)
    return False


def is_abandoned(folder: Path) -> bool:
    """Whether the process that wrote a folder is known to have ended without a word, as after ``kill -9``.

    False where that cannot be known: the process runs or ran on another computer or in another container, before
    this computer was started, or on a system without ``/proc``.
    """
    try:
        owner = json.loads(_beside(folder).read_bytes()[:LONGEST_OWNER])
        here, number, begun = owner["system"], int(owner["process"]), owner["begun"]
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return bool(here and here == _system()) and begun != _begun(number)


LONGEST_OWNER = 1000
"""Bytes; what else lies there is not ours."""


def _this_process() -> dict[str, object]:
    return {"system": _system(), "process": os.getpid(), "begun": _begun(os.getpid())}


def _system() -> str:
    """Name what numbers of processes belong to: this start of the computer, and the container; else empty."""
    try:
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
        return f"{boot} {os.readlink('/proc/self/ns/pid')}"  # noqa: PTH115 (no file is named by it)
    except (OSError, ValueError):
        return ""


def _begun(number: int) -> int | None:
    """When a process began, clock ticks since the computer's start; None for one that has ended.

    A number is used again for a later process, which began later (proc(5), ``/proc/PID/stat``, fields 3 and 22).
    """
    try:
        stat = Path(f"/proc/{number}/stat").read_bytes()
        state, *rest = stat[stat.rindex(b")") + 1 :].split()  # the name before it may hold anything
        return None if state in (b"Z", b"X") else int(rest[18])
    except (OSError, ValueError, IndexError):
        return None


def _beside(folder: Path) -> Path:
    folder = folder.resolve()
    return folder.with_name(folder.name + ".lock")
