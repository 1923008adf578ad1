"""One writer at a time: an operating-system lock, which a killed process cannot leave behind."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from app.files.campaign_error import CampaignFileError, Problem

if sys.platform == "win32":
    import msvcrt

    def _take(file: BinaryIO) -> None:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _take(file: BinaryIO) -> None:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)


@contextmanager
def folder_lock(folder: Path) -> Iterator[None]:
    """Hold ``FOLDER.lock`` beside a folder that is about to be made.

    Raises
    ------
    CampaignFileError
        If another process holds it.
    """
    path = folder.with_name(folder.name + ".lock")
    with path.open("ab") as file:
        try:
            _take(file)
            if os.fstat(file.fileno()).st_ino != path.stat().st_ino:
                raise BlockingIOError(f"{path} was renewed by another process while this one opened it")
        except OSError as error:
            seen = f"another process is writing it (it holds {path.name})"
            raise CampaignFileError(folder, [Problem("", "", seen, "one writer", "wait for it to end")]) from error
        try:
            yield
        finally:
            with suppress(PermissionError):  # Windows removes no open file: an empty one stays, and harms nobody
                path.unlink()
