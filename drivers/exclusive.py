"""Operating-system locks that a killed process cannot leave behind: on an open file, and on a name.

A file that is locked and then removed keeps nobody out: others lock a new file of the same name. A name of Linux's
abstract sockets has no file, no owner and no folder. It is taken for all users of the computer while a socket is
bound to it, and free as soon as the last process with this socket has ended. Other systems have no such names, but
Windows does not remove a file that is open.
"""

import errno
import os
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

if sys.platform == "win32":
    import msvcrt

    FAR = 1 << 30
    """The locked byte, far behind all data, because other processes cannot read it."""

    def _take(file: BinaryIO) -> None:
        file.seek(FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _take(file: BinaryIO) -> None:
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)


LOCK_ATTEMPTS, PAUSE = 5, 0.05
"""Attempts at a lock, and s between them: whoever only looks whether it is held has it for a millisecond."""


def _patiently(lock: Callable[[], object]) -> None:
    """Try to lock, a few times; OSError of the last."""
    for left in reversed(range(LOCK_ATTEMPTS)):
        try:
            lock()
        except OSError:
            if not left:
                raise
            time.sleep(PAUSE)
        else:
            return


def take(file: BinaryIO) -> None:
    """Lock the file until it is closed, on POSIX by all processes that inherited it; OSError if it is locked."""
    _patiently(lambda: _take(file))


class NameTakenError(OSError):
    """Another process has this name."""


def take_name(name: str) -> socket.socket | None:
    """Take a name for this computer until the socket is closed, here and in all processes that inherited it.

    Parameters
    ----------
    name : str
        Up to 100 ASCII characters.

    Returns
    -------
    socket or None
        None where the system has no such names, or does not allow them.

    Raises
    ------
    NameTakenError
        If it is taken.
    """
    if sys.platform != "linux":
        return None
    try:
        bound = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    except OSError:
        return None
    try:
        _patiently(lambda: bound.bind(f"\0{name}"))
    except OSError as error:
        bound.close()
        if error.errno == errno.EADDRINUSE:
            raise NameTakenError(error.errno, f"{name} is taken") from error
        return None
    return bound


def is_still_there(file: BinaryIO, path: Path) -> bool:
    """Whether the open file is what others find at `path`, so that locking it keeps them out."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), path.lstat())
    except OSError:
        return False
