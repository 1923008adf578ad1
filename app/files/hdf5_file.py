"""An untrusted HDF5 file, opened and checked: complete, without external links, of a size that fits its bytes."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from app.files.bad_file import ResultFileError
from app.files.hdf5_contents import require_plain
from app.files.hdf5_memory import opened_image
from app.files.seal import BrokenSealError, opened_seal


class Hdf5FileError(ValueError):
    """A file cannot be read, or must not; the message says what was seen and what is allowed."""


@contextmanager
def opened_hdf5(path: Path, unsealed: Callable[[Path], None] | None = None) -> Iterator[h5py.File]:
    """Yield a file to read from, whose bytes are those that were written and whose contents are plain.

    Parameters
    ----------
    unsealed : callable, optional
        Makes sure that a file without a digest can be read at all, or raises ValueError; such files are refused
        unless it is given.

    Raises
    ------
    Hdf5FileError
        For all that is wrong with the file, and for whatever the block runs into that reads it: a file of another
        kind, or of another version.
    """
    try:
        with _in_memory(path, unsealed) as (file, size):
            require_plain(file, size)
            yield file
    except (Hdf5FileError, ResultFileError):
        raise
    except FileNotFoundError as error:
        raise Hdf5FileError("no such file") from error
    except Exception as error:
        lacks = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        raise Hdf5FileError(f"{lacks}; allowed: a file as Flexura wrote it") from error


@contextmanager
def _in_memory(path: Path, unsealed: Callable[[Path], None] | None) -> Iterator[tuple[h5py.File, int]]:
    """Yield the file, and its size in bytes; HDF5 is given the bytes that were checked, never the disk.

    It would wait for a disk that hangs with Python's interpreter lock held, and the file could change after it was
    checked.
    """
    content = path.read_bytes()
    if not opened_seal(content):
        if unsealed is None:
            raise BrokenSealError("carries no SHA-256 of its bytes: of an earlier version or another program")
        unsealed(path)
    with opened_image(content) as file:
        yield file, len(content)


@contextmanager
def result_file(path: Path, verb: str) -> Iterator[h5py.File]:
    """Yield a result to read from, see `opened_hdf5`; ResultFileError says which verb makes it again."""
    try:
        with opened_hdf5(path) as file:
            yield file
    except Hdf5FileError as error:
        message = f"{path}: not a readable {path.name}: {error}; make it again: flexura {verb}"
        raise ResultFileError(message) from error
