"""A digest of a file's own bytes, at its head: any change after the file was written is seen before it is read.

HDF5 leaves the first 512 bytes of a file free (the user block). Flexura keeps there, as text, the
SHA-256 of all bytes after them. A reader that compares it first never hands damaged bytes to the HDF5 library,
which runs into endless loops, crashes or wrong numbers on them.
"""

import hashlib

BLOCK = 512
"""Bytes of the user block; HDF5 allows 512, 1024, 2048, ..."""
MARK = b"flexura-sealed/1 sha256 "
HDF5 = b"\x89HDF\r\n\x1a\n"


class BrokenSealError(ValueError):
    """The bytes of a file are not those that were written."""


def sealed(image: bytes) -> tuple[bytes, bytes]:
    """Return what a file consists of: its first 512 bytes, with the digest of the image, and the image.

    HDF5 finds an image that begins at byte 512 as it does one at byte 0.
    """
    return _block(hashlib.sha256(image).hexdigest()), image


def opened_seal(content: bytes) -> bool:
    """Whether the bytes of a file carry the digest they should.

    Returns
    -------
    bool
        False for an HDF5 file without one: of another program, or of a version that wrote none.

    Raises
    ------
    BrokenSealError
        Where the digest is not that of the bytes, and for what is no HDF5 file.
    """
    if content.startswith(HDF5):
        return False
    if not content.startswith(MARK):
        raise BrokenSealError("no HDF5 file" if content else "an empty file")
    if content[:BLOCK] != _block(hashlib.sha256(memoryview(content)[BLOCK:]).hexdigest()):
        raise BrokenSealError("damaged, cut short or edited: its bytes do not give the SHA-256 it carries")
    return True


def _block(digest: str) -> bytes:
    return (MARK + digest.encode() + b"\n").ljust(BLOCK, b"\0")
