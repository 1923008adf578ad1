"""An operating-system lock on an open file, which a killed process cannot leave behind."""

import sys
from typing import BinaryIO

if sys.platform == "win32":
    import msvcrt

    FAR = 1 << 30
    """The locked byte, far behind all data, because other processes cannot read it."""

    def take(file: BinaryIO) -> None:
        """Lock the file until it is closed; OSError at once if another process has locked it."""
        file.seek(FAR)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def take(file: BinaryIO) -> None:
        """Lock the file until it is closed; OSError at once if another process has locked it."""
        fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
