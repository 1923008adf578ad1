"""Output that never ends the work: a closed pipe, a lost terminal or a full disk behind a redirected log.

A campaign runs for hours, and its terminal may go before it does. The streams made here take what they are given;
the first refusal is kept, for those who have to say something important.
"""

import errno
import io
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

BROKEN = frozenset({errno.EPIPE, errno.EIO, errno.EBADF, getattr(errno, "ESHUTDOWN", errno.EPIPE)})
"""Nobody is there any more: a pipe's reader has ended, a terminal was closed, a stream was closed at the start."""


class _Output(io.FileIO):
    """The end of a stream at the system; it says that it has written what nobody takes."""

    lost: OSError | None = None

    def write(self, data: Any, /) -> int:
        """Write, or note why not."""
        try:
            return super().write(data)
        except OSError as error:
            self.lost = self.lost or error
            return memoryview(data).nbytes


def lasting_streams() -> None:
    """Put streams that last in the place of `sys.stdout` and `sys.stderr`.

    Those that are no longer the process's own (a test's, a notebook's) are left as they are.
    """
    sys.stdout = _lasting(sys.stdout, 1)
    sys.stderr = _lasting(sys.stderr, 2)


def lost(stream: TextIO) -> OSError | None:
    """Return why something written to a stream was not taken; None if all was, or the stream is not ours."""
    with suppress(ValueError, OSError):
        stream.flush()
    raw = getattr(getattr(stream, "buffer", None), "raw", None)
    return raw.lost if isinstance(raw, _Output) else None


def keep_unseen(file: Path, text: str) -> None:
    """Write what could not be printed on the error stream into a file; remove the file where it could.

    For what somebody must come to know: how a campaign ended, and whether its rig is at rest.
    """
    from app.files.atomic import write_text  # it loads HDF5, for which no --help is to wait

    with suppress(OSError):  # it was the last place to say it
        if lost(sys.stderr) is not None:
            write_text(file, text + "\n")
        else:
            file.unlink(missing_ok=True)


def _lasting(stream: TextIO | None, number: int) -> TextIO:
    if stream is None:  # closed by whoever started the program; the next file opened would take its number
        handle = os.open(os.devnull, os.O_WRONLY)
        if handle != number:
            os.dup2(handle, number)
            os.close(handle)
        raw = _Output(number, "w", closefd=False)
        raw.lost = OSError(errno.EBADF, os.strerror(errno.EBADF))
        return io.TextIOWrapper(io.BufferedWriter(raw), encoding="utf-8", errors="replace", line_buffering=True)
    buffer = getattr(stream, "buffer", None)
    own = getattr(buffer, "raw", buffer)  # under PYTHONUNBUFFERED there is none between
    if type(own) is not io.FileIO or not isinstance(stream, io.TextIOWrapper) or own.fileno() != number:
        return stream
    stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_Output(number, "w", closefd=False)),
        encoding=stream.encoding,
        errors="replace",  # Windows redirects in an encoding that has no sigma
        line_buffering=stream.line_buffering or stream.write_through,
    )
