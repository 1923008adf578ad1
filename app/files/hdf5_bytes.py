"""HDF5 as bytes: made and opened in memory, never on the disk, and sealed by a digest of them.

Where HDF5 cannot write a file of its own, it keeps it and tries again at the next close, on memory that is no
longer there: on a full disk the program ended by SIGSEGV. And it waits for a disk that hangs with Python's
interpreter lock held, so that all threads stand still.

Images are made with HDF5's own driver for memory: under 15 limits of memory it refused without a crash, h5py's for
Python's files (`io.BytesIO`) crashed at one of them. Bytes are read through the latter, four times as fast and
without a copy: there is nothing left to write at the end, and none of 21 limits made it crash.

The seal is a digest of a file's own bytes, at its head: any change after the file was written is seen before it is
read.

HDF5 leaves the first 512 bytes of a file free (the user block). Flexura keeps there, as text, the
SHA-256 of all bytes after them. A reader that compares it first never hands damaged bytes to the HDF5 library,
which runs into endless loops, crashes or wrong numbers on them.
"""

import hashlib
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager
from uuid import uuid4

import h5py

GROWTH_STEP = 1 << 20
"""Bytes by which an image grows: at HDF5's own 64 kB a large one is moved a thousand times."""


@contextmanager
def hdf5_image() -> Iterator[tuple[h5py.File, list[bytes]]]:
    """Yield a file open for writing, and a list that holds its bytes once the block has ended well.

    Raises
    ------
    MemoryError
        Where it does not fit into memory.
    """
    made: list[bytes] = []
    try:
        with h5py.File(_name(), "w", driver="core", backing_store=False, block_size=GROWTH_STEP) as file:
            yield file, made
            file.flush()
            made.append(file.id.get_file_image())
    except (OSError, RuntimeError) as error:
        if "unable to allocate" in str(error):  # HDF5's own words; h5py raises OSError for whatever it says
            raise MemoryError("HDF5 was given none") from error
        raise


def opened_image(content: bytes) -> h5py.File:
    """Open the bytes of a file for reading, without a copy of them.

    Raises
    ------
    OSError
        For bytes of another kind, or damaged.
    """
    return h5py.File(io.BytesIO(content))


def _name() -> str:
    """Return a name of which there is no file.

    HDF5 tries to open it nevertheless, which could hang in a current folder on a lost network share: below what is
    no folder the system answers at once. Two images of one name would be one to HDF5.
    """
    return f"{os.devnull}/{uuid4()}"


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
