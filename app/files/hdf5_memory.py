"""HDF5 in memory, never on the disk: an image to be written by plain calls, or bytes that were read by such.

Where HDF5 cannot write a file of its own, it keeps it and tries again at the next close, on memory that is no
longer there: on a full disk the program ended by SIGSEGV. And it waits for a disk that hangs with Python's
interpreter lock held, so that all threads stand still. Under 15 limits of memory its driver for files in memory
refused without a crash; h5py's for Python's own files (`io.BytesIO`), which is faster, crashed at one of them.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from uuid import uuid4

import h5py
from h5py import h5f, h5p

GROWTH = 1 << 20
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
        with h5py.File(_name(), "w", driver="core", backing_store=False, block_size=GROWTH) as file:
            yield file, made
            file.flush()
            made.append(file.id.get_file_image())
    except (OSError, RuntimeError) as error:
        if "unable to allocate" in str(error):  # HDF5's own words; h5py raises OSError for whatever it says
            raise MemoryError("HDF5 was given none") from error
        raise


def opened_image(content: bytes) -> h5py.File:
    """Open the bytes of a file for reading; HDF5 makes a copy of them.

    Raises
    ------
    OSError
        For bytes of another kind, or damaged.
    """
    access = h5p.create(h5p.FILE_ACCESS)
    access.set_fapl_core(block_size=GROWTH, backing_store=False)
    access.set_file_image(content)
    return h5py.File(h5f.open(_name().encode(), h5f.ACC_RDONLY, fapl=access))


def _name() -> str:
    """Return a name of which there is no file.

    HDF5 tries to open it nevertheless, which could hang in a current folder on a lost network share: below what is
    no folder the system answers at once. Two images of one name would be one to HDF5.
    """
    return f"{os.devnull}/{uuid4()}"
