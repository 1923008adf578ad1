"""A digest of a file's own bytes, at its head: any change after the file was written is seen before it is read.

HDF5 leaves the first 512 bytes of a file free (the user block). Flexura keeps there, as text, the
SHA-256 of all bytes after them. A reader that compares it first never hands damaged bytes to the HDF5 library,
which runs into endless loops, crashes or wrong numbers on them.
"""

import hashlib
from pathlib import Path

BLOCK = 512
"""Bytes of the user block; HDF5 allows 512, 1024, 2048, ..."""
MARK = b"flexura-sealed/1 sha256 "
HDF5 = b"\x89HDF\r\n\x1a\n"


class BrokenSealError(ValueError):
    """The bytes of a file are not those that were written."""


def seal(path: Path) -> None:
    """Write the digest of a closed file into its first 512 bytes, which have to be free."""
    with path.open("r+b") as file:
        file.seek(BLOCK)
        block = _block(hashlib.file_digest(file, "sha256").hexdigest())
        file.seek(0)
        file.write(block)


def is_sealed(path: Path) -> bool:
    """Whether a file carries the digest it should.

    Returns
    -------
    bool
        False for an HDF5 file without one: of another program, or of a version that wrote none.

    Raises
    ------
    BrokenSealError
        Where the digest is not that of the bytes, and for what is no HDF5 file.
    OSError
        Where the file cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(BLOCK)
        if head.startswith(HDF5):
            return False
        if not head.startswith(MARK):
            raise BrokenSealError("no HDF5 file" if head else "an empty file")
        if head != _block(hashlib.file_digest(file, "sha256").hexdigest()):
            raise BrokenSealError("damaged, cut short or edited: its bytes do not give the SHA-256 it carries")
    return True


def _block(digest: str) -> bytes:
    return (MARK + digest.encode() + b"\n").ljust(BLOCK, b"\0")
