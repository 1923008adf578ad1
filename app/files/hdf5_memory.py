"""HDF5 in memory, never on the disk: an image to be written by plain calls, or bytes that were read by such.

Where HDF5 cannot write a file of its own, it keeps it and tries again at the next close, on memory that is no
longer there: on a full disk the program ended by SIGSEGV. And it waits for a disk that hangs with Python's
interpreter lock held, so that all threads stand still.

Images are made with HDF5's own driver for memory: under 15 limits of memory it refused without a crash, h5py's for
Python's files (`io.BytesIO`) crashed at one of them. Bytes are read through the latter, four times as fast and
without a copy: there is nothing left to write at the end, and none of 21 limits made it crash.
"""

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
